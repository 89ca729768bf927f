//! Wavefront OBJ: positions and faces; materials, normals and textures do not matter here.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use tobj::{LoadError, LoadOptions};

use super::Parts;
use crate::Error;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Parts, Error> {
    let mut reader = Cursor::new(geometry(&String::from_utf8_lossy(bytes)));
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| Err(LoadError::OpenFileFailed)).map_err(|e| {
        // The parser stops behind the line that it refuses; indices are looked at when all lines are read.
        let read = usize::try_from(reader.position()).unwrap_or(usize::MAX);
        let text = reader.get_ref();
        if read < text.len() || e != LoadError::FaceVertexOutOfBounds {
            let line = text[..read.min(text.len())].iter().filter(|&&b| b == b'\n').count();
            Error::Line { path: path.to_owned(), line, reason: e.to_string() }
        } else {
            Error::Content { path: path.to_owned(), reason: "a face uses a vertex that the file does not have".into() }
        }
    })?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for mesh in models.into_iter().map(|m| m.mesh) {
        // Fewer than 2^32 lines of at least two bytes fit into the largest file.
        let base = vertices.len() as u32;
        vertices.extend_from_slice(mesh.positions.as_chunks::<3>().0);
        triangles.extend(mesh.indices.as_chunks::<3>().0.iter().map(|t| t.map(|i| base + i)));
    }
    Ok((vertices, triangles))
}

/// The file's `v` and `f` lines with positions alone, every other line empty so that line numbers stay.
///
/// Groups would cut the mesh to pieces, and the parser computes with texture indices before it checks them.
fn geometry(text: &str) -> Vec<u8> {
    let mut out = String::with_capacity(text.len());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let mut line = Cow::Borrowed(line.split('#').next().unwrap_or_default().trim_end());
        let mut joined = 0;
        // Appended to, not copied: a line may go on in every other one.
        while line.ends_with('\\') {
            let line = line.to_mut();
            line.pop();
            let Some(next) = lines.next() else { break };
            line.push(' ');
            line.push_str(next.trim_end());
            joined += 1;
        }
        let mut fields = line.split_whitespace();
        match fields.next() {
            // A fourth number is a weight (which CAD programs set to 1), three more are a colour: x y z will do.
            Some("v") => push(&mut out, "v", fields.take(3)),
            Some("f" | "fo") => push(&mut out, "f", fields.map(|f| f.split('/').next().unwrap_or_default())),
            _ => {}
        }
        (0..=joined).for_each(|_| out.push('\n'));
    }
    out.into_bytes()
}

fn push<'a>(out: &mut String, key: &str, fields: impl Iterator<Item = &'a str>) {
    out.push_str(key);
    for field in fields {
        out.push(' ');
        out.push_str(field);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<TriangleMesh, Error> {
        let path = Path::new("m.obj");
        parse(path, text.as_bytes()).and_then(|(v, t)| TriangleMesh::new(path, v, t))
    }

    #[test]
    fn groups_relative_indices_and_polygons() {
        let text = "mtllib x.mtl\no chair\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
                    usemtl red\ng seat\nf 1/1/1 2//1 3/1 4\ng leg\nf -4 -3 \\\n -2\nl 1 2\np 1\n";
        let mesh = read(text).unwrap();
        assert_eq!(mesh.vertices().len(), 4);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert_eq!(mesh.bounds(), ([0.0; 3], [1.0, 1.0, 0.0]));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, what) in [
            ("v 0 0 0\n# x\nv 1 x 0\nf 1 1 1\n", "m.obj, line 3"),
            ("v 0 0 0\nv 0 0\n", "m.obj, line 2"),
            ("v 0 0 0\nf 1 a 1", "m.obj, line 2"),
            ("v 0 0 0\nf 1 1 2\n", "does not have"),
            ("v 0 0 0\nf 0 1 1\n", "does not have"),
            ("v 0 0 0\nf 1 -9 1\n", "does not have"),
            ("v 0 0 0\nf 1 -9223372036854775808 1\n", ""),
            ("v 0 0 nan\nf 1 1 1\n", "not finite"),
            ("v 0 0 0\n", "no triangle"),
            ("v 0 0 0\nf 1 1\n", "no triangle"),
            ("v 0 0 0\nf\n", "m.obj"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains("m.obj") && error.contains(what), "{text:?}: {error}");
        }
        // Texture indices out of range, far enough to overflow, do not matter.
        assert!(read("v 0 0 0\nvt 0 0\nf 1/-9223372036854775807 1/9 1/0\n").is_ok());
    }

    #[test]
    fn a_line_that_goes_on_and_on_is_read_in_one_go() {
        // 2 MB: copied from line to line it would be 2 TB.
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf {}1 2 3\n", "\\\n".repeat(1 << 20));
        assert_eq!(read(&text).unwrap().triangles(), [[0, 1, 2]]);
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "([vfog] ?|[-0-9./ \n\\\\]){0,60}|\\PC{0,40}") {
            let _ = read(&text);
        }
    }
}
