//! PLY, text and binary, either byte order.

use std::io::{self, BufRead, Cursor};
use std::path::Path;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyType, ScalarType};

use super::{Parts, push_fan};
use crate::Error;
use crate::error::{excerpt, told};

/// Position of a vertex; other properties are passed over.
#[derive(Default)]
struct Vertex([f32; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f32::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return,
        };
        self.0[axis] = match property {
            Property::Float(v) => v,
            Property::Double(v) => v as f32,
            Property::Int(v) => v as f32,
            Property::UInt(v) => v as f32,
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            _ => f32::NAN,
        };
    }
}

/// Corners of a face; `u32::MAX` stands for indices that cannot be.
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) {
        fn indices<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
            list.into_iter().map(|v| v.try_into().unwrap_or(u32::MAX)).collect()
        }
        if is_corners(name) {
            self.0 = match property {
                Property::ListInt(v) => indices(v),
                Property::ListUInt(v) => v,
                Property::ListShort(v) => indices(v),
                Property::ListUShort(v) => indices(v),
                Property::ListChar(v) => indices(v),
                Property::ListUChar(v) => indices(v),
                _ => Vec::new(),
            };
        }
    }
}

fn is_corners(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

/// An element that is read only to get past it.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Parts, Error> {
    let content = |reason: String| Error::Content { path: path.to_owned(), reason };
    // The parser counts a text file's lines from 1 in the header and from 0 in each element, and not a binary one's.
    let failed = |e: io::Error, lines_before: Option<usize>| {
        let text = told(&e);
        let counted = text.strip_prefix("Line ").and_then(|r| r.split_once(": "));
        let (number, reason) = counted.map_or((None, &text[..]), |(n, rest)| (n.parse::<usize>().ok(), rest));
        let reason = format!("not a PLY file, or a damaged one: {reason}");
        match number.zip(lines_before) {
            Some((n, before)) => Error::Line { path: path.to_owned(), line: before + n, reason },
            None => content(reason),
        }
    };
    let mut reader = Cursor::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| failed(e, Some(0)))?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        let at = usize::try_from(reader.position()).unwrap_or(usize::MAX).min(bytes.len());
        let text = matches!(header.encoding, Encoding::Ascii);
        let failed = |e| failed(e, text.then(|| bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1));
        let left = reader.fill_buf().map_or(0, <[u8]>::len);
        // The header is not trusted: every element takes a byte at least, or the loop over nothing would not end.
        if element.count > left || (element.properties.is_empty() && element.count > 0) {
            let (n, name) = (element.count, excerpt(name));
            return Err(content(format!("the header has {n} of element {name}, but {left} bytes are left: it is cut")));
        }
        match name.as_str() {
            "vertex" => {
                let parser = Parser::<Vertex>::new();
                need(element, "x y z", |n, t| ["x", "y", "z"].contains(&n) && matches!(t, PropertyType::Scalar(_)), 3)
                    .map_err(content)?;
                let read = parser.read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
                vertices = read.into_iter().map(|v| v.0).collect();
            }
            "face" => {
                let list = |t: &PropertyType| matches!(t, PropertyType::List(_, k) if !matches!(k, ScalarType::Float | ScalarType::Double));
                need(element, "vertex_indices", |n, t| is_corners(n) && list(t), 1).map_err(content)?;
                let parser = Parser::<Face>::new();
                for face in parser.read_payload_for_element(&mut reader, element, &header).map_err(failed)? {
                    push_fan(&mut triangles, &face.0);
                }
            }
            _ => {
                let parser = Parser::<Skipped>::new();
                parser.read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
            }
        }
    }
    Ok((vertices, triangles))
}

/// Checks that an element has `count` properties of the right kind.
fn need(
    element: &ElementDef,
    what: &str,
    right: impl Fn(&str, &PropertyType) -> bool,
    count: usize,
) -> Result<(), String> {
    if element.properties.values().filter(|p| right(&p.name, &p.data_type)).count() == count {
        return Ok(());
    }
    Err(format!("the element {} has no properties {what} of a usable type", excerpt(&element.name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use proptest::prelude::*;

    fn read(bytes: &[u8]) -> Result<TriangleMesh, Error> {
        let path = Path::new("m.ply");
        parse(path, bytes).and_then(|(v, t)| TriangleMesh::new(path, v, t))
    }

    fn header(format: &str, list: &str) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n\
             property double z\nproperty uchar red\nelement face 2\nproperty list uchar int {list}\nend_header\n"
        )
    }

    const BODY: &str = "0 0 0.5 1\n1 0 0.5 2\n1 1 0.5 3\n0 1 0.5 4\n4 0 1 2 3\n3 0 1 3\n";

    fn binary(big: bool) -> Vec<u8> {
        let mut out =
            header(if big { "binary_big_endian" } else { "binary_little_endian" }, "vertex_indices").into_bytes();
        fn put<const N: usize>(out: &mut Vec<u8>, mut little: [u8; N], big: bool) {
            if big {
                little.reverse();
            }
            out.extend(little);
        }
        for (x, y) in [(0.0f32, 0.0f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            put(&mut out, x.to_le_bytes(), big);
            put(&mut out, y.to_le_bytes(), big);
            put(&mut out, 0.5f64.to_le_bytes(), big);
            out.push(7);
        }
        for face in [&[0i32, 1, 2, 3][..], &[0, 1, 3]] {
            out.push(face.len() as u8);
            face.iter().for_each(|i| put(&mut out, i.to_le_bytes(), big));
        }
        out
    }

    #[test]
    fn text_and_binary_give_the_same_mesh() {
        let expected = read((header("ascii", "vertex_indices") + BODY).as_bytes()).unwrap();
        assert_eq!(expected.triangles(), [[0, 1, 2], [0, 2, 3], [0, 1, 3]]);
        assert_eq!(expected.vertices()[2], [1.0, 1.0, 0.5]);
        for bytes in [
            binary(false),
            binary(true),
            (header("ascii", "vertex_index") + BODY).into_bytes(),
            (header("ascii", "vertex_index") + BODY).replace('\n', "\r\n").into_bytes(),
        ] {
            assert_eq!(read(&bytes).unwrap(), expected);
        }
    }

    #[test]
    fn cut_and_absurd_files_are_named() {
        for whole in [binary(false), (header("ascii", "vertex_indices") + BODY).into_bytes()] {
            for cut in 0..whole.len() - 3 {
                assert!(read(&whole[..cut]).unwrap_err().to_string().contains("m.ply"), "{cut}");
            }
        }
        let text = header("ascii", "vertex_indices") + BODY;
        for (from, to, what) in [
            ("vertex 4", "vertex 4000000000", "4000000000 of element vertex"),
            ("face 2", "face 18446744073709551615", "of element face"),
            ("element face 2", "element edge 9\nelement face 2", "of element edge"),
            ("property float x\n", "", "x y z"),
            ("uchar int", "uchar float", "vertex_indices"),
            ("vertex_indices", "corners", "vertex_indices"),
            ("3 0 1 3\n", "3 0 1 4\n", "uses vertex 4 of 4"),
            ("3 0 1 3\n", "3 0 1 -1\n", "uses vertex 4294967295"),
            ("4 0 1 2 3", "4000000000 0 1 2 3", "m.ply, line 16"),
            ("1 1 0.5 3", "1 1 half 3", "m.ply, line 14"),
            ("double z", "double double z", "m.ply, line 7"),
            ("4 0 1 2 3\n3 0 1 3", "2 0 1\n0", "no triangle"),
            ("0 0 0.5 1", "0 0 1e999 1", "not finite"),
        ] {
            let error = read(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
            assert!(error.contains("m.ply") && error.contains(what), "{to}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(at in 0usize..400, byte: u8, tail in prop::collection::vec(any::<u8>(), 0..40)) {
            for mut bytes in [binary(false), binary(true), (header("ascii", "vertex_indices") + BODY).into_bytes()] {
                let at = at % bytes.len();
                bytes[at] = byte;
                let _ = read(&bytes);
                bytes.truncate(at);
                bytes.extend(&tail);
                let _ = read(&bytes);
            }
        }
    }
}
