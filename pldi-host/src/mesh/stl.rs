//! STL, text and binary.

use std::io::Cursor;
use std::path::Path;

use super::Parts;
use crate::Error;
use crate::error::told;

/// Bytes before the triangles of a binary file, and of each triangle.
const HEADER: usize = 84;
const RECORD: usize = 50;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Parts, Error> {
    let mut parts = Parts::default();
    if !is_text(bytes) {
        // The reader takes everything that begins with "solid " for text, which many binary files do.
        let mut binary = bytes.to_vec();
        binary.iter_mut().take(5).for_each(|b| *b = 0);
        append(path, binary, &mut parts)?;
        return Ok(parts);
    }
    // One file may hold several solids, of which the reader takes the first; names may be missing or in any encoding.
    let text = String::from_utf8_lossy(bytes).to_lowercase();
    let mut solid = String::new();
    for line in text.lines() {
        let word = line.split_whitespace().next().unwrap_or_default();
        match word {
            "solid" => solid.push_str("solid \n"),
            "endsolid" => {
                solid.push_str("endsolid\n");
                append(path, std::mem::take(&mut solid).into_bytes(), &mut parts)?;
            }
            // The normal is not used, and some programs write "nan" for slivers.
            "facet" => solid.push_str("facet normal 0 0 0\n"),
            "" => {}
            _ => {
                solid.push_str(line);
                solid.push('\n');
            }
        }
    }
    if !solid.is_empty() {
        return Err(Error::Content {
            path: path.to_owned(),
            reason: "the file ends before endsolid: it is cut".into(),
        });
    }
    Ok(parts)
}

/// A file is binary when its length is that of its number of triangles, whatever it begins with.
fn is_text(bytes: &[u8]) -> bool {
    let counted = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let binary = counted.is_some_and(|n| bytes.len() as u64 == HEADER as u64 + u64::from(n) * RECORD as u64);
    !binary && bytes.trim_ascii_start().get(..5).is_some_and(|head| head.eq_ignore_ascii_case(b"solid"))
}

fn append(path: &Path, bytes: Vec<u8>, (vertices, triangles): &mut Parts) -> Result<(), Error> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| {
        let reason = match e.kind() {
            std::io::ErrorKind::UnexpectedEof => "the file ends before its last triangle: it is cut".into(),
            _ => format!("not an STL file: {}", told(&e)),
        };
        Error::Content { path: path.to_owned(), reason }
    })?;
    // Fewer than 2^32 triangles of 50 bytes fit into the largest file.
    let base = vertices.len() as u32;
    vertices.extend(mesh.vertices.iter().map(|v| v.0));
    triangles.extend(mesh.faces.iter().map(|f| f.vertices.map(|i| base + i as u32)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use stl_io::{Normal, Triangle, Vertex};

    fn read(bytes: &[u8]) -> Result<TriangleMesh, Error> {
        let path = Path::new("m.stl");
        parse(path, bytes).and_then(|(v, t)| TriangleMesh::new(path, v, t))
    }

    fn binary(header: &[u8]) -> Vec<u8> {
        let corner = |x, y| Vertex::new([x, y, 0.5]);
        let normal = Normal::new([0.0, 0.0, 1.0]);
        let vertices = [
            [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
            [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        ];
        let triangles = vertices.map(|vertices| Triangle { normal, vertices });
        let mut out = Vec::new();
        stl_io::write_stl(&mut out, triangles.iter()).unwrap();
        out[..header.len()].copy_from_slice(header);
        out
    }

    fn ascii(name: &str) -> String {
        let facet = |a: &str, b: &str| {
            format!(
                "facet normal nan 0 1\n outer loop\n  vertex 0 0 0.5\n  vertex {a} 0.5\n  vertex {b} 5e-1\n endloop\nendfacet\n"
            )
        };
        format!("solid{name}\n{}{}endsolid{name}\n", facet("1 0", "1 1"), facet("1 1", "0 1"))
    }

    #[test]
    fn text_and_binary_give_the_same_mesh() {
        let expected = read(&binary(b"made by hand")).unwrap();
        assert_eq!(expected.triangles(), [[0, 1, 2], [0, 2, 3]]);
        // A binary file may call itself solid, a text may have no name, capitals or DOS line ends.
        assert_eq!(read(&binary(b"solid chair")).unwrap(), expected);
        for text in [ascii(""), ascii(" chair"), ascii(" a b").to_uppercase(), ascii(" x").replace('\n', "\r\n")] {
            assert_eq!(read(text.as_bytes()).unwrap(), expected, "{text}");
        }
        assert_eq!(read(&[&ascii(" a"), "\n", &ascii(" b")].concat().into_bytes()).unwrap().triangles().len(), 4);
    }

    #[test]
    fn cut_files_are_named() {
        let whole = binary(b"solid x");
        for cut in 0..whole.len() {
            let error = read(&whole[..cut]).unwrap_err().to_string();
            assert!(error.contains("m.stl"), "{cut}: {error}");
        }
        let text = ascii(" x");
        for cut in 0..text.rfind("endsolid").unwrap() + 7 {
            assert!(read(&text.as_bytes()[..cut]).is_err(), "{cut}");
        }
        let mut absurd = binary(b"");
        absurd[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(read(&absurd).unwrap_err().to_string().contains("cut"));
        let mut empty = binary(b"");
        empty.truncate(84);
        empty[80..84].fill(0);
        assert!(read(&empty).unwrap_err().to_string().contains("no triangle"));
        assert!(read(ascii("").replace("0.5", "inf").as_bytes()).is_err());
    }
}
