//! Colour and depth images of two streams, by their stamps.

use pldi_host::input::Stamp;
use pldi_host::input::pair::Pairer;

/// A bound and a spacing, then images: a byte that says which, and how far its stamp lies from the last one.
pub fn pairs(bytes: &[u8]) {
    let Some((&[options, spacing], mut rest)) = bytes.split_first_chunk() else { return };
    let mut pairer = if options & 1 == 0 { Pairer::new(usize::from(options) % 16) } else { Pairer::depth_only() }
        .spaced(i64::from(spacing) << (options / 8 * 2).min(56));
    let (mut stamp, mut colours, mut depths, mut frames) = (0i64, 0u64, 0u64, 0u64);
    let mut left_out = 0;
    loop {
        let more = rest.split_first();
        match more {
            Some((&what, after)) => {
                rest = after;
                let mut step = |count: usize| {
                    let (taken, after) = rest.split_at(count.min(rest.len()));
                    rest = after;
                    let mut wide = [0; 8];
                    wide[..taken.len()].copy_from_slice(taken);
                    i64::from_le_bytes(wide)
                };
                stamp = match what / 4 % 4 {
                    // Any, 1 ms, 1 s at most, back and forth.
                    0 => step(8),
                    1 => stamp.wrapping_add(step(1) * 1_000_000),
                    2 => stamp.wrapping_add(step(4)),
                    _ => stamp.wrapping_sub(step(4)),
                };
                match what % 2 {
                    0 => {
                        pairer.push_colour(Stamp(stamp), colours);
                        colours += 1;
                    }
                    _ => {
                        pairer.push_depth(Stamp(stamp), depths);
                        depths += 1;
                    }
                }
            }
            None => pairer.end(),
        }
        while let Some((depth_stamp, depth, colour)) = pairer.pop() {
            frames += 1;
            assert!(depth < depths && colour.is_some() == (options & 1 == 0));
            if let Some((colour_stamp, colour)) = colour {
                assert!(colour < colours && colour_stamp.apart(depth_stamp) < 20_000_000);
            }
        }
        left_out += pairer.take_left_out().depth;
        if more.is_none() {
            break;
        }
    }
    // No depth image is lost without being counted.
    assert_eq!(frames + left_out, depths);
}
