//! Writes the seeds of the corpus that nobody would write by hand: `cargo run --example seeds` in this folder.

use std::io::Write as _;
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

/// A message as ROS 2 or ROS 1 writes it: numbers of four bytes, texts and bytes, and a few of eight bytes at the end.
struct Message {
    bytes: Vec<u8>,
    cdr: bool,
}

impl Message {
    fn new(cdr: bool, stamp: u32) -> Self {
        let bytes = if cdr { vec![0, 1, 0, 0] } else { vec![9, 0, 0, 0] };
        Self { bytes, cdr }.u32(1_700_000_000).u32(stamp).text("camera")
    }

    fn align(&mut self, n: usize) {
        while self.cdr && !(self.bytes.len() - 4).is_multiple_of(n) {
            self.bytes.push(0);
        }
    }

    fn u32(mut self, value: u32) -> Self {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
        self
    }

    fn f64(mut self, value: f64) -> Self {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
        self
    }

    fn text(self, text: &str) -> Self {
        let nul: &[u8] = if self.cdr { &[0] } else { &[] };
        self.data(&[text.as_bytes(), nul].concat())
    }

    fn data(mut self, data: &[u8]) -> Self {
        self = self.u32(data.len() as u32);
        self.bytes.extend(data);
        self
    }
}

fn ros_image(cdr: bool, size: (u32, u32), encoding: &str, step: u32) -> Vec<u8> {
    let mut message = Message::new(cdr, 5).u32(size.1).u32(size.0).text(encoding);
    message.bytes.push(0);
    let data: Vec<u8> = (0..step * size.1).map(|i| (i * 7 % 256) as u8).collect();
    message.u32(step).data(&data).bytes
}

fn ros_info(cdr: bool) -> Vec<u8> {
    let mut message = Message::new(cdr, 5).u32(240).u32(320).text("plumb_bob").u32(5);
    for value in [0.0; 5].iter().chain(&[262.5, 0.0, 160.0, 0.0, 262.5, 120.0, 0.0, 0.0, 1.0]).chain(&[0.0; 21]) {
        message = message.f64(*value);
    }
    message = (0..6).fold(message, |message, _| message.u32(0));
    message.bytes.push(0);
    message.bytes
}

/// The number as RVL writes it.
fn rvl(numbers: &[u32]) -> Vec<u8> {
    let mut nibbles = Vec::new();
    for mut number in numbers.iter().copied() {
        loop {
            let more = number >> 3;
            nibbles.push((number & 7) as u8 | if more > 0 { 8 } else { 0 });
            number = more;
            if number == 0 {
                break;
            }
        }
    }
    nibbles.resize(nibbles.len().next_multiple_of(8), 0);
    let word = |n: &[u8]| n.iter().fold(0u32, |word, n| word << 4 | u32::from(*n)).to_le_bytes();
    nibbles.chunks(8).flat_map(word).collect()
}

/// The transport's header, and 320 x 240 pixels of which few are not 0.
fn packed_depth(width: u32, height: u32) -> Vec<u8> {
    let mut data = vec![0; 4];
    data.extend(1000f32.to_le_bytes());
    data.extend(0f32.to_le_bytes());
    data.extend(width.to_le_bytes());
    data.extend(height.to_le_bytes());
    let rest = width * height - 5;
    data.extend(rvl(&[2, 3, 2000, 1, 4, rest, 0]));
    data
}

fn ros_messages() {
    for cdr in [true, false] {
        let (ros, what) = if cdr { ("ros2", 0) } else { ("ros1", 1) };
        for (encoding, step) in [
            ("rgb8", 14),
            ("bgra8", 16),
            ("mono8", 4),
            ("mono16", 9),
            ("bayer_rggb8", 4),
            ("bayer_gbrg8", 5),
            ("yuv422", 8),
            ("yuv422_yuy2", 8),
            ("16UC1", 8),
            ("32FC1", 16),
        ] {
            let message = ros_image(cdr, (4, 3), encoding, step);
            write("cdr", &format!("{ros}_{encoding}"), &[&[what | 2], &message[..]].concat());
        }
        write("cdr", &format!("{ros}_info"), &[&[what], &ros_info(cdr)[..]].concat());
        let picture = png(4, 3, ExtendedColorType::L8, &[9; 12]);
        let message = Message::new(cdr, 5).text("rgb8; png compressed bgr8").data(&picture).bytes;
        write("cdr", &format!("{ros}_png"), &[&[what], &message[..]].concat());
        let message = Message::new(cdr, 5).text("16UC1; compressedDepth rvl").data(&packed_depth(4, 3)).bytes;
        write("cdr", &format!("{ros}_rvl"), &[&[what], &message[..]].concat());
    }
    for (name, format, data) in [
        ("rvl", 0, packed_depth(4, 3)),
        ("rvl_inverse", 1, packed_depth(320, 240)),
        ("png", 2, [&packed_depth(4, 3)[..12], &png(3, 1, ExtendedColorType::L16, &[1, 2, 3, 4, 5, 6])].concat()),
        (
            "png_inverse",
            3,
            [&packed_depth(4, 3)[..12], &png(3, 1, ExtendedColorType::L16, &[1, 2, 3, 4, 5, 6])].concat(),
        ),
        ("bare", 6, png(2, 1, ExtendedColorType::L16, &[1, 2, 3, 4])),
    ] {
        write("compressed_depth", name, &[&[format], &data[..]].concat());
    }
}

/// Two frames of compressed depth, flat colour, and the calibration: topic, type and message.
fn talk(cdr: bool) -> Vec<(usize, Vec<u8>)> {
    let colour = png(320, 240, ExtendedColorType::L8, &[80; 320 * 240]);
    let frame = |stamp: u32| {
        [
            (0, Message::new(cdr, stamp).text("16UC1; compressedDepth rvl").data(&packed_depth(320, 240)).bytes),
            (1, Message::new(cdr, stamp + 3_000_000).text("png").data(&colour).bytes),
            (2, ros_info(cdr)),
        ]
    };
    [frame(1), frame(33_000_000)].concat()
}

const TOPICS: [(&str, &str); 3] = [
    ("/camera/depth/compressedDepth", "CompressedImage"),
    ("/camera/rgb/compressed", "CompressedImage"),
    ("/camera/rgb/camera_info", "CameraInfo"),
];

fn compressed(name: &str, bytes: &[u8]) -> Vec<u8> {
    match name {
        "zstd" => zstd::encode_all(bytes, 19).unwrap(),
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        "bz2" => {
            let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        _ => bytes.to_vec(),
    }
}

fn mcap_files() {
    let record = |kind: u8, body: &[u8]| [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let magic = b"\x89MCAP0\r\n";
    let mut declared = Vec::new();
    for (id, (topic, kind)) in (1u16..).zip(TOPICS) {
        let id = id.to_le_bytes();
        let name = text(&format!("sensor_msgs/msg/{kind}"));
        declared.extend(record(3, &[&id[..], &name, &text("ros2msg"), &text("")].concat()));
        declared.extend(record(4, &[&id[..], &id, &text(topic), &text("cdr"), &[0; 4]].concat()));
    }
    let messages: Vec<u8> = (1u64..)
        .zip(talk(true))
        .flat_map(|(time, (topic, data))| {
            let (id, time) = ((topic as u16 + 1).to_le_bytes(), time.to_le_bytes());
            record(5, &[&id[..], &[0; 4], &time, &time, &data].concat())
        })
        .collect();
    let content = [declared.clone(), messages].concat();
    let chunk = |name: &str| {
        let (packed, size) = (compressed(name, &content), (content.len() as u64).to_le_bytes());
        let length = (packed.len() as u64).to_le_bytes();
        // Without a checksum, which no mutation would keep.
        record(6, &[&[0; 16][..], &size, &[0; 4], &text(name), &length, &packed].concat())
    };
    let head = [&magic[..], &record(1, &[text("ros2"), text("by hand")].concat())].concat();
    let end = |data: Vec<u8>| {
        let mut data = [data, record(15, &[0; 4])].concat();
        let start = data.len() as u64;
        data.extend(&declared);
        let counts: Vec<u8> = (1u16..4).flat_map(|id| [&id.to_le_bytes()[..], &2u64.to_le_bytes()].concat()).collect();
        data.extend(record(11, &[&[0; 42][..], &(counts.len() as u32).to_le_bytes(), &counts].concat()));
        data.extend(record(2, &[&start.to_le_bytes()[..], &[0; 12]].concat()));
        data.extend(magic);
        data
    };
    write("mcap", "plain", &end([head.clone(), record(9, &[3; 40]), content.clone()].concat()));
    for name in ["", "zstd", "lz4"] {
        let chunked = [head.clone(), chunk(name)].concat();
        let file = if name == "" { "chunk" } else { name };
        write("mcap", &format!("{file}_cut"), &chunked[..chunked.len() - 30]);
        write("mcap", file, &end(chunked));
    }
}

fn bags() {
    let header = |fields: &[(&str, &[u8])]| -> Vec<u8> {
        let field = |(name, value): &(&str, &[u8])| {
            [&((name.len() + 1 + value.len()) as u32).to_le_bytes(), name.as_bytes(), b"=", value].concat()
        };
        fields.iter().flat_map(field).collect()
    };
    let record = |fields: &[(&str, &[u8])], data: &[u8]| {
        let header = header(fields);
        let (h, d) = ((header.len() as u32).to_le_bytes(), (data.len() as u32).to_le_bytes());
        [&h, header.as_slice(), &d, data].concat()
    };
    let mut connections = Vec::new();
    for (id, (topic, kind)) in (0u32..).zip(TOPICS) {
        let (kind, topic) = (format!("sensor_msgs/{kind}"), topic.as_bytes());
        let data =
            header(&[("topic", topic), ("type", kind.as_bytes()), ("md5sum", b"*"), ("message_definition", b"")]);
        connections.extend(record(&[("conn", &id.to_le_bytes()), ("op", &[7]), ("topic", topic)], &data));
    }
    let messages: Vec<u8> = (1u32..)
        .zip(talk(false))
        .flat_map(|(time, (topic, data))| {
            let time = [time.to_le_bytes(), [5, 0, 0, 0]].concat();
            record(&[("op", &[2]), ("conn", &(topic as u32).to_le_bytes()), ("time", &time)], &data)
        })
        .collect();
    let content = [connections.clone(), messages].concat();
    let file = |name: &str, index: u64| {
        let head: &[(&str, &[u8])] = &[
            ("op", &[3]),
            ("index_pos", &index.to_le_bytes()),
            ("conn_count", &[3, 0, 0, 0]),
            ("chunk_count", &[1, 0, 0, 0]),
        ];
        let size = (content.len() as u32).to_le_bytes();
        let chunk: &[(&str, &[u8])] = &[("op", &[5]), ("compression", name.as_bytes()), ("size", &size)];
        let index: &[(&str, &[u8])] = &[("op", &[4]), ("ver", &[1, 0, 0, 0]), ("conn", &[0; 4]), ("count", &[0; 4])];
        [b"#ROSBAG V2.0\n", &record(head, b"  ")[..], &record(chunk, &compressed(name, &content)), &record(index, &[])]
            .concat()
    };
    for name in ["none", "bz2", "lz4"] {
        let cut = file(name, 0);
        let counts: Vec<u8> = (0u32..3).flat_map(|id| [id.to_le_bytes(), 2u32.to_le_bytes()].concat()).collect();
        let info = record(&[("op", &[6]), ("ver", &[1, 0, 0, 0]), ("count", &[3, 0, 0, 0])], &counts);
        write("bag", name, &[&file(name, cut.len() as u64)[..], &connections, &info].concat());
        write("bag", &format!("{name}_cut"), &cut[..cut.len() - 60]);
    }
    let unchunked =
        [&file("none", 0)[..0], b"#ROSBAG V2.0\n", &record(&[("op", &[3]), ("index_pos", &[0; 8])], b""), &content]
            .concat();
    write("bag", "no_chunk", &unchunked);
}

fn main() {
    ros_messages();
    mcap_files();
    bags();
    images();
    meshes();
    template_files();
    serial();
}
