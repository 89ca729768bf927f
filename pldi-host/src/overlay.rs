//! A frame's result as a picture: the image with the outlines of all clusters to the left, the map of the floor to the
//! right, in the same colours. Candidates have colours of their own; rejected clusters are thin and grey.

mod camera;
mod canvas;
mod floor;
mod text;

use embedded_graphics::pixelcolor::{Rgb888, RgbColor as _};
use pldi_core::templates::Templates;

pub use canvas::Canvas;

use crate::report::{DetectionReport, FrameReport};
use crate::runner::Processed;

/// Width and height of every picture in pixels, whatever the size of the recording's images.
pub const SIZE: (u32, u32) = (camera::WIDTH + floor::WIDTH, camera::HEIGHT);

/// Easily told from each other, and bright enough for photographs and the dark map.
const COLOURS: [Rgb888; 10] = [
    Rgb888::new(255, 176, 0),
    Rgb888::new(0, 205, 255),
    Rgb888::new(255, 85, 165),
    Rgb888::new(125, 235, 60),
    Rgb888::new(170, 140, 255),
    Rgb888::new(255, 115, 60),
    Rgb888::new(0, 235, 175),
    Rgb888::new(255, 240, 80),
    Rgb888::new(95, 155, 255),
    Rgb888::new(235, 125, 255),
];

/// Rejected clusters.
const GREY: Rgb888 = Rgb888::new(165, 165, 165);

/// The colour of the cluster of index `cluster`: candidates take the colours in turn; `None` for rejected ones.
fn colour_of(report: &FrameReport, cluster: usize) -> Option<Rgb888> {
    let rank = report.detections.iter().position(|d| d.id == cluster.wrapping_add(1))?;
    Some(COLOURS[rank % COLOURS.len()])
}

/// The colour of a candidate in all pictures: red, green, blue.
pub(crate) fn candidate_colour(report: &FrameReport, detection: &DetectionReport) -> [u8; 3] {
    let colour = colour_of(report, detection.id.wrapping_sub(1)).unwrap_or(GREY);
    [colour.r(), colour.g(), colour.b()]
}

/// Draws a processed frame; `templates` are those it was compared with.
pub fn draw(processed: &Processed<'_>, templates: &Templates<'_>) -> Canvas {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1);
    camera::draw(&mut canvas, processed);
    floor::draw(&mut canvas, processed, templates);
    canvas
}

#[cfg(test)]
mod tests;
