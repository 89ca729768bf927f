//! The ground map: which cell each pixel falls into, the density, and the clusters.

use crate::errors::Tally;
use crate::inputs::{Scene, W};
use crate::oracle::geometry::Pose;
use crate::oracle::ground::{Area, cell, clusters, spread};
use crate::rows::Pair::Float;
use crate::stages::Tools;
use crate::stages::clusters::Clusters;
use pldi_core::Floor;
use pldi_core::ground::density::{self, NO_CELL};
use pldi_core::ground::{DensityParams, SensoryArea};
use pldi_core::pipeline::QvgaPipeline;

/// All of it, and the candidates in the workspace's report. `filtered` is the truth of the filtered depth.
pub fn measure(
    scene: &Scene,
    pipeline: &QvgaPipeline,
    floor: &Floor,
    filtered: Option<&[f64]>,
    tools: &mut Tools,
    tally: &mut Tally,
) {
    let truth = Pose::above(floor.normal.map(f64::from), f64::from(floor.height));
    cells(scene, pipeline, floor, &truth, tools, tally);
    let result = pipeline.find_candidates(floor, &mut tools.workspace);
    if scene.stride > 0 {
        let found = tools.workspace.images.density.as_flattened();
        let counts: Vec<_> = tools.workspace.images.counts.as_flattened().iter().map(|v| f64::from(*v)).collect();
        tally.at("ground: density", Float).add_all(found, &spread(&counts, f64::from(scene.camera.fx)));
    }
    if let Err(error) = result {
        // More clusters than there is room for is an answer, too.
        assert!(matches!(error, pldi_core::Error::Capacity(_)), "{error}");
        tools.workspace.report.clusters.clear();
        return;
    }
    let found = Clusters::float(&tools.workspace);
    let depth: Vec<f64> = tools.workspace.images.depth.as_flattened().iter().map(|z| f64::from(*z)).collect();
    let expected = Clusters::truth(clusters(&depth, &scene.camera, &truth));
    found.compare(&expected, tally.at("ground: clusters", Float));
    if let Some(depth) = filtered {
        let expected = Clusters::truth(clusters(depth, &scene.camera, &truth));
        found.compare(&expected, tally.at("pipeline: clusters", Float));
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
    let area = Area::new(camera, truth);
    for (i, &found) in labels.as_flattened().iter().enumerate() {
        let z = f64::from(depth[i / W][i % W]);
        let expected = cell(camera, truth, &area, (i % W, i / W), z);
        errors.decide(usize::from(found) == expected.unwrap_or(usize::from(NO_CELL)));
    }
}
