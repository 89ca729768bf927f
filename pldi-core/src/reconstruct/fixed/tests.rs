use super::*;
use crate::reconstruct::{self, FilterScratch, GuideTable};
use crate::{DepthRange, Frame};
use proptest::prelude::*;

const W: usize = 32;
const H: usize = 24;

/// The memory of the filter, in parts.
struct Memory {
    depth: Image<u16, W, H>,
    horizontal: Image<u8, W, H>,
    vertical: Image<u8, W, H>,
    mask: Image<u16, W, H>,
    lines: recursive::Lines<W>,
    rows: usize,
    coloured: bool,
}

impl Memory {
    fn new() -> Self {
        Self {
            depth: [[7; W]; H],
            horizontal: [[7; W]; H],
            vertical: [[7; W]; H],
            mask: [[7; W]; H],
            lines: [[[7; 4]; 2]; W],
            rows: 0,
            coloured: false,
        }
    }

    fn intake(&mut self) -> Intake<'_, W, H> {
        Intake {
            rows: &mut self.rows,
            coloured: &mut self.coloured,
            lines: &mut self.lines,
            scratch: Scratch { horizontal: &mut self.horizontal, vertical: &mut self.vertical, mask: &mut self.mask },
            depth: &mut self.depth,
        }
    }

    fn filter(&mut self, params: &FilterParams, table: &DistanceTable) {
        let mut scratch =
            Scratch { horizontal: &mut self.horizontal, vertical: &mut self.vertical, mask: &mut self.mask };
        filter(params, table, &mut scratch, &mut self.lines, &mut self.depth);
    }
}

fn fixed_of(float: &reconstruct::FilterParams, frame: &Frame<'_, W, H>) -> Box<Image<u16, W, H>> {
    let params = FilterParams::new(float).unwrap();
    let table = DistanceTable::new(&params);
    let mut memory = Box::new(Memory::new());
    memory.intake().push_frame(DepthRange::KINECT, &table, frame);
    memory.filter(&params, &table);
    Box::new(memory.depth)
}

fn float_of(params: &reconstruct::FilterParams, frame: &Frame<'_, W, H>) -> Box<Image<f32, W, H>> {
    let mut depth = Box::new([[0.0; W]; H]);
    let mut scratch = Box::new(FilterScratch::new());
    let table = GuideTable::new(params);
    reconstruct::reconstruct(frame, DepthRange::KINECT, params, &table, &mut scratch, &mut depth);
    depth
}

fn params(kind: FilterKind) -> reconstruct::FilterParams {
    reconstruct::FilterParams { kind, ..reconstruct::FilterParams::DEFAULT }
}

#[test]
fn a_constant_depth_stays_with_its_holes_filled() {
    let mut depth = [[1234; W]; H];
    depth[5][7] = 0;
    depth[0][0] = 0;
    let out = fixed_of(&params(FilterKind::Bilateral), &Frame { depth: &depth, colour: None });
    assert!(out.as_flattened().iter().all(|d| *d == 1234 * 8));
}

#[test]
fn nothing_stays_nothing_and_far_depths_saturate() {
    let out = fixed_of(&params(FilterKind::Joint), &Frame { depth: &[[0; W]; H], colour: None });
    assert!(out.as_flattened().iter().all(|d| *d == 0));
    let out = fixed_of(&params(FilterKind::Joint), &Frame { depth: &[[9_999; W]; H], colour: None });
    assert!(out.as_flattened().iter().all(|d| *d == u16::MAX));
    let out = fixed_of(&params(FilterKind::None), &Frame { depth: &[[10_001; W]; H], colour: None });
    assert!(out.as_flattened().iter().all(|d| *d == 0));
}

#[test]
fn the_exact_filter_is_refused() {
    assert!(FilterParams::new(&params(FilterKind::Exact)).is_err());
    assert!(
        FilterParams::new(&reconstruct::FilterParams { sigma_depth: f32::NAN, ..params(FilterKind::Joint) }).is_err()
    );
}

#[test]
fn disparities_become_depths() {
    let model = Disparity::KINECT;
    assert_eq!([2047, 1090, 1089, 0].map(|d| model.millimetres(d)), [0, 0, 0, 319]);
    // 348,000 / (1090 - 916) = 2000 mm.
    assert_eq!(model.millimetres(916), 2000);
}

/// What comes out of rows in a sensor's format at `k` times the frame's size, pixel by pixel of a constant colour.
fn colour_of(row: ColourRow<'_>) -> [u8; 3] {
    let mut out = [[7; 3]; W];
    row.decode(row.check(W).unwrap(), &mut out);
    assert!(out.iter().all(|c| *c == out[0]));
    out[0]
}

#[test]
fn every_colour_format_is_read() {
    let rgb: Vec<u8> = [200, 100, 50].repeat(W);
    assert_eq!(colour_of(ColourRow::Rgb888(&[&rgb])), [200, 100, 50]);
    assert_eq!(colour_of(ColourRow::Rgb565(&[&[0xF800; W]])), [255, 0, 0]);
    assert_eq!(colour_of(ColourRow::Rgb565(&[&[0x07E0; 2 * W], &[0; 2 * W]])), [0, 128, 0]);
    let grey: Vec<u8> = [126, 128, 126, 128].repeat(W / 2);
    assert_eq!(colour_of(ColourRow::Yuyv(&[&grey])), [128; 3]);
    let red: Vec<u8> = [81, 90, 81, 240].repeat(W / 2);
    assert_eq!(colour_of(ColourRow::Yuyv(&[&red])), [255, 0, 0]);
    let (upper, lower): (Vec<u8>, Vec<u8>) = ([101, 200].repeat(W), [50, 100].repeat(W));
    assert_eq!(colour_of(ColourRow::Bayer(&[&upper, &lower], Bayer::Grbg)), [200, 101, 50]);
    assert_eq!(colour_of(ColourRow::Bayer(&[&lower, &upper], Bayer::Bggr)), [200, 101, 50]);
}

#[test]
fn rows_of_another_length_are_refused_and_do_not_count() {
    let mut memory = Box::new(Memory::new());
    let table = DistanceTable::new(&FilterParams::new(&params(FilterKind::Joint)).unwrap());
    let mut intake = memory.intake();
    let mut push =
        |depth: &[u16], colour| intake.push(DepthRange::KINECT, &table, DepthRow::Millimetres(depth), colour);
    assert!(push(&[0; W + 1], None).is_err() && push(&[], None).is_err());
    assert!(push(&[0; W], Some(ColourRow::Rgb888(&[]))).is_err());
    assert!(push(&[0; W], Some(ColourRow::Rgb888(&[&[0; 3 * W], &[0; 3 * W]]))).is_err());
    assert!(push(&[0; W], Some(ColourRow::Bayer(&[&[0; W]], Bayer::Rggb))).is_err());
    for _ in 0..H {
        push(&[0; 2 * W], None).unwrap();
    }
    assert_eq!(push(&[0; W], None), Err(Error::OutOfRange("row of the frame (the frame is complete)")));
}

fn scene() -> impl Strategy<Value = (Vec<u16>, Vec<u8>)> {
    let depth = prop_oneof![4 => 500u16..8000, 1 => Just(0u16), 2 => 2000u16..2030];
    (proptest::collection::vec(depth, W * H), proptest::collection::vec(any::<u8>(), 3 * W * H), 0u8..5).prop_map(
        |(mut depth, mut colour, smooth)| {
            // Neighbours alike, as in images: else every distance is beyond the table.
            for i in 1..depth.len() {
                if i % usize::from(smooth + 1) > 0 {
                    depth[i] = depth[i - 1].saturating_add((i % 3) as u16);
                    for c in 0..3 {
                        colour[3 * i + c] = colour[3 * (i - 1) + c].saturating_add((i % 2) as u8);
                    }
                }
            }
            (depth, colour)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// But for pixels at which hardly a reading arrives: there, weights below 1/30,000 tell between surfaces metres apart,
    /// and the largest distance that a code stands for cuts them off.
    #[test]
    fn the_float_filter_is_within_a_millimetre((depth, colour) in scene(), joint in any::<bool>()) {
        let frame = Frame::<W, H>::new(&depth, Some(&colour)).unwrap();
        let params = params(if joint { FilterKind::Joint } else { FilterKind::Bilateral });
        let (fixed, float) = (fixed_of(&params, &frame), float_of(&params, &frame));
        let pixels = fixed.as_flattened().iter().zip(float.as_flattened());
        let off = pixels.filter(|(a, b)| (f32::from(**a) / 8.0 - **b * 1000.0).abs() > 1.0).count();
        prop_assert!(off <= W * H / 100, "{off}");
    }

    #[test]
    fn pushed_rows_give_the_bits_of_a_whole_frame((depth, colour) in scene(), joint in any::<bool>()) {
        let kind = if joint { FilterKind::Joint } else { FilterKind::Bilateral };
        let fixed = FilterParams::new(&params(kind)).unwrap();
        let table = DistanceTable::new(&fixed);
        let mut memory = Box::new(Memory::new());
        for (d, c) in depth.chunks(W).zip(colour.chunks(3 * W)) {
            // A new borrow for each row, as between interrupts.
            let rows = [c];
            memory.intake().push(DepthRange::KINECT, &table, DepthRow::Millimetres(d), Some(ColourRow::Rgb888(&rows))).unwrap();
        }
        memory.filter(&fixed, &table);
        let frame = Frame::<W, H>::new(&depth, Some(&colour)).unwrap();
        prop_assert_eq!(&memory.depth, &*fixed_of(&params(kind), &frame));
    }
}
