use std::io::BufReader;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use pldi_core::pipeline::Params;
use pldi_core::templates::Templates;
use pldi_fixtures::Recording;
use re_sdk::external::re_log_encoding::DecoderApp;
use re_sdk::log::{Chunk, LogMsg};
use re_sdk::sink::CallbackSink;
use re_sdk::{Component, ComponentDescriptor};
use re_types::archetypes::{Boxes2D, Boxes3D, DepthImage, EncodedImage, Image, LineStrips3D, Pinhole, Transform3D};
use re_types::components as parts;

use super::*;
use crate::ArithmeticKind;
use crate::input::{self, OpenOptions};
use crate::report::FrameReport;
use crate::runner::{self, Job};

/// A frame of the generated recording, and what is to be shown of it.
struct Shown {
    report: FrameReport,
    stamp: Stamp,
    depth: Vec<f32>,
    n: Vec<u16>,
    scene: Scene,
}

/// Three frames of 640x480.
fn shown() -> &'static [Shown] {
    static SHOWN: OnceLock<Vec<Shown>> = OnceLock::new();
    SHOWN.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let mut recording = Recording::demo();
        recording.path = recording.path.into_iter().skip(2).step_by(3).take(3).collect();
        pldi_fixtures::write_tum(&recording, "generated", folder.path()).unwrap();
        let input = input::open(folder.path().to_str().unwrap(), &OpenOptions::default()).unwrap();
        let set = Templates::parse(crate::templates::EMBEDDED).unwrap();
        let params = Params { view: *set.view_params(), ..Params::DEFAULT };
        let (arithmetic, stop) = (ArithmeticKind::Float, Stop::default());
        let job = Job { arithmetic, params: &params, templates: &set, threads: 2, stop: &stop };
        let mut shown = Vec::new();
        let look = |seen: &mut runner::Processed<'_>| {
            let depth = seen.workspace.images.depth.as_flattened().to_vec();
            let scene = Scene::new(seen)?;
            let n = seen.workspace.images.n.as_flattened().to_vec();
            Ok(Shown { report: seen.report.clone(), stamp: seen.frame.stamp, depth, n, scene })
        };
        let sink = |_, result: Result<runner::FrameResult<Shown>, Error>| {
            shown.push(result?.extra);
            Ok::<_, Error>(true)
        };
        runner::run(input, &job, look, sink).unwrap();
        shown
    })
}

/// What reached the other end.
fn chunks(messages: &[LogMsg]) -> Vec<Chunk> {
    let chunk = |message: &LogMsg| match message {
        LogMsg::ArrowMsg(_, message) => Some(Chunk::from_arrow_msg(message).unwrap()),
        _ => None,
    };
    messages.iter().filter_map(chunk).collect()
}

/// What stood in a component of an entity, frame by frame.
fn column<C: Component + Clone>(chunks: &[Chunk], path: &str, component: &ComponentDescriptor) -> Vec<Vec<C>> {
    let of_path = chunks.iter().filter(|chunk| *chunk.entity_path() == path.into());
    of_path.flat_map(|c| c.iter_component::<C>(component.component).map(|row| row.as_slice().to_vec())).collect()
}

fn times(chunks: &[Chunk], path: &str, timeline: &str) -> Vec<i64> {
    let of_path = chunks.iter().filter(|chunk| *chunk.entity_path() == path.into());
    of_path.filter_map(|c| c.timelines().get(&timeline.into())).flat_map(|c| c.times_raw().to_vec()).collect()
}

/// All frames through a stream.
fn streamed() -> Vec<Chunk> {
    let received = Arc::new(Mutex::new(Vec::new()));
    let to = received.clone();
    let sink = CallbackSink::new(move |messages| to.lock().unwrap().extend_from_slice(messages));
    let mut viewer = Viewer::new(Box::new(sink), "memory".into(), "generated", None).unwrap();
    for frame in shown() {
        viewer.show(frame.scene.clone(), &Stop::default()).unwrap();
    }
    viewer.end(true).unwrap();
    let messages = received.lock().unwrap();
    chunks(&messages)
}

#[test]
fn every_frame_arrives_with_its_times() {
    let chunks = streamed();
    let entities = shown()[0].scene.entities.iter().map(|(path, _)| *path);
    let stamps: Vec<i64> = shown().iter().map(|frame| frame.stamp.0).collect();
    assert!(stamps.is_sorted_by(|a, b| a < b), "{stamps:?}");
    for path in entities {
        assert_eq!(times(&chunks, path, "frame"), [0, 1, 2], "{path}");
        assert_eq!(times(&chunks, path, "stamp"), stamps, "{path}");
    }
    for chunk in &chunks {
        let mut names: Vec<&str> = chunk.timelines().keys().map(|name| name.as_str()).collect();
        names.sort_unstable();
        assert!(names == ["frame", "stamp"] || chunk.is_static(), "{}: {names:?}", chunk.entity_path());
    }
}

#[test]
fn images_are_those_of_the_pipeline() {
    let chunks = streamed();
    let depth = column::<parts::ImageBuffer>(&chunks, "world/camera/depth", &DepthImage::descriptor_buffer());
    let n = column::<parts::ImageBuffer>(&chunks, "n", &Image::descriptor_buffer());
    let colour = column::<parts::Blob>(&chunks, "world/camera/colour", &EncodedImage::descriptor_blob());
    assert_eq!([depth.len(), n.len(), colour.len()], [3; 3]);
    for (i, frame) in shown().iter().enumerate() {
        let metres: Vec<f32> = depth[i][0].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!(metres, frame.depth);
        assert!(metres.iter().filter(|z| (0.5..8.0).contains(*z)).count() > 40_000);
        let values: Vec<u16> = n[i][0].as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
        assert_eq!(values, frame.n);
        // The whole image, not only the candidates.
        assert!(values.iter().filter(|n| **n > 0).count() > 40_000);
        let image = image::load_from_memory_with_format(&colour[i][0], image::ImageFormat::Jpeg).unwrap();
        assert_eq!((image.width(), image.height()), (640, 480));
    }
    let cameras = ["world/camera/colour", "world/camera/depth"].map(|path| {
        let projection = column::<parts::PinholeProjection>(&chunks, path, &Pinhole::descriptor_image_from_camera());
        let size = column::<parts::Resolution>(&chunks, path, &Pinhole::descriptor_resolution());
        (projection[0][0].get(0, 0), size[0][0].0.0)
    });
    assert_eq!(cameras.map(|camera| camera.1), [[640.0, 480.0], [320.0, 240.0]]);
    assert_eq!(cameras[0].0, 2.0 * cameras[1].0);
}

#[test]
fn candidates_carry_names_and_stand_on_the_floor() {
    let chunks = streamed();
    let flat = column::<parts::Text>(&chunks, "world/camera/colour/candidates", &Boxes2D::descriptor_labels());
    let labels = column::<parts::Text>(&chunks, "world/candidates", &Boxes3D::descriptor_labels());
    let centres = column::<parts::PoseTranslation3D>(&chunks, "world/candidates", &Boxes3D::descriptor_centers());
    let halves = column::<parts::HalfSize3D>(&chunks, "world/candidates", &Boxes3D::descriptor_half_sizes());
    let turns = column::<parts::PoseRotationQuat>(&chunks, "world/candidates", &Boxes3D::descriptor_quaternions());
    let cameras = column::<parts::Translation3D>(&chunks, "world/camera", &Transform3D::descriptor_translation());
    let strips = column::<parts::LineStrip3D>(&chunks, "world/floor", &LineStrips3D::descriptor_strips());
    assert!(shown().iter().map(|frame| frame.report.detections.len()).sum::<usize>() >= 3);
    for (i, frame) in shown().iter().enumerate() {
        let expected: Vec<String> = frame
            .report
            .detections
            .iter()
            .map(|d| format!("{} {} {:.2}", d.id, d.results[0].class_id, d.results[0].score))
            .collect();
        assert_eq!(labels[i].iter().map(|text| text.as_str()).collect::<Vec<_>>(), expected);
        assert_eq!(flat[i], labels[i]);
        let floor = frame.report.floor.unwrap();
        assert_eq!(cameras[i][0].0.0, [0.0, 0.0, floor.height]);
        // Outline, and lines at 1, 2 and 3 m.
        assert_eq!(strips[i].len(), 4);
        for (k, detection) in frame.report.detections.iter().enumerate() {
            let ([x, y, z], half) = (centres[i][k].0.0, halves[i][k].0.0);
            assert!((z - half[2]).abs() < 1e-4, "it stands on the floor: {z} {half:?}");
            assert_eq!(half, [0, 2, 1].map(|axis| 0.5 * detection.size[axis]));
            // Its depth runs along the line of sight, which nearly passes through its middle.
            let [_, _, sin, cos] = turns[i][k].0.0;
            let along = [-2.0 * sin * cos, cos * cos - sin * sin];
            let distance = libm::hypotf(x, y);
            assert!((along[0] * x + along[1] * y) / distance > 0.98, "{along:?} {x} {y}");
        }
    }
}

/// The messages of a file.
fn read(path: &Path) -> Vec<LogMsg> {
    let file = BufReader::new(std::fs::File::open(path).unwrap());
    DecoderApp::decode_eager(file).unwrap().map(|message| message.unwrap()).collect()
}

#[test]
fn a_file_appears_when_it_ends_and_holds_all_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.rrd");
    let (target, stop) = (Target::File(path.clone()), Stop::default());
    for done in [true, false] {
        let mut viewer = Viewer::open(&target, "generated", &stop).unwrap();
        for frame in shown() {
            viewer.show(frame.scene.clone(), &stop).unwrap();
        }
        assert!(!path.exists());
        viewer.end(done).unwrap();
        let (read, streamed) = (chunks(&read(&path)), streamed());
        assert_eq!(read.len(), streamed.len());
        assert_eq!(times(&read, "n", "frame"), [0, 1, 2]);
        let depth = |chunks: &[Chunk]| {
            column::<parts::ImageBuffer>(chunks, "world/camera/depth", &DepthImage::descriptor_buffer())
        };
        assert_eq!(depth(&read), depth(&streamed));
        std::fs::remove_file(&path).unwrap();
    }
    // Without a frame: only where there was none to be shown.
    Viewer::open(&target, "generated", &stop).unwrap().end(false).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    Viewer::open(&target, "generated", &stop).unwrap().end(true).unwrap();
    assert!(times(&chunks(&read(&path)), "n", "frame").is_empty());
}

#[test]
fn dates_are_told_from_times_since_the_start() {
    let typ = |stamp: Stamp| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.rrd");
        let mut viewer = Viewer::open(&Target::File(path.clone()), "generated", &Stop::default()).unwrap();
        viewer.show(Scene { stamp, ..shown()[0].scene.clone() }, &Stop::default()).unwrap();
        viewer.end(true).unwrap();
        let chunks = chunks(&read(&path));
        assert_eq!(times(&chunks, "n", "stamp"), [stamp.0]);
        let n = chunks.iter().find(|chunk| *chunk.entity_path() == "n".into()).unwrap();
        n.timelines()[&"stamp".into()].timeline().typ()
    };
    assert_eq!(typ(Stamp(1_305_031_102_175_304_000)), re_sdk::time::TimeType::TimestampNs);
    assert_eq!(typ(Stamp(33_366_700)), re_sdk::time::TimeType::DurationNs);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_at_the_frame_that_finds_no_room() {
    let mut viewer = Viewer::open(&Target::File("/dev/full".into()), "generated", &Stop::default()).unwrap();
    let error = viewer.show(shown()[0].scene.clone(), &Stop::default()).unwrap_err().to_string();
    assert!(error.contains("/dev/full") && error.contains("No space left"), "{error}");
}

#[test]
fn a_viewer_that_is_not_there_is_told_at_once() {
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let error = Viewer::open(&Target::local(port).unwrap(), "generated", &Stop::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains(&format!("127.0.0.1:{port}")) && text.contains("refused"), "{text}");
    assert!(!error.is_usage());
}
