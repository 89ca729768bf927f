//! Images of a recording.

use pldi_host::input::{MAX_FACTOR, fuzz, reduce};

pub fn image(bytes: &[u8]) {
    let factor = |w: u16, h: u16| (1..=MAX_FACTOR).find(|k| (w, h) == (320 * k, 240 * k));
    match fuzz::colour(bytes) {
        Ok((w, h, rgb)) => {
            let pixels = usize::from(w) * usize::from(h);
            assert_eq!(rgb.len(), 3 * pixels);
            if let Some(k) = factor(w, h) {
                let (depth, rgb) = reduce(&vec![1000; pixels], &rgb, k);
                assert_eq!((depth.len(), rgb.len()), (320 * 240, 3 * 320 * 240));
            }
        }
        Err(error) => super::refused(&error, "colour"),
    }
    match fuzz::depth(bytes) {
        Ok((w, h, depth)) => {
            let pixels = usize::from(w) * usize::from(h);
            assert_eq!(depth.len(), pixels);
            if let Some(k) = factor(w, h) {
                let (depth, rgb) = reduce(&depth, &vec![0; 3 * pixels], k);
                assert_eq!((depth.len(), rgb.len()), (320 * 240, 3 * 320 * 240));
            }
        }
        Err(error) => super::refused(&error, "depth"),
    }
}
