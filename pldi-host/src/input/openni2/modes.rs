//! Which of a sensor's modes is taken.

use std::ffi::c_int;

use super::sys::{self, VideoMode};
use crate::input::Mode;

/// Formats that are read, the best first.
const DEPTH: [c_int; 2] = [sys::DEPTH_1_MM, sys::DEPTH_100_UM];
const COLOUR: [c_int; 4] = [sys::RGB888, sys::YUV422, sys::YUYV, sys::GRAY8];

/// What a mode's format is called.
pub(super) fn format_name(format: c_int) -> String {
    let known = sys::FORMATS.iter().find(|(number, _)| *number == format);
    known.map_or_else(|| format!("format {format}"), |(_, name)| (*name).to_owned())
}

/// Size and rate of a mode.
pub(super) fn mode(of: &VideoMode) -> Option<Mode> {
    let [width, height, rate] = [of.width, of.height, of.rate].map(|n| u16::try_from(n).ok().filter(|&n| n > 0));
    Some(Mode { width: width?, height: height?, rate: rate? })
}

/// Modes of the depth and, where there is one, the colour sensor, of the same size and rate: the one that is wanted; else
/// QVGA, else VGA at 30 Hz, else the first that can be reduced to QVGA. An error names all that there are.
pub(super) fn choose(
    wanted: Option<Mode>,
    depth: &[VideoMode],
    colour: Option<&[VideoMode]>,
) -> Result<(VideoMode, Option<VideoMode>), String> {
    let reducible = |m: &Mode| m.width.is_multiple_of(320) && m.width / 320 * 240 == m.height;
    let candidates: Vec<Mode> = match wanted {
        Some(mode) => vec![mode],
        None => [Mode::QVGA, Mode::VGA].into_iter().chain(depth.iter().filter_map(mode).filter(reducible)).collect(),
    };
    let of_both = |wanted: Mode| {
        let depth = best(depth, wanted, &DEPTH)?;
        match colour {
            None => Some((depth, None)),
            Some(modes) => Some((depth, Some(best(modes, wanted, &COLOUR)?))),
        }
    };
    candidates.into_iter().find_map(of_both).ok_or_else(|| {
        let wanted = wanted.map_or_else(|| "that can be reduced to 320x240".to_owned(), |mode| mode.to_string());
        let colour = colour.map(|modes| format!("; colour: {}", list(modes, &COLOUR))).unwrap_or_default();
        format!("no mode {wanted} of the sensor has both images; depth: {}{colour}", list(depth, &DEPTH))
    })
}

fn best(modes: &[VideoMode], wanted: Mode, formats: &[c_int]) -> Option<VideoMode> {
    formats.iter().find_map(|&format| modes.iter().find(|m| m.format == format && mode(m) == Some(wanted)).copied())
}

/// Sizes and rates in the formats that are read.
fn list(modes: &[VideoMode], formats: &[c_int]) -> String {
    let mut names: Vec<String> = Vec::new();
    for name in modes.iter().filter(|m| formats.contains(&m.format)).filter_map(mode).map(|mode| mode.to_string()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() { "none in a format that is read".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modes(list: &[(c_int, c_int, c_int, c_int)]) -> Vec<VideoMode> {
        list.iter().map(|&(format, width, height, rate)| VideoMode { format, width, height, rate }).collect()
    }

    /// As an Asus Xtion has them, and formats that are not read.
    fn xtion() -> [Vec<VideoMode>; 2] {
        let depth =
            [(102, 320, 240, 30), (101, 320, 240, 30), (100, 320, 240, 30), (100, 640, 480, 30), (100, 320, 240, 60)];
        let colour = [(204, 320, 240, 30), (201, 320, 240, 30), (200, 320, 240, 30), (202, 640, 480, 30)];
        [modes(&depth), modes(&colour)]
    }

    #[test]
    fn qvga_in_the_best_formats_comes_first() {
        let [depth, colour] = xtion();
        let chosen = choose(None, &depth, Some(&colour)).unwrap();
        assert_eq!(chosen, (depth[2], Some(colour[2])));
        assert_eq!(choose(Some(Mode::VGA), &depth, Some(&colour)).unwrap(), (depth[3], Some(colour[3])));
        assert_eq!(choose(None, &depth[..2], Some(&colour[..2])).unwrap(), (depth[1], Some(colour[1])));
        assert_eq!(choose(None, &depth[3..], None).unwrap(), (depth[3], None));
        // Nothing but a larger one, which can be reduced.
        let large = modes(&[(100, 512, 424, 30), (100, 1280, 960, 15)]);
        assert_eq!(choose(None, &large, None).unwrap(), (large[1], None));
    }

    #[test]
    fn a_mode_that_is_not_there_is_answered_with_those_that_are() {
        let [depth, colour] = xtion();
        let wanted = Mode { width: 320, height: 240, rate: 60 };
        let error = choose(Some(wanted), &depth, Some(&colour)).unwrap_err();
        for part in ["320x240@60", "depth: 320x240@30, 640x480@30, 320x240@60;", "colour: 320x240@30, 640x480@30"] {
            assert!(error.contains(part), "{error}");
        }
        let error = choose(None, &modes(&[(100, 512, 424, 30), (103, -1, 0, 70_000)]), None).unwrap_err();
        assert!(error.contains("reduced") && error.contains("512x424@30"), "{error}");
        assert!(choose(None, &[], None).unwrap_err().contains("none"));
        assert_eq!(format_name(204), "JPEG");
        assert_eq!(format_name(7), "format 7");
    }
}
