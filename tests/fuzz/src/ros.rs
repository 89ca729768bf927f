//! Messages of ROS, and the files that hold them.

use std::io::Write;
use std::path::Path;

use pldi_host::input::{OpenOptions, Stop, fuzz, open};

/// Two bits for the serialisation and for what the message is, then the message.
pub fn cdr(bytes: &[u8]) {
    let Some((&what, message)) = bytes.split_first() else { return };
    let (cdr, compressed) = (what & 1 == 0, what & 2 == 0);
    fuzz::ros_header(cdr, message);
    match fuzz::ros_info(cdr, message) {
        Ok(intrinsics) => assert_eq!(intrinsics.validate(), Ok(())),
        Err(error) => super::refused(&error, "camera_info"),
    }
    match fuzz::ros_colour(cdr, compressed, message) {
        Ok((w, h, values)) => assert_eq!(values.len(), 3 * usize::from(w) * usize::from(h)),
        Err(error) => super::refused(&error, "colour"),
    }
    depth(cdr, compressed, message);
}

fn depth(cdr: bool, compressed: bool, message: &[u8]) {
    match fuzz::ros_depth(cdr, compressed, message) {
        Ok((w, h, values)) => assert_eq!(values.len(), usize::from(w) * usize::from(h)),
        Err(error) => super::refused(&error, "depth"),
    }
}

/// A format, by its number, and what `CompressedImage` has as data: the transport's header, PNG or RVL.
pub fn compressed_depth(bytes: &[u8]) {
    const FORMATS: [&str; 8] = [
        "16UC1; compressedDepth rvl",
        "32FC1; compressedDepth rvl",
        "16UC1; compressedDepth png",
        "32FC1; compressedDepth png",
        "16UC1; compressedDepth",
        "16UC1",
        "png",
        "16UC1; png compressed ",
    ];
    let Some((&format, data)) = bytes.split_first() else { return };
    let format = FORMATS[usize::from(format) % FORMATS.len()];
    // As ROS 1 writes it: counter, time, frame, format, data.
    let mut message = vec![0; 16];
    for part in [format.as_bytes(), data] {
        message.extend((part.len() as u32).to_le_bytes());
        message.extend(part);
    }
    depth(false, true, &message);
}

pub fn mcap(bytes: &[u8]) {
    recording("input.mcap", bytes);
}

pub fn bag(bytes: &[u8]) {
    recording("input.bag", bytes);
}

/// Opens a recording and decodes its frames.
fn recording(name: &str, bytes: &[u8]) {
    thread_local! {
        static FOLDER: tempfile::TempDir = {
            let memory = Path::new("/dev/shm");
            if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.expect("a folder")
        };
    }
    FOLDER.with(|folder| {
        let path = folder.path().join(name);
        std::fs::File::create(&path).and_then(|mut file| file.write_all(bytes)).expect("a file");
        let uri = path.to_str().expect("a name");
        let mut input = match open(uri, &OpenOptions::default()) {
            Ok(input) => input,
            Err(error) => return super::refused(&error, name),
        };
        // Each frame takes a message.
        for _ in 0..=bytes.len() / 10 {
            match input.raw(&Stop::default()) {
                Ok(None) => return,
                Ok(Some((index, raw))) => {
                    if let Some((intrinsics, _)) = raw.camera {
                        assert_eq!(intrinsics.validate(), Ok(()));
                    }
                    match input.prepare(index, raw) {
                        Ok(frame) => assert_eq!(frame.qvga.intrinsics.validate(), Ok(())),
                        Err(error) => super::refused(&error, name),
                    }
                }
                Err(error) => return super::refused(&error, name),
            }
        }
        panic!("more frames than the file has messages");
    });
}
