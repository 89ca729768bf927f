//! From a file's units and axes to metres, z up, standing on the floor at the origin.

use std::fmt;
use std::str::FromStr;

use super::TriangleMesh;
use crate::Error;

/// Which axis of a file points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// z, as in robotics and in most OFF files.
    #[default]
    Z,
    /// y, as in most OBJ files.
    Y,
}

impl FromStr for Up {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "z" | "Z" => Ok(Self::Z),
            "y" | "Y" => Ok(Self::Y),
            _ => Err(Error::Usage(format!("up axis {text:?}: give z or y"))),
        }
    }
}

impl fmt::Display for Up {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Z => "z",
            Self::Y => "y",
        })
    }
}

/// Unit of a file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Unit {
    /// Metres.
    #[default]
    Metre,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// Inches of 25.4 mm.
    Inch,
    /// So many metres: positive and finite.
    Metres(f64),
}

impl Unit {
    /// The unit's length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Inch => 0.0254,
            Self::Metres(m) => m,
        }
    }
}

impl FromStr for Unit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "m" => Ok(Self::Metre),
            "cm" => Ok(Self::Centimetre),
            "mm" => Ok(Self::Millimetre),
            "inch" | "in" => Ok(Self::Inch),
            number => match number.parse::<f64>() {
                Ok(m) if m > 0.0 && m.is_finite() => Ok(Self::Metres(m)),
                _ => Err(Error::Usage(format!(
                    "unit {text:?}: give m, cm, mm, inch, or a positive number of metres that one unit is long"
                ))),
            },
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Metre => f.write_str("m"),
            Self::Centimetre => f.write_str("cm"),
            Self::Millimetre => f.write_str("mm"),
            Self::Inch => f.write_str("inch"),
            Self::Metres(m) => write!(f, "{m}"),
        }
    }
}

/// How large a mesh is to become.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// As large as the file says in this unit.
    Unit(Unit),
    /// The longest side of the bounding box is this long in metres, whatever the file says.
    Longest(f64),
}

impl Default for Size {
    fn default() -> Self {
        Self::Unit(Unit::Metre)
    }
}

/// Longest side of a mesh that makes sense in metres: more is a wrong unit, and less could not be rendered.
const LONGEST: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

impl TriangleMesh {
    /// The mesh in metres, z up, standing on z = 0, the centre of its bounding box over the origin.
    ///
    /// # Errors
    /// `Usage` where the mesh has no size or one of less than a millimetre or more than a kilometre.
    pub fn prepared(mut self, up: Up, size: Size) -> Result<Self, Error> {
        if up == Up::Y {
            for [_, y, z] in &mut self.vertices {
                (*y, *z) = (-*z, *y);
            }
        }
        // In f64, where the difference of any two f32 is finite.
        let (low, high) = self.bounds();
        let (low, high) = (low.map(f64::from), high.map(f64::from));
        let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let scale = match size {
            Size::Unit(unit) => unit.metres(),
            Size::Longest(side) => side / longest,
        };
        // Written so that NaN fails the test.
        if !(longest > 0.0 && LONGEST.contains(&(longest * scale))) {
            return Err(Error::Usage(format!(
                "the mesh's longest side is {longest} in the file and would be {} m: give its unit, or the side's length",
                longest * scale
            )));
        }
        let origin = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]];
        for vertex in &mut self.vertices {
            for (v, o) in vertex.iter_mut().zip(origin) {
                *v = ((f64::from(*v) - o) * scale) as f32;
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A tetrahedron over a box of 200 x 100 x 50 at some place.
    fn mesh(at: f32) -> TriangleMesh {
        let v = vec![[at, at, at], [at + 200.0, at, at], [at, at + 100.0, at], [at, at, at + 50.0]];
        TriangleMesh::new(Path::new("m"), v, vec![[0, 1, 2], [0, 1, 3]]).unwrap()
    }

    #[test]
    fn it_stands_on_the_floor_in_metres() {
        let mesh = mesh(1000.0).prepared(Up::Z, Size::Unit(Unit::Centimetre)).unwrap();
        assert_eq!(mesh.bounds(), ([-1.0, -0.5, 0.0], [1.0, 0.5, 0.5]));
        assert_eq!(mesh.vertices()[3], [-1.0, -0.5, 0.5]);
    }

    #[test]
    fn y_up_becomes_z_up_without_mirroring() {
        // (x, y, z) -> (x, -z, y): the corner at y = 100 goes to the top, the one at z = 50 towards -y.
        let mesh = mesh(0.0).prepared(Up::Y, Size::Longest(2.0)).unwrap();
        assert_eq!(mesh.vertices(), [[-1.0, 0.25, 0.0], [1.0, 0.25, 0.0], [-1.0, 0.25, 1.0], [-1.0, -0.25, 0.0]]);
    }

    #[test]
    fn units_parse_and_print_alike() {
        for (text, metres) in [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("inch", 0.0254), ("0.3048", 0.3048)] {
            let unit: Unit = text.parse().unwrap();
            assert_eq!((unit.metres(), unit.to_string().as_str()), (metres, text));
        }
        for text in ["", "foot", "0", "-1", "nan", "inf"] {
            assert!(text.parse::<Unit>().unwrap_err().is_usage());
        }
        assert_eq!(("y".parse::<Up>().unwrap(), Up::Y.to_string().as_str()), (Up::Y, "y"));
        assert!("x".parse::<Up>().is_err());
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        let point = TriangleMesh::new(Path::new("m"), vec![[1.0; 3]], vec![[0, 0, 0]]).unwrap();
        for size in [Size::default(), Size::Longest(1.0)] {
            assert!(point.clone().prepared(Up::Z, size).is_err());
        }
        for size in [f64::NAN, 0.0, -1.0, f64::INFINITY, 1e9] {
            let text = mesh(0.0).prepared(Up::Z, Size::Longest(size)).unwrap_err().to_string();
            assert!(text.contains("200"), "{text}");
        }
        assert!(mesh(0.0).prepared(Up::Z, Size::Unit(Unit::Metres(1e-300))).is_err());
        let huge = vec![[-3e38; 3], [3e38; 3], [0.0; 3]];
        let huge = TriangleMesh::new(Path::new("m"), huge, vec![[0, 1, 2]]).unwrap();
        assert_eq!(huge.prepared(Up::Z, Size::Longest(1.0)).unwrap().bounds(), ([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0]));
    }
}
