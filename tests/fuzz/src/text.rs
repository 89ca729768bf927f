//! Lists, calibrations and what a user types.

use std::cmp::Ordering;
use std::collections::HashSet;

use pldi_host::input::{DepthScale, IntrinsicsSpec, fuzz};
use pldi_host::mesh::{Unit, Up};

pub fn associations(bytes: &[u8]) {
    let frames = match fuzz::associations(bytes) {
        Ok(frames) => frames,
        Err(error) => return super::refused(&error, "associations.txt"),
    };
    // Each takes four fields of a line.
    assert!(frames.len() <= bytes.len().div_ceil(8));
    for (stamp, colour, depth) in &frames {
        assert!(!depth.is_empty() && colour.as_ref().is_some_and(|name| !name.is_empty()));
        assert_eq!(stamp.to_string().parse(), Ok(*stamp));
        assert!(stamp.seconds().is_finite());
    }
    let names: Vec<&str> = frames.iter().take(8).map(|frame| frame.2.as_str()).collect();
    is_an_order(&names);
}

/// The lists of colour and depth images, with a zero between them.
pub fn lists(bytes: &[u8]) {
    let split = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let (colour, depth) = (&bytes[..split], bytes.get(split + 1..).unwrap_or_default());
    let frames = match fuzz::lists(colour, depth) {
        Ok(frames) => frames,
        Err(error) => return super::refused(&error, ".txt"),
    };
    let lines = |list: &[u8]| list.split(|&b| b == b'\n').count();
    assert!(frames.len() <= lines(colour).min(lines(depth)));
    assert!(frames.is_sorted_by(|a, b| a.0 <= b.0));
}

/// That the order of names is one: sorting may panic otherwise.
fn is_an_order(names: &[&str]) {
    for a in names {
        for b in names {
            let order = fuzz::natural(a, b);
            assert_eq!(order, fuzz::natural(b, a).reverse(), "{a:?} {b:?}");
            assert_eq!(order == Ordering::Equal, a == b, "{a:?} {b:?}");
            for c in names {
                let chain = order.is_le() && fuzz::natural(b, c).is_le();
                assert!(!chain || fuzz::natural(a, c).is_le(), "{a:?} {b:?} {c:?}");
            }
        }
    }
    let mut sorted = names.to_vec();
    sorted.sort_by(|a, b| fuzz::natural(a, b));
    assert_eq!(sorted.iter().collect::<HashSet<_>>(), names.iter().collect());
}

pub fn camera_info(bytes: &[u8]) {
    match fuzz::camera_info(bytes) {
        Ok(intrinsics) => assert_eq!(intrinsics.validate(), Ok(())),
        Err(error) => super::refused(&error, "camera_info.yaml"),
    }
}

/// What is given on the command line: intrinsics, scales, units.
pub fn intrinsics(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(spec) = text.parse::<IntrinsicsSpec>() {
        let IntrinsicsSpec { fx, fy, cx, cy, size } = spec;
        assert!(fx > 0.0 && fy > 0.0 && [fx, fy, cx, cy].iter().all(|v| v.is_finite()));
        assert!(size.is_none_or(|(w, h)| w > 0 && h > 0));
    }
    if let Ok(scale) = text.parse::<DepthScale>() {
        assert_eq!(scale.to_string().parse::<DepthScale>().ok(), Some(scale));
        assert!([0, 1, 1000, u16::MAX].iter().all(|&raw| scale.to_mm(raw) <= 10_000));
    }
    if let Ok(unit) = text.parse::<Unit>() {
        assert!(unit.metres() > 0.0 && unit.metres().is_finite());
        assert_eq!(unit.to_string().parse::<Unit>().ok(), Some(unit));
    }
    if let Ok(up) = text.parse::<Up>() {
        assert_eq!(up.to_string().parse::<Up>().ok(), Some(up));
    }
}
