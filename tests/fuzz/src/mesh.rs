//! Mesh files.

use std::path::Path;

use pldi_host::mesh::{Size, TriangleMesh, Unit, Up};

pub fn off(bytes: &[u8]) {
    mesh("mesh.off", bytes);
}

pub fn obj(bytes: &[u8]) {
    mesh("mesh.obj", bytes);
}

pub fn stl(bytes: &[u8]) {
    mesh("mesh.stl", bytes);
}

pub fn ply(bytes: &[u8]) {
    mesh("mesh.ply", bytes);
}

fn mesh(name: &str, bytes: &[u8]) {
    let mesh = match TriangleMesh::parse(Path::new(name), bytes) {
        Ok(mesh) => mesh,
        Err(error) => return super::refused(&error, name),
    };
    let (vertices, triangles) = (mesh.vertices(), mesh.triangles());
    // Each takes bytes of the file.
    assert!(!triangles.is_empty() && triangles.len() <= bytes.len() && vertices.len() <= bytes.len());
    assert!(vertices.iter().flatten().all(|c| c.is_finite()));
    let mut used = vec![false; vertices.len()];
    triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    assert!(!used.contains(&false));
    for (up, size, longest) in
        [(Up::Z, Size::Unit(Unit::Metre), 1e3), (Up::Y, Size::Unit(Unit::Inch), 1e3), (Up::Z, Size::Longest(0.8), 0.8)]
    {
        let Ok(prepared) = mesh.clone().prepared(up, size) else { continue };
        let (low, high) = prepared.bounds();
        let side = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
        assert!(side.is_finite() && side <= 1.001 * longest && low[2] == 0.0, "{low:?} {high:?}");
    }
}
