//! The right half: the map of the floor, seen from above, the camera at the bottom.

use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, Line, PrimitiveStyle, Rectangle, Triangle};
use pldi_core::ground::{CELL, MAP_DEPTH, MAP_WIDTH, SensoryArea};
use pldi_core::templates::Templates;

use super::text::{self, LABEL_HEIGHT, Labels};
use super::{Canvas, GREY, camera, colour_of};
use crate::runner::Processed;

/// Width of this part in pixels.
pub(super) const WIDTH: u32 = SCALE as u32 * MAP_WIDTH as u32;
/// Pixels per cell.
const SCALE: i32 = 2;
/// Pixels per metre.
const METRE: f32 = SCALE as f32 / CELL;
/// First column of this part.
const LEFT: i32 = camera::WIDTH as i32;
/// First row of the map; above it stand the frame's numbers.
const TOP: i32 = BOTTOM - SCALE * MAP_DEPTH as i32;
/// The row below the last.
const BOTTOM: i32 = camera::HEIGHT as i32;

const GROUND: Rgb888 = Rgb888::new(22, 22, 26);
const RINGS: Rgb888 = Rgb888::new(66, 70, 80);
const RING_NAMES: Rgb888 = Rgb888::new(130, 136, 150);
const AREA: Rgb888 = Rgb888::new(90, 120, 160);
const WORDS: Rgb888 = Rgb888::new(225, 225, 225);

/// Width of a ring's name in pixels.
const RING_NAME: u32 = 28;

/// What is added to the ground where the map is densest; the contours are brighter.
const LIGHTEST: f32 = 105.0;

/// Cells from which a cluster is large enough to carry its number; smaller ones have it above them.
const CARRIES_NUMBER: u32 = 300;

/// Fewest cells of a rejected cluster whose number is written.
const WORTH_A_NUMBER: u32 = 100;

/// Draws the frame's numbers and, where the frame has a floor, the map.
pub(super) fn draw(canvas: &mut Canvas, processed: &Processed<'_>, templates: &Templates<'_>) {
    let whole = Rectangle::new(Point::new(LEFT, 0), Size::new(WIDTH, BOTTOM as u32));
    let Ok(()) = whole.into_styled(PrimitiveStyle::with_fill(GROUND)).draw(canvas);
    head(canvas, processed, templates);
    let Some(floor) = &processed.workspace.report.floor else { return };
    let engine = &*processed.engine;
    density(canvas, processed);
    let area = SensoryArea::new(&engine.params().area, engine.intrinsics(), floor);
    rings(canvas, &area);
    contours(canvas, processed);
    sensor(canvas);
}

/// The pixel of a point of the floor (right, forward in metres).
fn pixel([right, forward]: [f32; 2]) -> Point {
    let x = LEFT as f32 + 0.5 * WIDTH as f32 + right * METRE;
    let y = BOTTOM as f32 - forward * METRE;
    Point::new(libm::floorf(x) as i32, libm::floorf(y) as i32)
}

fn head(canvas: &mut Canvas, processed: &Processed<'_>, templates: &Templates<'_>) {
    let report = processed.report;
    let floor = match &processed.workspace.report.floor {
        Some(f) => {
            format!("camera {:.2} m above the floor, looking down {:.0}\u{b0}", f.height, f.pitch().to_degrees())
        }
        None => "no floor found".to_owned(),
    };
    let (n, m) = (report.detections.len(), report.rejected.len());
    let lines = [
        format!("frame {}   {:.3} s", report.frame, report.stamp),
        floor,
        format!("candidates: {n}   rejected: {m}   templates: {}", templates.len()),
    ];
    for (i, line) in lines.iter().enumerate() {
        text::write(canvas, line, LEFT + 10, 8 + 17 * i as i32, WORDS);
    }
}

/// The density in grey, white from four times the threshold on.
fn density(canvas: &mut Canvas, processed: &Processed<'_>) {
    let white = 4.0 * processed.engine.params().density.threshold.max(1e-6);
    for (row, line) in processed.workspace.images.density.iter().enumerate() {
        for (column, &density) in line.iter().enumerate() {
            let light = (density / white).clamp(0.0, 1.0) * LIGHTEST;
            if light >= 1.0 {
                let colour = [GROUND.r(), GROUND.g(), GROUND.b()].map(|c| c.saturating_add(light as u8));
                fill(canvas, column, row, colour);
            }
        }
    }
}

fn fill(canvas: &mut Canvas, column: usize, row: usize, colour: [u8; 3]) {
    let (x, y) = (LEFT + SCALE * column as i32, BOTTOM - SCALE * (row as i32 + 1));
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        canvas.set(x + dx, y + dy, colour);
    }
}

/// A ring for each metre, and the sensory area.
fn rings(canvas: &mut Canvas, area: &SensoryArea) {
    let map = Rectangle::new(Point::new(LEFT, TOP), Size::new(WIDTH, (BOTTOM - TOP) as u32));
    let corners = area.corners();
    // Beside the area's right side, where no cluster is drawn.
    let [right, forward] = corners[2];
    let angle = (libm::atan2f(right, forward) + 0.16).min(1.2);
    let sin = libm::sinf(angle);
    // As far right as there is room for the name.
    let rightmost = (WIDTH / 2 - RING_NAME) as f32 / METRE;
    let Ok(()) = draw_rings(&mut canvas.clipped(&map));
    for metres in 1..=4u8 {
        let r = f32::from(metres);
        let x = (r * sin).min(rightmost);
        let at = pixel([x, (r * r - x * x).max(0.0).sqrt()]);
        text::write(canvas, &format!("{metres} m"), at.x, at.y - 6, RING_NAMES);
    }
    let stroke = PrimitiveStyle::with_stroke(AREA, 1);
    for i in 0..corners.len() {
        let line = Line::new(pixel(corners[i]), pixel(corners[(i + 1) % corners.len()]));
        let Ok(()) = line.into_styled(stroke).draw(&mut canvas.clipped(&map));
    }
}

fn draw_rings<D: DrawTarget<Color = Rgb888>>(target: &mut D) -> Result<(), D::Error> {
    for metres in 1..=4u8 {
        let diameter = (2.0 * METRE * f32::from(metres)) as u32;
        let ring = Circle::with_center(pixel([0.0; 2]), diameter);
        ring.into_styled(PrimitiveStyle::with_stroke(RINGS, 1)).draw(target)?;
    }
    Ok(())
}

/// The clusters' contours and numbers.
fn contours(canvas: &mut Canvas, processed: &Processed<'_>) {
    let core = &processed.workspace.report;
    let mut labels = Labels::new(Rectangle::new(Point::new(LEFT, TOP), Size::new(WIDTH, (BOTTOM - TOP) as u32)));
    // The candidates last, on top.
    for wanted in [false, true] {
        for (i, (cluster, contour)) in core.clusters.iter().zip(&core.contours).enumerate() {
            let colour = colour_of(processed.report, i);
            if colour.is_some() != wanted || cluster.is_noise() {
                continue;
            }
            let c = colour.unwrap_or(GREY);
            for point in contour.of(&processed.workspace.images.points) {
                fill(canvas, usize::from(point.column), usize::from(point.row), [c.r(), c.g(), c.b()]);
            }
        }
    }
    for wanted in [true, false] {
        for (i, (cluster, contour)) in core.clusters.iter().zip(&core.contours).enumerate() {
            let colour = colour_of(processed.report, i);
            if colour.is_some() != wanted || cluster.is_noise() || (!wanted && contour.cells < WORTH_A_NUMBER) {
                continue;
            }
            let at = pixel(cluster.centroid);
            let highest =
                contour.of(&processed.workspace.images.points).iter().map(|p| i32::from(p.row)).max().unwrap_or(0);
            let above = BOTTOM - SCALE * (highest + 1) - LABEL_HEIGHT as i32 - 1;
            let y = if contour.cells >= CARRIES_NUMBER { at.y - LABEL_HEIGHT as i32 / 2 } else { above };
            labels.write(canvas, &(i + 1).to_string(), at.x, y, colour.unwrap_or(GREY));
        }
    }
}

/// The camera: a triangle that points forward.
fn sensor(canvas: &mut Canvas) {
    let Point { x, y } = pixel([0.0; 2]);
    let triangle = Triangle::new(Point::new(x, y - 12), Point::new(x - 7, y - 1), Point::new(x + 7, y - 1));
    let Ok(()) = triangle.into_styled(PrimitiveStyle::with_fill(WORDS)).draw(canvas);
}
