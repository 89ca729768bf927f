//! The distances of a row from arrays of its depths and colours: the form for machines with instructions for several
//! numbers at once.

use super::intake::{ColourRow, DepthRow, Output, decode_depth};
use super::recursive::Lines;
use super::{DistanceTable, eighths};
use crate::{DepthRange, Error};
use zerocopy::{FromBytes, IntoBytes};

/// Takes in row `v`: depth into `out.depth` (1/8 mm), distances into the others. The topmost row's distances from above mean
/// nothing. `coloured` says whether the row above had colour.
///
/// # Errors
/// `PixelCount` for a depth row of another length than a multiple of the frame's; then nothing has changed. The colour row
/// has been checked: it has `k` times the frame's width.
pub fn row<const W: usize>(
    (range, table): (DepthRange, &DistanceTable),
    depth: DepthRow<'_>,
    colour: Option<(ColourRow<'_>, usize)>,
    (v, coloured): (usize, bool),
    lines: &mut Lines<W>,
    out: Output<'_, W>,
) -> Result<(), Error> {
    // The last row and this one: twice 2 and 3 bytes of the 32 for each.
    let Ok(([above_depth, here_depth], rest)) = <[[u16; W]; 2]>::mut_from_prefix(lines.as_mut_bytes()) else {
        return Ok(());
    };
    let Ok(([above_colour, here_colour], _)) = <[[[u8; 3]; W]; 2]>::mut_from_prefix(rest) else { return Ok(()) };
    decode_depth(depth, here_depth)?;
    for mm in here_depth.iter_mut() {
        *mm = range.apply(*mm);
    }
    if let Some((colour, k)) = &colour {
        colour.decode(*k, here_colour);
    }
    for (to, mm) in out.depth.iter_mut().zip(here_depth.iter()) {
        *to = eighths(range, *mm);
    }
    let both = colour.is_some() && coloured && v > 0;
    table.codes([here_depth, above_depth], both.then_some([&*here_colour, &*above_colour]), out.vertical);
    // The row itself, shifted by one, in the place of the row above, which has served.
    shift(here_depth, above_depth);
    shift(here_colour, above_colour);
    let colours = colour.is_some().then_some([&*here_colour, &*above_colour]);
    table.codes([here_depth, above_depth], colours, out.horizontal);
    *above_depth = *here_depth;
    *above_colour = *here_colour;
    Ok(())
}

/// Each value's left neighbour; the first one's is itself.
fn shift<T: Copy, const W: usize>(row: &[T; W], left: &mut [T; W]) {
    if let ([first, rest @ ..], [.., _]) = (&mut left[..], &row[..]) {
        *first = row[0];
        rest.copy_from_slice(&row[..rest.len()]);
    }
}
