//! Against bytes that another implementation of the encoding made of the same messages (the Python library rosbags).

use super::*;

const IMAGE: &str = "\
    0001000000f1536515cd5b070400000063616d00010000000200000006000000 6d6f6e6f38000000020000000200000007ff";

const CAMERA_INFO: &str = "\
    0001000000f1536515cd5b070400000063616d00f0000000400100000a000000 706c756d625f626f6200000005 z52 687040 z13 \
    f06340 z13 6c70400000000000d05d40 z22 f03f z6 f03f z30 f03f z30 f03f0000000000687040 z13 f06340 z21 \
    6c70400000000000d05d40 z30 f03f z33";

const DETECTIONS: &str = "\
    0001000000f1536515cd5b070400000063616d000100000000f1536515cd5b07 0400000063616d0002000000060000006368616972 \
    z13 e83f z6 e03f z6 d0bf z7 40 z14 e03f z14 e83f z288 0900000061726d6368616972 z10 e03f z6 e03f z6 d0bf z7 \
    40 z14 e03f z14 e83f z294 e03f z6 d0bf z7 40 z14 e03f z14 e83f z6 e03f z6 f03f z6 d03f0100000000";

const MARKERS: &str = "\
    000100000300000000f1536515cd5b070400000063616d0001 z11 0100000003 z57 f03f z60 01 z15 01 z7 01 z15 01 z7 01 \
    z7 01 z16 f1536515cd5b070400000063616d0006000000626f7865730000000400000001 z17 e03f z6 d0bf z7 40 z14 e03f \
    z14 e83f z6 e03f z6 f03f z6 d03f0000803f0000003f0000803e0000003f z20 01 z15 01 z7 01 z15 01 z7 01 z7 01 z16 \
    f1536515cd5b070400000063616d0008000000636c6173736573000400000009 z17 e03f z6 d0bf z7 40 z14 e03f z14 e83f \
    z22 c03f0000803f0000003f0000803e0000803f z20 01 z15 01 z7 01 z15 0b000000636861697220302e3735000001 z7 01 \
    z12";

/// Bytes written as hexadecimal digits, long runs of zeros as `zN`.
fn bytes(text: &str) -> Vec<u8> {
    let word = |word: &str| match word.strip_prefix('z') {
        Some(count) => vec![0; count.parse().unwrap()],
        None => (0..word.len()).step_by(2).map(|i| u8::from_str_radix(&word[i..i + 2], 16).unwrap()).collect(),
    };
    text.split_whitespace().flat_map(word).collect()
}

fn header() -> Header<'static> {
    Header::new(Stamp(1_700_000_000_123_456_789), "cam").unwrap()
}

const POSE: Pose = Pose { position: [0.5, -0.25, 2.0], orientation: [0.0, 0.5, 0.0, 0.75] };

#[test]
fn images() {
    assert_eq!(image(&header(), (2, 1), Encoding::Mono8, &[7, 255]), bytes(IMAGE));
}

#[test]
fn cameras() {
    let camera = Intrinsics { width: 320, height: 240, fx: 262.5, fy: 262.75, cx: 159.5, cy: 119.25 };
    assert_eq!(camera_info(&header(), &camera), bytes(CAMERA_INFO));
}

#[test]
fn candidates() {
    let results = vec![("chair", 0.75), ("armchair", 0.5)];
    let detection = Detection { results, pose: POSE, size: [0.5, 1.0, 0.25] };
    assert_eq!(detections(&header(), &[detection]), bytes(DETECTIONS));
}

#[test]
fn boxes_and_their_classes() {
    let cube = Marker { id: 4, shape: Shape::Cube([0.5, 1.0, 0.25]), pose: POSE, colour: [1.0, 0.5, 0.25, 0.5] };
    let text = Shape::Text("chair 0.75".to_owned(), 0.125);
    let text = Marker { id: 4, shape: text, pose: POSE, colour: [1.0, 0.5, 0.25, 1.0] };
    assert_eq!(markers(&header(), &[cube, text]), bytes(MARKERS));
}

#[test]
fn times_before_the_epoch_and_beyond_what_ros_counts() {
    let header = Header::new(Stamp(-1), "").unwrap();
    assert_eq!((header.seconds, header.nanoseconds), (-1, 999_999_999));
    let last = i64::from(i32::MAX) * SECOND + SECOND - 1;
    assert!(Header::new(Stamp(last), "").is_ok());
    for late in [last + 1, i64::MAX, i64::MIN] {
        assert!(Header::new(Stamp(late), "").unwrap_err().to_string().contains("2038"));
    }
}
