//! The camera's intrinsics as the user gives them, and which apply to an image.

use std::path::Path;
use std::str::FromStr;

use pldi_core::Intrinsics;

use crate::Error;
use crate::error::IntrinsicsOrigin;

/// Intrinsics as given on the command line; without a size they are meant for the images at hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntrinsicsSpec {
    /// Horizontal focal length in pixels.
    pub fx: f64,
    /// Vertical focal length in pixels.
    pub fy: f64,
    /// Column of the principal point in pixels.
    pub cx: f64,
    /// Row of the principal point in pixels.
    pub cy: f64,
    /// Width and height of the images that the numbers are for.
    pub size: Option<(u16, u16)>,
}

/// Parses `fx,fy,cx,cy` with an optional `@WxH`, all in pixels.
///
/// # Errors
/// `Usage` where the text has another form, `Intrinsics` where a number is absurd.
pub fn parse_intrinsics(text: &str) -> Result<IntrinsicsSpec, Error> {
    let wrong =
        || Error::Usage(format!("intrinsics {text:?}: give fx,fy,cx,cy in pixels, e.g. 525,525,319.5,239.5@640x480"));
    let (numbers, size) = match text.split_once('@') {
        None => (text, None),
        Some((numbers, size)) => {
            let (w, h) = size.split_once(['x', 'X']).ok_or_else(wrong)?;
            let [w, h] = [w, h].map(|s| s.trim().parse::<u16>().ok().filter(|n| *n > 0));
            (numbers, Some((w.ok_or_else(wrong)?, h.ok_or_else(wrong)?)))
        }
    };
    let mut values = [0.0; 4];
    let mut fields = numbers.split(',');
    for value in &mut values {
        *value = fields.next().and_then(|s| s.trim().parse().ok()).ok_or_else(wrong)?;
    }
    if fields.next().is_some() {
        return Err(wrong());
    }
    let [fx, fy, cx, cy] = values;
    let spec = IntrinsicsSpec { fx, fy, cx, cy, size };
    match size {
        Some(size) => spec.for_size(size).map(|_| ())?,
        // Without a size only what no size can mend: the rest is checked against the first image.
        None => {
            for (name, value) in [("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)] {
                finite(&IntrinsicsOrigin::Option, name, value)?;
            }
            for (name, value) in [("fx", fx), ("fy", fy)] {
                if value <= 0.0 {
                    return Err(absurd(&IntrinsicsOrigin::Option, name, value, "must be positive"));
                }
            }
        }
    }
    Ok(spec)
}

impl FromStr for IntrinsicsSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        parse_intrinsics(text)
    }
}

impl IntrinsicsSpec {
    /// The numbers with their size, checked.
    fn for_size(&self, size: (u16, u16)) -> Result<Intrinsics, Error> {
        checked(&IntrinsicsOrigin::Option, size, [self.fx, self.fy, self.cx, self.cy])
    }
}

/// Intrinsics from four numbers (fx, fy, cx, cy) for images of a size; an absurd number is named.
pub(super) fn checked(origin: &IntrinsicsOrigin, size: (u16, u16), k: [f64; 4]) -> Result<Intrinsics, Error> {
    let named = [("fx", k[0]), ("fy", k[1]), ("cx", k[2]), ("cy", k[3])];
    for (name, value) in named {
        finite(origin, name, value)?;
    }
    let [fx, fy, cx, cy] = k.map(|v| v as f32);
    let intrinsics = Intrinsics { width: size.0, height: size.1, fx, fy, cx, cy };
    match intrinsics.validate() {
        Ok(()) => Ok(intrinsics),
        Err(pldi_core::Error::OutOfRange(name) | pldi_core::Error::NotFinite(name)) => {
            let value = named.iter().find(|(n, _)| *n == name).map_or(f64::NAN, |(_, v)| *v);
            Err(absurd(origin, name, value, &format!("cannot be for images of {}x{}", size.0, size.1)))
        }
        Err(other) => Err(Error::Usage(format!("{origin}: {other}"))),
    }
}

fn finite(origin: &IntrinsicsOrigin, name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(absurd(origin, name, value, "is not a finite number")) }
}

fn absurd(origin: &IntrinsicsOrigin, name: &'static str, value: f64, reason: &str) -> Error {
    Error::Intrinsics { origin: origin.clone(), name, value, reason: reason.to_owned() }
}

/// Where a recording's intrinsics come from, before the size of its images is known.
#[derive(Debug, Clone)]
pub(super) enum Camera {
    /// The user's numbers.
    Option(IntrinsicsSpec),
    /// Those of a file, or that the source knows.
    Known(Intrinsics, IntrinsicsOrigin),
    /// Nothing known: the nominal structured-light camera.
    Default,
}

impl Camera {
    /// Where the intrinsics come from.
    pub(super) fn origin(&self) -> IntrinsicsOrigin {
        match self {
            Self::Option(_) => IntrinsicsOrigin::Option,
            Self::Known(_, origin) => origin.clone(),
            Self::Default => IntrinsicsOrigin::Default,
        }
    }

    /// The intrinsics of `image`, which has `size`.
    pub(super) fn for_image(&self, image: &Path, size: (u16, u16)) -> Result<Intrinsics, Error> {
        let fits = |calibrated: (u16, u16), origin: IntrinsicsOrigin| {
            if calibrated == size {
                return Ok(());
            }
            let size = (u32::from(size.0), u32::from(size.1));
            Err(Error::IntrinsicsSize { image: image.to_owned(), size, intrinsics: calibrated, origin })
        };
        match self {
            Self::Option(spec) => {
                if let Some(calibrated) = spec.size {
                    fits(calibrated, IntrinsicsOrigin::Option)?;
                }
                spec.for_size(size)
            }
            Self::Known(intrinsics, origin) => {
                fits((intrinsics.width, intrinsics.height), origin.clone())?;
                Ok(*intrinsics)
            }
            Self::Default => Intrinsics::PRIMESENSE_QVGA
                .resampled(size.0, size.1)
                .map_err(|e| Error::Content { path: image.to_owned(), reason: e.to_string() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn four_numbers_and_a_size() {
        let plain = parse_intrinsics("525, 526,319.5,239.5").unwrap();
        assert_eq!(plain, IntrinsicsSpec { fx: 525.0, fy: 526.0, cx: 319.5, cy: 239.5, size: None });
        assert_eq!("525,526,319.5,239.5@640x480".parse::<IntrinsicsSpec>().unwrap().size, Some((640, 480)));
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        for (text, name) in [
            ("nan,525,319.5,239.5", "fx = NaN"),
            ("525,inf,319.5,239.5", "fy = inf"),
            ("525,525,1e999,1", "cx = inf"),
            ("0,525,319.5,239.5", "fx = 0"),
            ("525,-3,319.5,239.5", "fy = -3"),
            ("525,525,319.5,1e6@640x480", "cy = 1000000"),
            ("1e300,525,319.5,239.5@640x480", "fx = 1"),
        ] {
            let error = parse_intrinsics(text).unwrap_err();
            assert!(error.is_usage() && error.to_string().contains(name), "{text}: {error}");
        }
        for text in
            ["", "1,2,3", "1,2,3,4,5", "a,b,c,d", "1,2,3,4@", "1,2,3,4@640", "1,2,3,4@0x480", "1,2,3,4@640x99999"]
        {
            assert!(matches!(parse_intrinsics(text), Err(Error::Usage(_))), "{text}");
        }
    }

    #[test]
    fn the_default_is_the_primesense_camera_at_the_size() {
        let k = Camera::Default.for_image(Path::new("d.png"), (640, 480)).unwrap();
        assert!((k.fx - 571.26).abs() < 1e-3 && k.cx == 319.5 && k.cy == 239.5);
        assert_eq!(Camera::Default.for_image(Path::new("d.png"), (320, 240)).unwrap(), Intrinsics::PRIMESENSE_QVGA);
    }

    #[test]
    fn another_size_is_refused_with_both() {
        let spec = parse_intrinsics("285.63,285.63,159.5,119.5@320x240").unwrap();
        let error = Camera::Option(spec).for_image(Path::new("d.png"), (640, 480)).unwrap_err();
        let text = error.to_string();
        assert!(error.is_usage() && text.contains("320x240") && text.contains("640x480"), "{text}");
        // Without a size they are for the image, which may show that they cannot be.
        let spec = parse_intrinsics("10,525,159.5,119.5").unwrap();
        let error = Camera::Option(spec).for_image(Path::new("d.png"), (640, 480)).unwrap_err();
        assert!(error.to_string().contains("fx = 10"), "{error}");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[-+0-9.,@x naife]{0,40}|\\PC{0,30}") {
            if let Ok(spec) = parse_intrinsics(&text) {
                let _ = Camera::Option(spec).for_image(Path::new("d"), (640, 480));
            }
        }
    }
}
