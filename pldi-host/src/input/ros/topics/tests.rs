use super::*;

fn topic(name: &str, encoding: &str, (w, h): (u32, u32)) -> Topic {
    let kind = match name {
        n if n.ends_with("camera_info") => "CameraInfo",
        n if n.contains("/compressed") => "CompressedImage",
        _ => "Image",
    };
    let type_name = format!("sensor_msgs/msg/{kind}");
    let sample = Some(Sample { encoding: encoding.into(), size: (w > 0).then_some((w, h)) });
    Topic { channel: Channel { topic: name.into(), type_name, encoding: "cdr".into() }, count: 9, sample }
}

const VGA: (u32, u32) = (640, 480);

fn chosen(topics: &[Topic], options: &OpenOptions) -> Result<(String, Option<String>, Option<String>), Error> {
    let Chosen { depth, colour, info } = choose(Path::new("x.mcap"), topics, options)?;
    Ok((depth.topic, colour.map(|c| c.topic), info.map(|c| c.topic)))
}

#[track_caller]
fn expect(topics: &[Topic], depth: &str, colour: &str, info: &str) {
    let text = |s: &str| (!s.is_empty()).then(|| s.to_owned());
    let expected = (depth.to_owned(), text(colour), text(info));
    assert_eq!(chosen(topics, &OpenOptions::default()).unwrap(), expected);
    let reversed: Vec<Topic> = topics.iter().rev().cloned().collect();
    assert_eq!(chosen(&reversed, &OpenOptions::default()).unwrap(), expected, "whatever their order");
}

#[test]
fn the_names_of_usual_drivers() {
    // A Kinect of the first kind, as in the TUM recordings.
    let info = |name| topic(name, "plumb_bob", VGA);
    expect(
        &[
            topic("/camera/rgb/image_color", "rgb8", VGA),
            topic("/camera/depth/image", "32FC1", VGA),
            info("/camera/rgb/camera_info"),
            info("/camera/depth/camera_info"),
        ],
        "/camera/depth/image",
        "/camera/rgb/image_color",
        "/camera/depth/camera_info",
    );
    // openni2_launch with registration.
    expect(
        &[
            topic("/camera/depth/image_raw", "16UC1", VGA),
            topic("/camera/depth_registered/sw_registered/image_rect_raw", "16UC1", VGA),
            topic("/camera/ir/image", "mono16", VGA),
            topic("/camera/rgb/image_raw", "rgb8", VGA),
            topic("/camera/rgb/image_raw/compressed", "rgb8; jpeg compressed bgr8", (0, 0)),
            info("/camera/depth_registered/camera_info"),
            info("/camera/depth/camera_info"),
        ],
        "/camera/depth_registered/sw_registered/image_rect_raw",
        "/camera/rgb/image_raw",
        "/camera/depth_registered/camera_info",
    );
    // RealSense, everything compressed.
    expect(
        &[
            topic(
                "/camera/camera/aligned_depth_to_color/image_raw/compressedDepth",
                "16UC1; compressedDepth png",
                (0, 0),
            ),
            topic("/camera/camera/depth/image_rect_raw/compressedDepth", "16UC1; compressedDepth png", (0, 0)),
            topic("/camera/camera/color/image_raw/compressed", "rgb8; jpeg compressed bgr8", (0, 0)),
            topic("/camera/camera/infra1/image_rect_raw/compressed", "mono8; jpeg compressed ", (0, 0)),
            info("/camera/camera/aligned_depth_to_color/camera_info"),
            info("/camera/camera/color/camera_info"),
        ],
        "/camera/camera/aligned_depth_to_color/image_raw/compressedDepth",
        "/camera/camera/color/image_raw/compressed",
        "/camera/camera/aligned_depth_to_color/camera_info",
    );
    // Azure Kinect.
    expect(
        &[
            topic("/depth/image_raw", "16UC1", (640, 576)),
            topic("/depth_to_rgb/image_raw", "16UC1", (1280, 720)),
            topic("/ir/image_raw", "mono16", (640, 576)),
            topic("/rgb/image_raw", "bgra8", (1280, 720)),
            info("/rgb/camera_info"),
        ],
        "/depth_to_rgb/image_raw",
        "/rgb/image_raw",
        "/rgb/camera_info",
    );
}

#[test]
fn what_is_uncompressed_near_and_of_one_size_comes_first() {
    expect(
        &[
            topic("/left/depth/image_raw", "16UC1", VGA),
            topic("/left/depth/image_raw/compressedDepth", "16UC1; compressedDepth", (0, 0)),
            topic("/left/color/image_raw", "rgb8", VGA),
            topic("/right/color/image_raw", "rgb8", VGA),
            topic("/a/color/image_raw", "rgb8", VGA),
        ],
        "/left/depth/image_raw",
        "/left/color/image_raw",
        "",
    );
    expect(&[topic("/d", "16UC1", VGA), topic("/a", "rgb8", (1280, 720)), topic("/b", "rgb8", VGA)], "/d", "/b", "");
    // Infrared is better than no picture; without samples names must do.
    expect(&[topic("/ir/image", "16UC1", VGA), topic("/depth/image", "16UC1", VGA)], "/depth/image", "/ir/image", "");
    let unread = |name: &str| Topic { sample: None, ..topic(name, "", VGA) };
    expect(&[unread("/depth/image"), unread("/rgb/image")], "/depth/image", "/rgb/image", "");
    expect(&[unread("/depth/image")], "/depth/image", "", "");
}

#[test]
fn options_go_first_and_are_checked() {
    let topics = [
        topic("/d", "16UC1", VGA),
        topic("/e", "mono16", VGA),
        topic("/a", "rgb8", VGA),
        topic("/x/camera_info", "", VGA),
    ];
    let options = |colour: Option<&str>, depth: Option<&str>, info: Option<&str>| OpenOptions {
        colour_topic: colour.map(Into::into),
        depth_topic: depth.map(Into::into),
        info_topic: info.map(Into::into),
        ..OpenOptions::default()
    };
    let got = chosen(&topics, &options(Some("/e"), None, Some("/x/camera_info"))).unwrap();
    assert_eq!(got, ("/d".into(), Some("/e".into()), Some("/x/camera_info".into())));
    assert_eq!(chosen(&topics, &options(None, Some("/e"), None)).unwrap().0, "/e");
    for (options, message) in [
        (options(Some("/nowhere"), None, None), "--color /nowhere"),
        (options(None, Some("/x/camera_info"), None), "Image or CompressedImage are needed"),
        (options(None, None, Some("/a")), "CameraInfo are needed"),
    ] {
        let error = chosen(&topics, &options).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains(message), "{error}");
        assert!(error.to_string().contains("x.mcap"), "{error}");
    }
}

#[test]
fn without_depth_the_topics_are_listed() {
    let mut foreign = topic("/depth", "", VGA);
    foreign.channel =
        Channel { topic: "/depth".into(), type_name: "foxglove.RawImage".into(), encoding: "protobuf".into() };
    let error = chosen(&[topic("/a", "rgb8", VGA), foreign], &OpenOptions::default()).unwrap_err();
    let text = error.to_string();
    for part in ["no depth topic", "/a (sensor_msgs/msg/Image in cdr, 9 messages)", "foxglove.RawImage in protobuf"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!error.is_usage());
    assert!(chosen(&[], &OpenOptions::default()).unwrap_err().to_string().contains("no topics at all"));
}
