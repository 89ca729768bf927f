use std::sync::Mutex;

use embedded_graphics::pixelcolor::RgbColor;
use pldi_core::Intrinsics;
use pldi_core::pipeline::Params;
use pldi_core::templates::Templates;

use super::*;
use crate::input::{DepthScale, Images, Input, OpenOptions, RawFrame, Source, Stamp, Stop};
use crate::runner;
use crate::{ArithmeticKind, Error};

/// A box at 3 m on a floor before a wall at 5 m, or nothing at all.
struct Toy {
    empty: bool,
    shown: bool,
}

impl Source for Toy {
    fn next(&mut self, _: &Stop) -> Result<Option<RawFrame>, Error> {
        if std::mem::replace(&mut self.shown, true) {
            return Ok(None);
        }
        let intrinsics = Intrinsics::PRIMESENSE_QVGA;
        let depth = |i: usize| {
            let (u, v) = (i % 320, i / 320);
            let down = (v as f32 - intrinsics.cy) / intrinsics.fy;
            let floor = if down > 0.0 { 1.0 / down } else { f32::INFINITY };
            let object = (120..200).contains(&u) && v > 120 && floor > 3.0;
            let z = if object { 3.0 } else { floor.min(5.0) };
            if self.empty { 0 } else { (z * 1000.0) as u16 }
        };
        let depth = (0..320 * 240).map(depth).collect();
        let images = Images { size: (320, 240), depth, scale: DepthScale::Millimetres, colour: None };
        Ok(Some(RawFrame {
            stamp: Stamp(500_000_000),
            colour_stamp: None,
            name: "toy".to_owned(),
            frame_id: None,
            camera: None,
            dropped: 0,
            images: Box::new(|| Ok(images)),
        }))
    }
}

fn drawn(toy: Toy, arithmetic: ArithmeticKind) -> (FrameReport, Canvas) {
    let bytes = crate::templates::for_arithmetic(crate::templates::EMBEDDED.into(), arithmetic).unwrap();
    let set = Templates::parse(&bytes).unwrap();
    let params = Params { view: *set.view_params(), ..Params::DEFAULT };
    let result = Mutex::new(None);
    let look = |p: &mut Processed<'_>| Ok(draw(p, &set));
    let sink = |_: usize, r: Result<runner::FrameResult<Canvas>, Error>| {
        *result.lock().unwrap() = Some(r?);
        Ok::<_, Error>(true)
    };
    let input = Input::new(Box::new(toy), &OpenOptions::default()).unwrap();
    let job = runner::Job { arithmetic, params: &params, templates: &set, threads: 1, stop: &Stop::default() };
    runner::run(input, &job, look, sink).unwrap();
    let result = result.into_inner().unwrap().unwrap();
    (result.report, result.extra)
}

fn count(canvas: &Canvas, colour: Rgb888, columns: std::ops::Range<usize>) -> usize {
    let pixels = canvas.pixels().as_chunks::<3>().0;
    let width = SIZE.0 as usize;
    let same =
        |(i, p): &(usize, &[u8; 3])| columns.contains(&(i % width)) && **p == [colour.r(), colour.g(), colour.b()];
    pixels.iter().enumerate().filter(same).count()
}

#[test]
fn a_candidate_has_its_colour_on_both_sides() {
    for arithmetic in [ArithmeticKind::Float, ArithmeticKind::Fixed] {
        let (report, canvas) = drawn(Toy { empty: false, shown: false }, arithmetic);
        assert_eq!((report.detections.len(), report.arithmetic), (1, arithmetic), "{report:?}");
        assert_eq!(canvas.dimensions(), SIZE);
        assert!(count(&canvas, COLOURS[0], 0..640) > 300);
        assert!(count(&canvas, COLOURS[0], 640..1152) > 100);
        assert_eq!(count(&canvas, COLOURS[1], 0..1152), 0);
        let decoded = image::load_from_memory(&canvas.to_png().unwrap()).unwrap().into_rgb8();
        assert_eq!(decoded.as_raw(), canvas.pixels());
    }
}

#[test]
fn a_frame_without_a_floor_says_so_and_nothing_more() {
    let (report, canvas) = drawn(Toy { empty: true, shown: false }, ArithmeticKind::Fixed);
    assert!(report.floor.is_none() && report.detections.is_empty());
    assert_eq!(COLOURS.iter().map(|c| count(&canvas, *c, 0..1152)).sum::<usize>(), 0);
}
