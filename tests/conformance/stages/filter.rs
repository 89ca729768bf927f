//! The fixed-point filter and its memory.

use crate::inputs::{H, W};
use pldi_core::reconstruct::fixed::recursive::Lines;
use pldi_core::reconstruct::fixed::{DistanceTable, FilterParams, Intake, Scratch, filter};
use pldi_core::reconstruct::{self, FilterKind};
use pldi_core::{DepthRange, Frame, Image};

/// What the filter works on.
pub struct Memory {
    depth: Image<u16, W, H>,
    horizontal: Image<u8, W, H>,
    vertical: Image<u8, W, H>,
    mask: Image<u16, W, H>,
    lines: Lines<W>,
    rows: usize,
    coloured: bool,
    depths: [[u16; W]; 2],
    colours: [[[u8; 3]; W]; 2],
}

impl Memory {
    /// Empty memory.
    pub fn new() -> Self {
        Self {
            depth: [[0; W]; H],
            horizontal: [[0; W]; H],
            vertical: [[0; W]; H],
            mask: [[0; W]; H],
            lines: [[[0; 4]; 2]; W],
            rows: 0,
            coloured: false,
            depths: [[0; W]; 2],
            colours: [[[0; 3]; W]; 2],
        }
    }

    /// The depth in 1/8 mm.
    pub fn reconstruct(&mut self, frame: &Frame<'_, W, H>, kind: FilterKind) -> &Image<u16, W, H> {
        let params = reconstruct::FilterParams { kind, ..reconstruct::FilterParams::DEFAULT };
        let params = FilterParams::new(&params).expect("parameters within the ranges");
        let table = DistanceTable::new(&params);
        let Self { depth, horizontal, vertical, mask, lines, rows, coloured, depths, colours } = self;
        let (depths, colours) = (depths.each_mut(), colours.each_mut());
        // The filter without colour is guided by depth alone.
        let frame = Frame { depth: frame.depth, colour: frame.colour.filter(|_| kind == FilterKind::Joint) };
        let scratch = Scratch { horizontal, vertical, mask };
        Intake { rows, coloured, depths, colours, scratch, depth }.push_frame(DepthRange::KINECT, &table, &frame);
        filter(&params, &table, &mut Scratch { horizontal, vertical, mask }, lines, depth);
        &self.depth
    }
}
