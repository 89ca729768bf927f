//! Triangle meshes of furniture: readers for OFF, OBJ, STL and PLY, and bringing a mesh to metres on the floor.

mod obj;
mod off;
mod ply;
mod prepare;
mod stl;

use std::path::Path;

pub use prepare::{Size, Unit, Up};

use crate::Error;
use crate::input::files;

/// Largest mesh file read.
const MAX_BYTES: u64 = 1 << 30;

/// Triangles over shared vertices. Made by [`TriangleMesh::new`] it is sound: at least one triangle, every coordinate
/// finite, every index in range, every vertex used.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Checks the parts and drops vertices that no triangle uses (they would count in the bounding box).
    ///
    /// # Errors
    /// `Content` with the name `path` where there is no triangle, a vertex is not finite or an index is out of range.
    pub fn new(path: &Path, mut vertices: Vec<[f32; 3]>, mut triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        let content = |reason: String| Error::Content { path: path.to_owned(), reason };
        if triangles.is_empty() {
            return Err(content("the mesh has no triangle".into()));
        }
        let mut used = vec![false; vertices.len()];
        for (i, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                match used.get_mut(v as usize) {
                    Some(flag) => *flag = true,
                    None => {
                        let n = vertices.len();
                        return Err(content(format!("triangle {i} uses vertex {v} of {n} (counted from 0)")));
                    }
                }
            }
        }
        if let Some(i) = vertices.iter().zip(&used).position(|(v, &u)| u && !v.iter().all(|c| c.is_finite())) {
            return Err(content(format!("vertex {i} (counted from 0) is not finite: {:?}", vertices[i])));
        }
        if used.contains(&false) {
            let mut next = 0;
            let renumbered: Vec<u32> = used
                .iter()
                .map(|&u| {
                    next += u32::from(u);
                    next.wrapping_sub(1)
                })
                .collect();
            for v in triangles.iter_mut().flatten() {
                *v = renumbered[*v as usize];
            }
            let mut keep = used.iter();
            vertices.retain(|_| keep.next() == Some(&true));
        }
        Ok(Self { vertices, triangles })
    }

    /// Reads a mesh file by its extension: `.off`, `.obj`, `.stl` or `.ply`. Polygons become fans of triangles.
    ///
    /// # Errors
    /// `Usage` for other extensions, else what is wrong with the file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let parse = reader(path)?;
        let (vertices, triangles) = parse(path, &files::read(path, MAX_BYTES)?)?;
        Self::new(path, vertices, triangles)
    }

    /// The same of a file's bytes: `path` gives the extension, and the name in messages.
    ///
    /// # Errors
    /// As [`TriangleMesh::read`].
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let (vertices, triangles) = reader(path)?(path, bytes)?;
        Self::new(path, vertices, triangles)
    }

    /// The vertices.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// The triangles, as indices of vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The vertices and triangles themselves.
    pub fn into_parts(self) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        (self.vertices, self.triangles)
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let first = self.vertices.first().copied().unwrap_or_default();
        self.vertices.iter().fold((first, first), |(mut low, mut high), v| {
            for i in 0..3 {
                low[i] = low[i].min(v[i]);
                high[i] = high[i].max(v[i]);
            }
            (low, high)
        })
    }
}

/// Vertices and triangles as read, not yet checked.
type Parts = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// What makes a mesh of a file's bytes; the path is for messages.
type Reader = fn(&Path, &[u8]) -> Result<Parts, Error>;

/// What reads a file with the extension of `path`.
fn reader(path: &Path) -> Result<Reader, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "off" => Ok(off::parse),
        "obj" => Ok(obj::parse),
        "stl" => Ok(stl::parse),
        "ply" => Ok(ply::parse),
        _ => {
            let text = format!("{}: meshes are read from .off, .obj, .stl and .ply files", path.display());
            Err(Error::Usage(text))
        }
    }
}

/// Adds a polygon as a fan about its first corner; fewer than three corners (points, edges) add nothing.
fn push_fan(triangles: &mut Vec<[u32; 3]>, corners: &[u32]) {
    if let [first, rest @ ..] = corners {
        triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unused_vertices_are_dropped_and_bad_ones_named() {
        let path = Path::new("m.off");
        let corner = |x| [x, 0.0, 0.0];
        let nan = [f32::NAN; 3];
        let mesh = TriangleMesh::new(path, vec![nan, corner(1.0), corner(9.0), corner(2.0)], vec![[3, 1, 1]]).unwrap();
        assert_eq!(mesh.into_parts(), (vec![corner(1.0), corner(2.0)], vec![[1, 0, 0]]));
        let message = |v, t| TriangleMesh::new(path, v, t).unwrap_err().to_string();
        assert!(message(vec![corner(0.0), nan], vec![[0, 0, 1]]).contains("vertex 1"));
        assert!(message(vec![corner(0.0)], vec![[0, 0, 0], [0, 1, 0]]).contains("triangle 1 uses vertex 1 of 1"));
        assert!(message(vec![corner(0.0)], vec![]).contains("no triangle"));
    }

    #[test]
    fn unknown_formats_are_a_usage_mistake() {
        for name in ["chair", "chair.fbx", ".off"] {
            assert!(TriangleMesh::read(Path::new(name)).unwrap_err().is_usage());
        }
        assert!(!TriangleMesh::read(Path::new("/nowhere/chair.OFF")).unwrap_err().is_usage());
    }

    #[test]
    fn an_empty_file_of_every_format_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.off", "a.obj", "a.stl", "a.ply"] {
            let path = folder.path().join(name);
            for content in ["", "\n", "\0\u{1}\u{2}", "solid x\n", "OFF\n", "ply\n", "f 1 2 3\n"] {
                std::fs::write(&path, content).unwrap();
                let text = TriangleMesh::read(&path).unwrap_err().to_string();
                assert!(text.contains(name), "{content:?}: {text}");
            }
        }
    }
}
