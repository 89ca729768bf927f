//! Outer borders of the occupied regions of a ground map, by border following (Suzuki and Abe 1985, algorithm 2:
//! outermost borders only), and their interiors.
//!
//! Cells outside of the map count as empty all round, so a region that touches the map's edge is found like any other.
//! Regions are 8-connected. What lies inside a border, holes and the regions in them included, belongs to it.

use super::{CELL, MAP_DEPTH, MAP_WIDTH, MAX_CLUSTERS, MAX_CONTOUR_POINTS, Map};
use crate::Error;
use heapless::Vec;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A cell on a contour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct ContourPoint {
    /// Column of the cell.
    pub column: u8,
    /// Row of the cell.
    pub row: u8,
}

const _: () = assert!(MAP_WIDTH <= 256 && MAP_DEPTH <= 256 && MAX_CLUSTERS < 255);
// Starts, numbers of points and steps are u16.
const _: () = assert!(MAX_CONTOUR_POINTS <= u16::MAX as usize);

/// An outer border: a range of the frame's contour points, in order, and what it encloses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contour {
    /// Index of the first point.
    pub start: u16,
    /// Number of points (a thin part is passed twice).
    pub points: u16,
    /// Cells on the border and inside of it.
    pub cells: u32,
    /// Steps to a cell beside, above or below on the way through the cells' centres.
    pub straight: u16,
    /// Diagonal steps on that way.
    pub diagonal: u16,
}

impl Contour {
    /// Area in m^2.
    pub fn area(&self) -> f32 {
        self.cells as f32 * (CELL * CELL)
    }

    /// Length of the way through the cells' centres, in metres.
    pub fn length(&self) -> f32 {
        let cells = f32::from(self.straight) + core::f32::consts::SQRT_2 * f32::from(self.diagonal);
        cells * CELL
    }

    /// The contour's points out of those of the frame.
    pub fn of<'a>(&self, points: &'a [ContourPoint]) -> &'a [ContourPoint] {
        let start = usize::from(self.start);
        points.get(start..start + usize::from(self.points)).unwrap_or(&[])
    }
}

/// The contour's cell is occupied.
pub(super) const OCCUPIED: u8 = 1;
/// The border passes on the cell's left side.
const LEFT: u8 = 2;
/// The border passes on the cell's right side.
const RIGHT: u8 = 4;

/// Neighbours counter-clockwise as seen with rows growing downwards, starting at the right: (column, row) steps.
const STEPS: [(i32, i32); 8] = [(1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1), (1, 1)];
/// Direction of the right neighbour in [`STEPS`].
const EAST: usize = 0;
/// Direction of the left neighbour in [`STEPS`].
const WEST: usize = 4;

/// Room for a frame's contour points in memory that the caller owns, filled from the start.
struct Points<'a> {
    slots: &'a mut [ContourPoint],
    len: usize,
}

impl Points<'_> {
    fn push(&mut self, column: i32, row: i32) -> Result<(), Full> {
        let slot = self.slots.get_mut(self.len).ok_or(Full)?;
        *slot = ContourPoint { column: column as u8, row: row as u8 };
        self.len += 1;
        Ok(())
    }
}

/// There is no room for another point.
struct Full;

/// How many points all contours have together: they fill the points from the start, one after the other.
pub fn point_count(contours: &[Contour]) -> usize {
    contours.last().map_or(0, |last| usize::from(last.start) + usize::from(last.points))
}

/// Finds the outer borders of the occupied cells: those whose mark is 1; the others' is 0 (see `density::occupied`).
///
/// `labels` receives the number (1, 2, ... in the order of `contours`) of the contour that each cell lies in, 0 for none;
/// `points` the contours' points ([`point_count`] of them). `marks` is scratch afterwards.
///
/// # Errors
/// `Capacity("clusters")` or `Capacity("contour points")`; what was found until then is complete.
pub fn find(
    marks: &mut Map<u8>,
    labels: &mut Map<u8>,
    contours: &mut Vec<Contour, MAX_CLUSTERS>,
    points: &mut [ContourPoint],
) -> Result<(), Error> {
    contours.clear();
    labels.as_flattened_mut().fill(0);
    // More could not be numbered.
    let room = points.len().min(MAX_CONTOUR_POINTS);
    let mut points = Points { slots: points.get_mut(..room).unwrap_or_default(), len: 0 };
    let mut next = 0;
    while let Some(cell) = occupied_from(marks, next) {
        next = cell + 1;
        let (row, column) = ((cell / MAP_WIDTH) as i32, (cell % MAP_WIDTH) as i32);
        let labelled = labels.as_flattened().get(cell).is_none_or(|label| *label != 0);
        if labelled || occupied(marks, column - 1, row) {
            continue;
        }
        let start = points.len;
        let label = contours.len() as u8 + 1;
        let Ok(path) = follow(marks, column, row, &mut points) else {
            return Err(Error::Capacity("contour points"));
        };
        let contour = Contour {
            start: start as u16,
            points: (points.len - start) as u16,
            cells: fill(marks, labels, label, path.bounds),
            straight: path.straight,
            diagonal: path.diagonal,
        };
        if contours.push(contour).is_err() {
            erase(labels, label);
            return Err(Error::Capacity("clusters"));
        }
    }
    Ok(())
}

/// The first occupied cell from `first` on, in raster order.
fn occupied_from(marks: &Map<u8>, first: usize) -> Option<usize> {
    let rest = marks.as_flattened().get(first..)?;
    // Most of the map is empty: eight cells at once.
    let (eights, _) = rest.as_chunks::<8>();
    let empty = 8 * eights.iter().take_while(|eight| u64::from_ne_bytes(**eight) == 0).count();
    Some(first + empty + rest.get(empty..)?.iter().position(|mark| *mark != 0)?)
}

/// Smallest column and row, largest column and row.
type Bounds = [i32; 4];

/// A border that was followed. It has as many steps as points, or none: u16 holds them.
struct Path {
    straight: u16,
    diagonal: u16,
    bounds: Bounds,
}

/// Whether a cell is occupied; cells outside of the map are not.
#[inline(always)]
fn occupied(marks: &Map<u8>, column: i32, row: i32) -> bool {
    usize::try_from(row)
        .ok()
        .and_then(|r| marks.get(r))
        .is_some_and(|line| usize::try_from(column).ok().and_then(|c| line.get(c)).is_some_and(|mark| *mark != 0))
}

fn mark(marks: &mut Map<u8>, column: i32, row: i32, side: u8) {
    if let Some(mark) = marks.get_mut(row as usize).and_then(|line| line.get_mut(column as usize)) {
        *mark |= side;
    }
}

/// Follows the outer border from its first cell in raster order, whose left neighbour is empty; marks which sides of
/// the cells it passes.
fn follow(marks: &mut Map<u8>, column: i32, row: i32, points: &mut Points<'_>) -> Result<Path, Full> {
    let mut bounds = [column, row, column, row];
    mark(marks, column, row, LEFT);
    // Clockwise from the left neighbour: the cell from which the border comes back to its start.
    let Some(last) = (0..8).map(|i| (WEST + 8 - i) % 8).find(|d| {
        let (dx, dy) = STEPS[*d];
        occupied(marks, column + dx, row + dy)
    }) else {
        mark(marks, column, row, RIGHT);
        points.push(column, row)?;
        return Ok(Path { straight: 0, diagonal: 0, bounds });
    };
    let end = (column + STEPS[last].0, row + STEPS[last].1);
    let (mut here, mut from) = ((column, row), last);
    let (mut straight, mut diagonal) = (0u16, 0u16);
    loop {
        points.push(here.0, here.1)?;
        bounds = [bounds[0].min(here.0), bounds[1].min(here.1), bounds[2].max(here.0), bounds[3].max(here.1)];
        // Counter-clockwise from where the border came, to the next occupied cell. `from` itself is occupied, so the
        // search ends there at the latest.
        let mut direction = from;
        for i in 1..=8 {
            direction = (from + i) % 8;
            let (dx, dy) = STEPS[direction];
            if occupied(marks, here.0 + dx, here.1 + dy) {
                break;
            }
            match direction {
                EAST => mark(marks, here.0, here.1, RIGHT),
                WEST => mark(marks, here.0, here.1, LEFT),
                _ => {}
            }
        }
        if direction % 2 == 0 {
            straight += 1;
        } else {
            diagonal += 1;
        }
        let next = (here.0 + STEPS[direction].0, here.1 + STEPS[direction].1);
        if next == (column, row) && here == end {
            return Ok(Path { straight, diagonal, bounds });
        }
        (here, from) = (next, (direction + 4) % 8);
    }
}

/// Labels what lies within a border: along a row, from each left side that it passes to the next right side.
fn fill(marks: &Map<u8>, labels: &mut Map<u8>, label: u8, [left, top, right, bottom]: Bounds) -> u32 {
    let mut cells = 0;
    let (rows, columns) = (top as usize..=bottom as usize, left as usize..=right as usize);
    let lines = marks.get(rows.clone()).into_iter().flatten().zip(labels.get_mut(rows).into_iter().flatten());
    for (marks, labels) in lines {
        let mut inside = false;
        let (Some(marks), Some(line)) = (marks.get(columns.clone()), labels.get_mut(columns.clone())) else {
            continue;
        };
        for (mark, cell) in marks.iter().zip(line) {
            let foreign = *cell != 0;
            let sides = if foreign { 0 } else { *mark };
            inside |= sides & LEFT != 0;
            if inside && !foreign {
                *cell = label;
                cells += 1;
            }
            if sides & RIGHT != 0 {
                inside = false;
            }
        }
    }
    cells
}

fn erase(labels: &mut Map<u8>, label: u8) {
    labels.as_flattened_mut().iter_mut().filter(|l| **l == label).for_each(|l| *l = 0);
}

#[cfg(test)]
mod tests;
