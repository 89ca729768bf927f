//! What is shown of a frame.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use pldi_core::floor::FloorAxes;
use pldi_core::ground::SensoryArea;
use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::{Floor, Intrinsics};
use re_types::archetypes::{Boxes2D, Boxes3D, DepthImage, EncodedImage, Image, LineStrips3D, Pinhole, Transform3D};
use re_types::components::{MediaType, PinholeProjection};
use re_types::datatypes::{ChannelDatatype, ColorModel, Quaternion};
use re_types::{AsComponents, SerializedComponentBatch};

use crate::Error;
use crate::input::{Images, Stamp};
use crate::overlay::candidate_colour;
use crate::report::DetectionReport;
use crate::runner::Processed;

/// Quality of the colour images: no difference is seen, and they take a tenth of the room.
const JPEG_QUALITY: u8 = 90;

/// A frame as the viewer takes it.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) index: usize,
    pub(super) stamp: Stamp,
    /// Names in the viewer, and what is there in this frame.
    pub(super) entities: Vec<(&'static str, Vec<SerializedComponentBatch>)>,
}

impl Scene {
    /// What is shown of a frame. Computes N of the whole image, in place of the candidates'.
    ///
    /// # Errors
    /// `Content` for a colour image that cannot be encoded.
    pub fn new(seen: &mut Processed<'_>) -> Result<Self, Error> {
        let (frame, report) = (seen.frame, &seen.workspace.report);
        let camera = frame.qvga.intrinsics;
        // A camera is drawn there even where there is no image.
        let mut colour = pinhole(&camera, frame.qvga.factor).as_serialized_batches();
        if let Some(rgb) = &frame.images.colour {
            colour.extend(photograph(rgb, &frame.images, &frame.qvga.name)?.as_serialized_batches());
        }
        let mut depth = pinhole(&camera, 1).as_serialized_batches();
        depth.extend(depth_image(seen.workspace, &camera).as_serialized_batches());
        let entities = vec![
            ("world/camera", pose(report.floor.as_ref()).as_serialized_batches()),
            ("world/camera/colour", colour),
            ("world/camera/colour/candidates", flat_boxes(seen).as_serialized_batches()),
            ("world/camera/depth", depth),
            ("world/candidates", boxes(seen).as_serialized_batches()),
            ("world/floor", floor(seen).as_serialized_batches()),
            ("n", n(seen).as_serialized_batches()),
        ];
        Ok(Self { index: frame.qvga.index, stamp: frame.stamp, entities })
    }
}

/// The camera of the images `factor` times as large as QVGA. The viewer counts columns and rows from the border of the
/// first pixel, we from its middle.
fn pinhole(qvga: &Intrinsics, factor: u16) -> Pinhole {
    let k = f32::from(factor);
    let centre = [qvga.cx * k + 0.5, qvga.cy * k + 0.5];
    Pinhole::new(PinholeProjection::from_focal_length_and_principal_point([qvga.fx * k, qvga.fy * k], centre))
        .with_resolution([f32::from(qvga.width) * k, f32::from(qvga.height) * k])
}

fn photograph(rgb: &[u8], images: &Images, name: &str) -> Result<EncodedImage, Error> {
    let fails = |reason: String| Error::Content { path: name.into(), reason };
    let (width, height) = (u32::from(images.size.0), u32::from(images.size.1));
    if rgb.len() != 3 * width as usize * height as usize {
        return Err(fails(format!("its colour image has not {width}x{height} pixels")));
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .encode(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|e| fails(format!("its colour image cannot be encoded: {e}")))?;
    Ok(EncodedImage::new(bytes).with_media_type(MediaType::JPEG))
}

fn depth_image(workspace: &QvgaWorkspace, camera: &Intrinsics) -> DepthImage {
    let bytes: Vec<u8> = workspace.images.depth.as_flattened().iter().flat_map(|metres| metres.to_le_bytes()).collect();
    let size = [camera.width.into(), camera.height.into()];
    DepthImage::from_data_type_and_bytes(bytes, size, ChannelDatatype::F32).with_meter(1.0)
}

fn n(seen: &mut Processed<'_>) -> Image {
    let camera = seen.frame.qvga.intrinsics;
    let bytes: Vec<u8> = seen.whole_n().iter().flat_map(|n| n.to_le_bytes()).collect();
    let size = [camera.width.into(), camera.height.into()];
    Image::from_color_model_and_bytes(bytes, size, ColorModel::L, ChannelDatatype::U16)
}

/// From the camera's frame to the floor's.
fn pose(floor: Option<&Floor>) -> Transform3D {
    let level = FloorAxes {
        right: [1.0, 0.0, 0.0],
        forward: [0.0, 0.0, 1.0],
        floor: Floor { normal: [0.0, -1.0, 0.0], height: 0.0 },
    };
    let FloorAxes { right, forward, floor } = floor.map_or(level, Floor::axes);
    let columns: [[f32; 3]; 3] = std::array::from_fn(|i| [right[i], forward[i], floor.normal[i]]);
    Transform3D::from_translation_mat3x3([0.0, 0.0, floor.height], columns)
}

/// The sensory area's outline, and a line across it for each metre.
fn floor(seen: &Processed<'_>) -> LineStrips3D {
    let Some(floor) = &seen.workspace.report.floor else { return LineStrips3D::new([[[0.0f32; 3]; 0]; 0]) };
    let area = SensoryArea::new(&seen.engine.params().area, seen.engine.intrinsics(), floor);
    let corners @ [near_left, _, far_right, far_left] = area.corners();
    let on_floor = |[right, forward]: [f32; 2]| [right, forward, 0.0];
    let mut strips = vec![corners.iter().chain([&near_left]).map(|c| on_floor(*c)).collect::<Vec<_>>()];
    for metres in (1..=10u8).map(f32::from).filter(|m| near_left[1] < *m && *m < far_left[1]) {
        let across = [far_left, far_right].map(|[right, forward]| on_floor([right * metres / forward, metres]));
        strips.push(across.to_vec());
    }
    LineStrips3D::new(strips).with_colors([[90, 120, 160]])
}

/// Number, best class and score of each candidate, and its colour.
fn labels(seen: &Processed<'_>) -> (Vec<String>, Vec<[u8; 3]>) {
    let label = |d: &DetectionReport| match d.results.first() {
        Some(best) => format!("{} {} {:.2}", d.id, best.class_id, best.score),
        None => d.id.to_string(),
    };
    seen.report.detections.iter().map(|d| (label(d), candidate_colour(seen.report, d))).unzip()
}

/// Boxes around the candidates' pixels in the colour image. Their borders are counted as the viewer does.
fn flat_boxes(seen: &Processed<'_>) -> Boxes2D {
    let boxes = seen.report.detections.iter().map(|d| d.bbox.map(|pixel| pixel as f32));
    let (corners, sizes): (Vec<_>, Vec<_>) =
        boxes.map(|[u0, v0, u1, v1]| ([u0, v0], [u1 + 1.0 - u0, v1 + 1.0 - v0])).unzip();
    let (labels, colours) = labels(seen);
    Boxes2D::from_mins_and_sizes(corners, sizes).with_labels(labels).with_colors(colours)
}

/// The candidates' boxes, which stand on the floor and are turned to the line of sight.
fn boxes(seen: &Processed<'_>) -> Boxes3D {
    let report = &seen.workspace.report;
    let (mut centres, mut halves, mut turns) = (Vec::new(), Vec::new(), Vec::new());
    for detection in &seen.report.detections {
        let cluster = detection.id.checked_sub(1).and_then(|i| report.clusters.get(i));
        let (Some(cluster), Some(floor)) = (cluster, &report.floor) else { continue };
        let [right, forward] = cluster.centroid;
        let (sin, cos) = libm::sincosf(-0.5 * libm::atan2f(right, forward));
        let [width, height, depth] = detection.size.map(|length| 0.5 * length);
        centres.push(floor.axes().to_floor(detection.center));
        halves.push([width, depth, height]);
        turns.push(Quaternion::from_xyzw([0.0, 0.0, sin, cos]));
    }
    let (labels, colours) = labels(seen);
    Boxes3D::from_centers_and_half_sizes(centres, halves)
        .with_quaternions(turns)
        .with_labels(labels)
        .with_colors(colours)
}
