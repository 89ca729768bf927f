//! Every stage of one frame as files: to look at, and to compare with other implementations.

use std::path::Path;

use pldi_core::Frame;
use pldi_core::ground::{CELL, MAP_DEPTH, MAP_WIDTH};
use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::wavelet::SIZE;
use serde_json::{Value, json};

use crate::numbers::eighths;
use crate::output::{atomic, png};
use crate::{Engine, Error};

/// Size of the core's frames.
const QVGA: (u32, u32) = (320, 240);

/// Writes into `folder` (which must exist):
///
/// - `filtered.png`: the reconstructed depth, 16 bit, 1/8 mm (larger depths saturate), 0 = none;
/// - `n.png`: N of the whole image, 16 bit, 65535 = 1;
/// - `map.png`: the density on the floor, 8 bit, far rows first, white from four times the threshold on;
/// - `clusters.png`: the cluster of every pixel, 8 bit, from 1, 0 = none, rejected ones included;
/// - `candidates.json`: the floor, and each cluster's box, contour and reason;
/// - for the candidate of cluster I: `view_I.png` (16 bit), `dwt_I.f32` (16384 little-endian coefficients) and
///   `descriptor_I.json` (both descriptors of the view).
///
/// Without a floor there are only `filtered.png`, `n.png` and `candidates.json`.
///
/// # Errors
/// `Write`, and what the core says.
pub fn write(
    engine: &mut Engine,
    frame: &Frame<'_, 320, 240>,
    workspace: &mut QvgaWorkspace,
    folder: &Path,
) -> Result<(), Error> {
    engine.reconstruct(frame, workspace);
    // Exact where the depth was in 1/8 mm already.
    let depth: Vec<u16> = workspace.images.depth.as_flattened().iter().map(|z| eighths(*z)).collect();
    png::write_grey16(&folder.join("filtered.png"), QVGA, &depth)?;
    if engine.find_floor(workspace).is_some() {
        engine.find_candidates(workspace)?;
        write_map(engine, workspace, folder)?;
        engine.diffuse_candidates(workspace);
        for i in 0..workspace.report.clusters.len() {
            if workspace.report.clusters[i].rejection.is_none() {
                write_candidate(engine, i, workspace, folder)?;
            }
        }
    }
    atomic::write_json(&folder.join("candidates.json"), &candidates(workspace))?;
    engine.diffuse_all(workspace);
    png::write_grey16(&folder.join("n.png"), QVGA, workspace.images.n.as_flattened())
}

fn write_map(engine: &Engine, workspace: &QvgaWorkspace, folder: &Path) -> Result<(), Error> {
    let white = 4.0 * engine.params().density.threshold.max(1e-6);
    let map: Vec<u8> =
        workspace.images.density.iter().rev().flatten().map(|d| (d / white * 255.0).min(255.0) as u8).collect();
    png::write_grey8(&folder.join("map.png"), (MAP_WIDTH as u32, MAP_DEPTH as u32), &map)?;
    // At most MAX_CLUSTERS = 192.
    let clusters: Vec<u8> = workspace.images.labels.as_flattened().iter().map(|l| *l as u8).collect();
    png::write_grey8(&folder.join("clusters.png"), QVGA, &clusters)
}

fn write_candidate(
    engine: &mut Engine,
    cluster: usize,
    workspace: &mut QvgaWorkspace,
    folder: &Path,
) -> Result<(), Error> {
    let Some(descriptors) = engine.describe(cluster, workspace) else { return Ok(()) };
    let file = |name: &str, ending: &str| folder.join(format!("{name}_{}.{ending}", cluster + 1));
    png::write_grey16(&file("view", "png"), (SIZE as u32, SIZE as u32), workspace.images.view.as_flattened())?;
    let bytes: Vec<u8> = workspace.images.coefficients.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    atomic::write_bytes(&file("dwt", "f32"), &bytes)?;
    let numbers = json!({ "paper": descriptors.paper.to_vec(), "halves": descriptors.halves.to_vec() });
    atomic::write_json(&file("descriptor", "json"), &numbers)
}

/// The floor and the clusters.
fn candidates(workspace: &QvgaWorkspace) -> Value {
    let report = &workspace.report;
    let clusters: Vec<Value> = report
        .clusters
        .iter()
        .zip(&report.contours)
        .enumerate()
        .map(|(i, (cluster, contour))| {
            let points = contour.of(&workspace.images.points).iter();
            json!({
                "cluster": i + 1,
                "candidate": cluster.rejection.is_none(),
                "reason": cluster.rejection.map(pldi_core::ground::Rejection::name),
                "pixels": cluster.pixels,
                "bbox": cluster.bbox,
                "center": cluster.center,
                "size": cluster.size,
                "area": contour.area(),
                "length": contour.length(),
                "contour": points.map(|p| [p.column, p.row]).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "floor": report.floor.map(|f| json!({ "normal": f.normal, "height": f.height })),
        "map": { "columns": MAP_WIDTH, "rows": MAP_DEPTH, "cell": CELL },
        "clusters": clusters,
    })
}
