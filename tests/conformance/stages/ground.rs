//! The ground map: which cell each pixel falls into, and the density.

use crate::errors::Tally;
use crate::inputs::{Scene, W};
use crate::oracle::geometry::Pose;
use crate::oracle::image;
use crate::rows::Pair::Float;
use crate::stages::{Tools, boxed};
use pldi_core::Floor;
use pldi_core::ground::density::{self, NO_CELL};
use pldi_core::ground::{CELL, DensityParams, MAP_DEPTH, MAP_WIDTH, SensoryArea};
use pldi_core::pipeline::QvgaPipeline;

/// All of it, and the candidates in the workspace's report.
pub fn measure(scene: &Scene, pipeline: &QvgaPipeline, floor: &Floor, tools: &mut Tools, tally: &mut Tally) {
    let truth = Pose::above(floor.normal.map(f64::from), f64::from(floor.height));
    cells(scene, pipeline, floor, &truth, tools, tally);
    if let Err(error) = pipeline.find_candidates(floor, &mut tools.workspace) {
        // More clusters than there is room for is an answer, too; what was found until then is complete.
        assert!(matches!(error, pldi_core::Error::Capacity(_)), "{error}");
        tools.workspace.report.clusters.clear();
    }
    if scene.stride > 0 {
        let found = tools.workspace.images.density.as_flattened();
        let counts = tools.workspace.images.counts.as_flattened();
        tally.at("ground: density", Float).add_all(found, &spread(counts, f64::from(scene.camera.fx)));
    }
}

/// Which cell of image L each pixel belongs to; a pixel at a border may fall to the other side.
fn cells(scene: &Scene, pipeline: &QvgaPipeline, floor: &Floor, truth: &Pose, tools: &mut Tools, tally: &mut Tally) {
    let (params, camera) = (DensityParams::DEFAULT, &scene.camera);
    let area = SensoryArea::new(&pipeline.params().area, camera, floor);
    let images = &mut tools.workspace.images;
    let (depth, labels) = (&images.depth, &mut images.labels);
    density::project(depth, pipeline.rays(), &floor.axes(), &area, &params, labels, &mut images.counts);
    let errors = tally.at("ground: cells of pixels", Float);
    for (i, &cell) in labels.as_flattened().iter().enumerate() {
        let z = f64::from(depth[i / W][i % W]);
        let [right, forward, up] = truth.to_floor(image::point(camera, i % W, i / W, z));
        // The outermost rays of a level camera, on the floor.
        let side = |u: f64| (u - f64::from(camera.cx)) / f64::from(camera.fx) / truth.horizontal() * forward;
        let inside = z > 0.0
            && (0.02 + 0.004 * z * z..=2.2).contains(&up)
            && (0.5..=4.0).contains(&forward)
            && (side(0.0)..=side(W as f64 - 1.0)).contains(&right);
        let (column, row) = (libm::floor(right / 0.02) as i64 + 128, libm::floor(forward / 0.02) as i64);
        let inside = inside && (0..MAP_WIDTH as i64).contains(&column);
        let expected = if inside { row * MAP_WIDTH as i64 + column } else { i64::from(NO_CELL) };
        errors.decide(i64::from(cell) == expected);
    }
}

/// The density of some counts, by the Gaussian itself.
fn spread(counts: &[f32], focal: f64) -> Vec<f64> {
    let mut density = boxed::<f64, MAP_WIDTH, MAP_DEPTH>(0.0);
    let cell = f64::from(CELL);
    for (i, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0.0) {
        let (column, row) = (i % MAP_WIDTH, i / MAP_WIDTH);
        let (x, y) = ((column as f64 + 0.5 - 128.0) * cell, (row as f64 + 0.5) * cell);
        // Variances along and across the ray, in square cells; a quarter for the cells themselves.
        let along = libm::pow(1.425e-3 * y * y / cell, 2.0) + 0.25;
        let across = libm::pow(0.8 * y / focal / cell, 2.0) + 0.25;
        let length = (x * x + y * y).sqrt();
        let peak = f64::from(*count) / (core::f64::consts::TAU * (along * across).sqrt());
        for r in row.saturating_sub(12)..(row + 13).min(MAP_DEPTH) {
            for c in column.saturating_sub(12)..(column + 13).min(MAP_WIDTH) {
                let (dx, dy) = (c as f64 - column as f64, r as f64 - row as f64);
                let (a, b) = ((dx * x + dy * y) / length, (dx * y - dy * x) / length);
                let q = a * a / along + b * b / across;
                if q < 9.0 {
                    density[r][c] += peak * libm::exp(-0.5 * q);
                }
            }
        }
    }
    density.as_flattened().to_vec()
}
