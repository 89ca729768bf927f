use super::*;
use crate::input::{Frame, Input, QvgaFrame, parse_intrinsics};
use crate::output::png;
use tempfile::TempDir;

const INFO: &str =
    "image_width: 640\nimage_height: 480\ncamera_matrix:\n  data: [525, 0, 319.5, 0, 525, 239.5, 0, 0, 1]\n";

fn depth_png(folder: &Path, name: &str, size: (u32, u32), value: u16) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    png::write_grey16(&path, size, &vec![value; (size.0 * size.1) as usize]).unwrap();
}

fn colour_png(folder: &Path, name: &str, size: (u32, u32), value: u8) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    png::write_rgb8(&path, size, &vec![value; 3 * (size.0 * size.1) as usize]).unwrap();
}

/// Three QVGA frames with associations; depth is 1000 + i mm.
fn recording() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut list = String::from("# rgb depth\n");
    for i in 0..3 {
        depth_png(folder.path(), &format!("depth/{i}.png"), (320, 240), 1000 + i);
        colour_png(folder.path(), &format!("rgb/{i}.png"), (320, 240), i as u8);
        list += &format!("{i}.0 rgb/{i}.png {i}.5 depth/{i}.png\n");
    }
    std::fs::write(folder.path().join("associations.txt"), list).unwrap();
    folder
}

/// The frames of an input, whatever became of each.
#[derive(Debug)]
struct Recording(Vec<Result<Frame, Error>>);

impl Recording {
    fn open(path: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let mut input: Input = crate::input::open(path.to_str().unwrap(), options)?;
        let count = input.frames_left();
        let frames: Vec<_> = input.frames().collect();
        assert_eq!(count, Some(frames.len()));
        Ok(Self(frames))
    }

    fn frame(&self, i: usize) -> Result<QvgaFrame, &Error> {
        self.0[i].as_ref().map(|frame| frame.qvga.clone())
    }
}

fn pair(colour: Option<&Path>, depth: &Path) -> Result<Recording, Error> {
    Recording::open(depth, &OpenOptions { colour_image: colour.map(Path::to_owned), ..OpenOptions::default() })
}

fn open(folder: &TempDir) -> Result<Recording, Error> {
    Recording::open(folder.path(), &OpenOptions::default())
}

fn message(result: Result<impl std::fmt::Debug, impl std::fmt::Debug + ToString>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn frames_are_decoded_in_any_order_and_by_several_threads() {
    let folder = recording();
    let uri = folder.path().to_str().unwrap();
    let mut input = crate::input::open(uri, &OpenOptions::default()).unwrap();
    let raw: Vec<_> = std::iter::from_fn(|| input.raw(&Stop::default()).unwrap()).collect();
    let (_, preparation) = input.into_parts();
    std::thread::scope(|scope| {
        for (i, raw) in raw.into_iter().rev() {
            let preparation = &preparation;
            scope.spawn(move || {
                assert_eq!(
                    (raw.stamp.0, raw.colour_stamp.unwrap().0),
                    ((10 * i + 5) as i64 * 100_000_000, i as i64 * 1_000_000_000)
                );
                let frame = preparation.frame(i, raw).unwrap().qvga;
                assert_eq!((frame.index, frame.stamp, frame.factor), (i, i as f64 + 0.5, 1));
                assert_eq!(frame.name, format!("depth/{i}.png"));
                assert!(frame.depth.iter().all(|&d| d == 1000 + i as u16));
                assert!(frame.colour.as_ref().unwrap().iter().all(|&c| c == i as u8));
                assert_eq!(frame.intrinsics, pldi_core::Intrinsics::PRIMESENSE_QVGA);
                assert!(frame.as_frame().unwrap().colour.is_some());
            });
        }
    });
    let mut input = crate::input::open(uri, &OpenOptions::default()).unwrap();
    let error = input.frame(3, &Stop::default()).unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("has 3"), "{error}");
}

#[test]
fn lists_of_each_kind_are_associated() {
    let folder = recording();
    std::fs::remove_file(folder.path().join("associations.txt")).unwrap();
    std::fs::write(folder.path().join("depth.txt"), "0.01 depth/0.png\n1.0 depth/1.png\n2.0 depth/2.png\n").unwrap();
    // Without rgb.txt: depth alone.
    let recording = open(&folder).unwrap();
    assert_eq!(recording.0.len(), 3);
    assert!(recording.frame(0).unwrap().colour.is_none());
    // With it: the second depth image has no colour within 0.02 s.
    std::fs::write(folder.path().join("rgb.txt"), "0.0 rgb/0.png\n1.5 rgb/1.png\n2.0 rgb/2.png\n").unwrap();
    let recording = open(&folder).unwrap();
    let names: Vec<_> = (0..recording.0.len()).map(|i| recording.frame(i).unwrap().name).collect();
    assert_eq!(names, ["depth/0.png", "depth/2.png"]);
    std::fs::write(folder.path().join("rgb.txt"), "7.0 rgb/0.png\n").unwrap();
    assert!(message(open(&folder)).contains("both lists of one recording"));
}

#[test]
fn folders_without_lists_go_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for i in [1u16, 2, 10] {
        depth_png(folder.path(), &format!("depth/d{i}.png"), (320, 240), i);
        colour_png(folder.path(), &format!("color/c{i}.png"), (320, 240), i as u8);
    }
    std::fs::write(folder.path().join("depth/notes.txt"), "x").unwrap();
    let frame = open(&folder).unwrap().frame(2).unwrap();
    assert_eq!((frame.depth[0], frame.colour.unwrap()[0], frame.stamp), (10, 10, 0.066_666_667));
    std::fs::remove_file(folder.path().join("color/c2.png")).unwrap();
    let text = message(open(&folder));
    assert!(text.contains("3 images in depth, 2 in color"), "{text}");
    std::fs::remove_dir_all(folder.path().join("color")).unwrap();
    assert!(open(&folder).unwrap().frame(0).unwrap().colour.is_none());
}

#[test]
fn nothing_to_read_is_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    assert!(message(open(&folder)).contains("neither associations.txt"));
    std::fs::create_dir(folder.path().join("depth")).unwrap();
    assert!(message(open(&folder)).contains("no frame"));
    std::fs::write(folder.path().join("depth.txt"), "# stamp file\n").unwrap();
    assert!(message(open(&folder)).contains("depth.txt lists none"));
    std::fs::write(folder.path().join("depth.txt"), "").unwrap();
    assert!(message(open(&folder)).contains("0 bytes"));
    std::fs::write(folder.path().join("depth.txt"), b"\xff\xfe1").unwrap();
    assert!(message(open(&folder)).contains("not UTF-8"));
}

#[test]
fn a_bad_frame_leaves_the_others_alone() {
    let folder = recording();
    let at = |name: &str| folder.path().join(name);
    std::fs::remove_file(at("depth/1.png")).unwrap();
    let png = std::fs::read(at("rgb/2.png")).unwrap();
    std::fs::write(at("rgb/2.png"), &png[..png.len() / 2]).unwrap();
    let recording = open(&folder).unwrap();
    assert!(recording.frame(0).is_ok());
    let text = message(recording.frame(1));
    assert!(text.contains("1.png") && text.contains("associations.txt, line 3"), "{text}");
    let text = message(recording.frame(2));
    assert!(text.contains("2.png") && text.contains("cut"), "{text}");
    std::fs::write(at("depth/1.png"), "").unwrap();
    assert!(message(open(&folder).unwrap().frame(1)).contains("1.png is empty"));
    std::fs::remove_file(at("depth/1.png")).unwrap();
    std::fs::create_dir(at("depth/1.png")).unwrap();
    assert!(message(open(&folder).unwrap().frame(1)).contains("1.png"));
}

#[test]
fn sizes_that_differ_are_both_named() {
    let folder = recording();
    colour_png(folder.path(), "rgb/0.png", (640, 480), 0);
    let text = message(open(&folder).unwrap().frame(0));
    assert!(text.contains("640x480") && text.contains("320x240"), "{text}");
    depth_png(folder.path(), "depth/1.png", (300, 240), 1);
    colour_png(folder.path(), "rgb/1.png", (300, 240), 1);
    let text = message(open(&folder).unwrap().frame(1));
    assert!(text.contains("1.png is 300x240") && text.contains("640x480"), "{text}");
    // The calibration is for 640x480, the images are QVGA.
    std::fs::write(folder.path().join("camera_info.yaml"), INFO).unwrap();
    let recording = open(&folder).unwrap();
    let error = recording.frame(2).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("camera_info.yaml") && text.contains("640x480") && text.contains("320x240"), "{text}");
    assert!(!error.is_usage());
    // The user's numbers go before the file's.
    let intrinsics = Some(parse_intrinsics("300,300,160,120").unwrap());
    let options = OpenOptions { intrinsics, ..OpenOptions::default() };
    assert_eq!(Recording::open(folder.path(), &options).unwrap().frame(2).unwrap().intrinsics.fx, 300.0);
}

#[test]
fn larger_frames_are_reduced_with_their_intrinsics() {
    let folder = tempfile::tempdir().unwrap();
    depth_png(folder.path(), "depth/0.png", (640, 480), 5000);
    colour_png(folder.path(), "rgb/0.png", (640, 480), 9);
    std::fs::write(folder.path().join("camera_info.yaml"), INFO).unwrap();
    let options = OpenOptions { depth_scale: DepthScale::Tum, ..OpenOptions::default() };
    let frame = Recording::open(folder.path(), &options).unwrap().frame(0).unwrap();
    assert_eq!((frame.factor, frame.original_size), (2, (640, 480)));
    assert_eq!((frame.intrinsics.width, frame.intrinsics.fx, frame.intrinsics.cx), (320, 262.5, 159.75));
    assert!(frame.depth.len() == 320 * 240 && frame.depth.iter().all(|&d| d == 1000));
    assert!(frame.colour.unwrap().iter().all(|&c| c == 9));
    std::fs::write(folder.path().join("camera_info.yaml"), "%&!").unwrap();
    assert!(message(open(&folder)).contains("camera_info.yaml"));
    // Another calibration instead of the folder's broken one.
    let other = folder.path().join("other.yaml");
    std::fs::write(&other, INFO).unwrap();
    let options = OpenOptions { camera_info: Some(other), ..options };
    assert!(Recording::open(folder.path(), &options).is_ok());
}

#[test]
fn a_pair_of_files_is_a_recording_of_one() {
    let folder = recording();
    let (rgb, depth) = (folder.path().join("rgb/1.png"), folder.path().join("depth/2.png"));
    let both = pair(Some(&rgb), &depth).unwrap();
    let frame = both.frame(0).unwrap();
    assert_eq!((both.0.len(), frame.depth[0], frame.colour.unwrap()[0]), (1, 1002, 1));
    let alone = pair(None, &depth).unwrap();
    assert!(alone.frame(0).unwrap().colour.is_none());
    // Colour and depth swapped.
    let swapped = pair(Some(&depth), &rgb).unwrap();
    assert!(message(swapped.frame(0)).contains("16-bit grey PNG"));
}

#[test]
fn every_recording_at_hand_can_be_read() {
    let recordings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/recordings");
    let Ok(folders) = std::fs::read_dir(&recordings) else {
        println!("SKIPPED: ../shared/data is missing");
        return;
    };
    let folders: Vec<_> = folders.map(|f| f.unwrap().path()).filter(|f| f.is_dir()).collect();
    std::thread::scope(|scope| {
        for half in folders.chunks(folders.len().div_ceil(2).max(1)) {
            scope.spawn(move || {
                for folder in half {
                    let recording = Recording::open(folder, &OpenOptions::default()).unwrap();
                    assert!(!recording.0.is_empty());
                    for i in 0..recording.0.len() {
                        let frame = recording.frame(i).unwrap();
                        let valid = frame.depth.iter().filter(|&&d| d > 0).count();
                        assert!(valid > 10_000, "{} {}: {valid} valid", folder.display(), frame.name);
                        assert_eq!(frame.colour.is_some(), !folder.ends_with("depth_only"));
                        assert_eq!((frame.factor, frame.intrinsics.validate()), (2, Ok(())));
                    }
                }
            });
        }
    });
}
