//! OFF: a header line, then vertices, then polygons, a line each. Read leniently where files in the wild differ.

use std::path::Path;

use super::{Parts, push_fan};
use crate::Error;
use crate::error::excerpt;

/// Lines without comments and blank ones, with their numbers from 1.
struct Lines<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    path: &'a Path,
    last: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a str> {
        self.lines.by_ref().find_map(|(i, line)| {
            self.last = i + 1;
            let line = line.split('#').next().unwrap_or_default().trim();
            (!line.is_empty()).then_some(line)
        })
    }

    fn wrong(&self, reason: String) -> Error {
        Error::Line { path: self.path.to_owned(), line: self.last, reason }
    }

    fn need(&mut self, what: &str, i: usize, n: usize) -> Result<&'a str, Error> {
        self.next().ok_or_else(|| self.wrong(format!("the file ends after {i} of {n} {what}: it is cut")))
    }
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Parts, Error> {
    // Comments may be in any encoding; the numbers are ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = Lines { lines: text.lines().enumerate(), path, last: 1 };
    let (n, m) = header(&mut lines)?;
    // The header is not trusted: a vertex takes 6 bytes at least ("0 0 0" and a line end), a face 2.
    let mut vertices = Vec::with_capacity(n.min(bytes.len() / 6));
    for i in 0..n {
        let line = lines.need("vertices", i, n)?;
        let mut fields = line.split_whitespace().map(str::parse::<f32>);
        let (Some(Ok(x)), Some(Ok(y)), Some(Ok(z))) = (fields.next(), fields.next(), fields.next()) else {
            return Err(lines.wrong(format!("{:?} is not a vertex (x y z)", excerpt(line))));
        };
        vertices.push([x, y, z]);
    }
    let mut triangles = Vec::with_capacity(m.min(bytes.len() / 2));
    let mut corners = Vec::new();
    for i in 0..m {
        let line = lines.need("faces", i, m)?;
        let wrong = || format!("{:?} is not a face (number of corners, then as many vertices)", excerpt(line));
        let mut fields = line.split_whitespace();
        let Some(count) = fields.next().and_then(|f| f.parse::<usize>().ok()) else { return Err(lines.wrong(wrong())) };
        corners.clear();
        // What follows the corners is a colour.
        for field in fields.take(count) {
            match field.parse::<u32>() {
                Ok(v) if (v as usize) < n => corners.push(v),
                Ok(v) => return Err(lines.wrong(format!("vertex {v} of {n} (counted from 0)"))),
                Err(_) => return Err(lines.wrong(wrong())),
            }
        }
        if corners.len() != count {
            return Err(lines.wrong(wrong()));
        }
        push_fan(&mut triangles, &corners);
    }
    Ok((vertices, triangles))
}

/// Reads `OFF`, then the numbers of vertices and faces, in the next line or in the same one (`OFF 8 6 0`, `OFF8 6 0`).
/// The variants with normals, colours or texture coordinates after x y z are read as well.
fn header(lines: &mut Lines<'_>) -> Result<(usize, usize), Error> {
    let first = lines.next().unwrap_or_default();
    let rest = ["OFF", "COFF", "NOFF", "CNOFF", "STOFF"].iter().find_map(|magic| first.strip_prefix(magic));
    let rest = match rest.map(str::trim_start) {
        Some(rest) if !rest.contains("BINARY") => rest,
        _ => return Err(lines.wrong(format!("{:?}: not a text OFF file, which begins with OFF", excerpt(first)))),
    };
    let counts = if rest.is_empty() { lines.next().unwrap_or_default() } else { rest };
    let mut fields = counts.split_whitespace().map(str::parse::<usize>);
    match (fields.next(), fields.next()) {
        (Some(Ok(n)), Some(Ok(m))) => Ok((n, m)),
        _ => Err(lines.wrong(format!("{:?} are not the numbers of vertices and faces", excerpt(counts)))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n4 0 1 2 3\n3 0 1 3 255 0 0\n2 0 1\n";

    fn read(text: &str) -> Result<Parts, Error> {
        parse(Path::new("m.off"), text.as_bytes())
    }

    #[test]
    fn headers_of_every_kind() {
        let expected = (
            vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]],
            vec![[0, 1, 2], [0, 2, 3], [0, 1, 3]],
        );
        for header in ["OFF\n4 3 0\n", "OFF4 3 0\n", "OFF 4 3 0\n", "# made by x\nOFF # y\n\n4 3\n", "OFF\r\n4 3 0\r\n"]
        {
            assert_eq!(read(&format!("{header}{BODY}")).unwrap(), expected, "{header:?}");
        }
        let coloured = "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 255 0 0 255\n3 0 1 2\n";
        assert_eq!(read(coloured).unwrap().1, [[0, 1, 2]]);
        let latin1 = b"OFF\n# caf\xe9\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
        assert!(parse(Path::new("m.off"), latin1).is_ok());
    }

    #[test]
    fn mistakes_are_named_by_line() {
        for (text, what) in [
            ("", "begins with OFF"),
            ("PLY\n", "begins with OFF"),
            ("OFF BINARY\n1 1 1\n", "begins with OFF"),
            ("OFF\nx y\n", "line 2: \"x y\""),
            ("OFF\n-3 1 0\n", "line 2"),
            ("OFF\n3 1 0\n0 0\n", "line 3: \"0 0\" is not a vertex"),
            ("OFF\n99999999999 1 0\n0 0 0\n", "ends after 1 of 99999999999 vertices"),
            ("OFF\n1 18446744073709551615 0\n0 0 0\n", "ends after 0 of 18446744073709551615 faces"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: vertex 1 of 1"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 -1\n", "line 4"),
            ("OFF\n1 1 0\n0 0 0\n4 0 0 0\n", "line 4"),
            ("OFF\n1 1 0\n0 0 0\n99999999999999 0 0 0\n", "line 4"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains("m.off") && error.contains(what), "{text:?}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(head in "(OFF)?[ \n]?", bytes in prop::collection::vec(any::<u8>(), 0..60), text in "[0-9 \n.e-]{0,80}") {
            let path = Path::new("m.off");
            let _ = parse(path, &[head.as_bytes(), &bytes].concat());
            if let Ok((v, t)) = parse(path, format!("{head}{text}").as_bytes()) {
                let _ = crate::mesh::TriangleMesh::new(path, v, t);
            }
        }
    }
}
