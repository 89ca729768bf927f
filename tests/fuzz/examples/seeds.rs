//! Writes the seeds of the corpus that nobody would write by hand: `cargo run --example seeds` in this folder.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::jpeg::JpegEncoder, codecs::png::PngEncoder};
use pldi_core::templates::layout::{self, Class, Header, Object, Record};
use pldi_host::templates::{EMBEDDED, fixed_file};
use zerocopy::{FromBytes, IntoBytes};

fn write(target: &str, name: &str, bytes: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), bytes).unwrap();
}

fn png(w: u32, h: u32, kind: ExtendedColorType, bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    PngEncoder::new(&mut out).write_image(bytes, w, h, kind).unwrap();
    out
}

fn images() {
    let kinds = [
        ("l8.png", ExtendedColorType::L8, 1),
        ("la8.png", ExtendedColorType::La8, 2),
        ("rgb8.png", ExtendedColorType::Rgb8, 3),
        ("rgba8.png", ExtendedColorType::Rgba8, 4),
        ("l16.png", ExtendedColorType::L16, 2),
        ("rgb16.png", ExtendedColorType::Rgb16, 6),
    ];
    for (name, kind, size) in kinds {
        let bytes: Vec<u8> = (0..7 * 5 * size).map(|i| (i * 37 % 251) as u8).collect();
        write("image", name, &png(7, 5, kind, &bytes));
    }
    // Sizes that are reduced.
    let flat: Vec<u16> = (0..320 * 240).map(|i| 900 + (i / 3200) as u16 * 64).collect();
    write("image", "depth_qvga.png", &png(320, 240, ExtendedColorType::L16, flat.as_bytes()));
    write("image", "colour_vga.png", &png(640, 480, ExtendedColorType::L8, &[77; 640 * 480]));
    for (name, kind, size) in [("l8.jpg", ExtendedColorType::L8, 1), ("rgb8.jpg", ExtendedColorType::Rgb8, 3)] {
        let bytes: Vec<u8> = (0..24 * 17 * size).map(|i| (i * 11 % 256) as u8).collect();
        let mut out = Vec::new();
        JpegEncoder::new_with_quality(&mut out, 40).write_image(&bytes, 24, 17, kind).unwrap();
        write("image", name, &out);
    }
}

/// A tetrahedron in binary files.
fn meshes() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0f32]];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3u32]];
    let mut stl = [b' '; 80].to_vec();
    stl.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        stl.extend([0; 12]);
        triangle.iter().flat_map(|&v| vertices[v as usize]).for_each(|c| stl.extend(c.to_le_bytes()));
        stl.extend([0; 2]);
    }
    write("stl", "binary", &stl);
    stl[..5].copy_from_slice(b"solid");
    write("stl", "binary_named_solid", &stl);
    for (name, big) in [("little_endian", false), ("big_endian", true)] {
        let mut ply = format!(
            "ply\nformat binary_{name} 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty double y\n\
             property float z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n\
             element edge 1\nproperty list ushort short ends\nend_header\n"
        )
        .into_bytes();
        let mut put = |little: &[u8]| {
            let mut bytes = little.to_vec();
            if big {
                bytes.reverse();
            }
            ply.extend(bytes);
        };
        for [x, y, z] in vertices {
            put(&x.to_le_bytes());
            put(&f64::from(y).to_le_bytes());
            put(&z.to_le_bytes());
            put(&[200]);
        }
        for triangle in triangles {
            put(&[3]);
            triangle.iter().for_each(|v| put(&v.to_le_bytes()));
        }
        put(&2u16.to_le_bytes());
        put(&0i16.to_le_bytes());
        put(&1i16.to_le_bytes());
        write("ply", name, &ply);
    }
}

/// The built-in set with one object of each class and two views of each.
fn template_files() {
    let (header, rest) = Header::ref_from_prefix(EMBEDDED).unwrap();
    let (classes, rest) = <[Class]>::ref_from_prefix_with_elems(rest, header.classes.into()).unwrap();
    let (objects, rest) = <[Object]>::ref_from_prefix_with_elems(rest, header.objects.into()).unwrap();
    let records = <[Record]>::ref_from_bytes(rest).unwrap();
    let first: Vec<usize> =
        (0..classes.len()).filter_map(|c| objects.iter().position(|o| usize::from(o.class) == c)).collect();
    let mut header = *header;
    (header.objects, header.templates) = ((first.len() as u16).into(), (2 * first.len() as u32).into());
    let mut file = header.as_bytes().to_vec();
    file.extend(classes.as_bytes());
    first.iter().for_each(|&object| file.extend(objects[object].as_bytes()));
    for (i, &object) in first.iter().enumerate() {
        for record in records.iter().filter(|r| usize::from(r.object) == object).take(2) {
            file.extend(Record { object: (i as u16).into(), ..*record }.as_bytes());
        }
    }
    layout::seal(&mut file);
    write("templates", "floats", &file);
    write("templates", "codes", &fixed_file(&file).unwrap());
    let mut empty = header;
    (empty.classes, empty.objects, empty.templates) = (0.into(), 0.into(), 0.into());
    let mut file = empty.as_bytes().to_vec();
    layout::seal(&mut file);
    write("templates", "empty", &file);
}

/// Scripts of what is on a line, see `src/serial.rs`, and what a device says.
fn serial() {
    let packet = |script: &mut Vec<u8>, kind: u8, payload: &[u8]| {
        script.extend([1, kind, 3, payload.len() as u8, 0]);
        script.extend(payload);
    };
    let mut script = vec![1];
    let requests: [(u8, &[u8]); 5] =
        [(1, &[9, 0, 0, 0]), (2, &[1, 2, 3, 4]), (3, &[1, 0]), (18, &[7, 0, 0, 0]), (99, &[])];
    for (kind, payload) in requests {
        packet(&mut script, kind, payload);
    }
    script.extend([0, 4, 0, 5, 255, 0]);
    write("serial_device", "packets", &script);
    let line = fuzz::serial::line(&script);
    write("serial_device", "line", &line);
    let mut all = fuzz::serial::device(&line);
    // Two boxes on the floor, one that floats, and a wall; then parts of frames, and noise.
    let boxes = [
        [40, 25, 90, 85, 130, 200],
        [100, 30, 100, 64, 160, 20],
        [10, 9, 40, 20, 110, 255],
        [0, 160, 0, 110, 240, 150],
    ];
    for (name, format, rows, ends, pattern) in [
        ("frame", 0, 240, 0, &[][..]),
        ("frame_rgb565", 1, 240, 0, &[3, 1, 4, 1, 5]),
        ("frame_rgb888", 2, 240, 0, &[0; 3]),
        ("frame_without_begin", 0, 30, 1, &[]),
        ("frame_without_end", 0, 30, 2, &[]),
        ("noise", 0, 240, 0, &[9, 250, 0, 77, 123, 4, 255, 31, 1]),
    ] {
        let mut script = vec![1, 2, 7, format, 2, rows, ends, 40, boxes.len() as u8, pattern.len() as u8];
        script.extend(boxes.as_flattened());
        script.extend(pattern);
        write("serial_device", name, &script);
        let said = fuzz::serial::device(&fuzz::serial::line(&script));
        println!("{name}: {} bytes from the device", said.len());
        all.extend(said);
    }
    write("serial_host", "answers", &all);
    let mut script = vec![1];
    packet(&mut script, 129, &[7; 36]);
    packet(&mut script, 130, &[7; 64]);
    packet(&mut script, 131, &[&[0, 0, 2, 0][..], b"chair", &[0; 27]].concat());
    packet(&mut script, 145, &[1, 0, 0, 0, 2, 0, 3, 0]);
    // A detection with a hypothesis, and a rejected cluster.
    let mut result = vec![0; 44 + 36 + 14 + 24];
    (result[23], result[40], result[42], result[46]) = (3, 1, 1, 1);
    packet(&mut script, 144, &result);
    write("serial_host", "script", &script);
}

fn main() {
    images();
    meshes();
    template_files();
    serial();
}
