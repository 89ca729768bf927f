//! Triangle meshes in metres: z is up, objects stand on z = 0 and are centred on x = y = 0, their front faces +x.

mod solids;
mod texture;

pub use texture::{Material, Texture};

use crate::vec3::{add, dot};

/// One triangle of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Triangle {
    /// Indices of the corners in [`Mesh::vertices`].
    pub v: [u32; 3],
    /// Index in [`Mesh::materials`].
    pub material: u16,
}

/// A triangle mesh with materials. Triangles are seen from both sides, their orientation does not matter.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners in metres.
    pub vertices: Vec<[f32; 3]>,
    /// Faces.
    pub triangles: Vec<Triangle>,
    /// What the faces look like.
    pub materials: Vec<Material>,
}

/// A box along the axes, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: [f32; 3],
    /// Greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// Extent along x, y and z in metres.
    #[must_use]
    pub fn size(&self) -> [f32; 3] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1], self.max[2] - self.min[2]]
    }

    /// The middle, in metres.
    #[must_use]
    pub fn centre(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }
}

/// A rotation followed by a translation (metres).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Rows of the rotation matrix.
    pub rotation: [[f32; 3]; 3],
    /// Translation in metres.
    pub translation: [f32; 3],
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// Moves by `t` metres.
    #[must_use]
    pub const fn translate(t: [f32; 3]) -> Self {
        Self { translation: t, ..Self::IDENTITY }
    }

    /// Turns about the x axis by `angle` rad (y towards z).
    #[must_use]
    pub fn rotate_x(angle: f32) -> Self {
        let (s, c) = libm::sincosf(angle);
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]], translation: [0.0; 3] }
    }

    /// Turns about the y axis by `angle` rad (z towards x).
    #[must_use]
    pub fn rotate_y(angle: f32) -> Self {
        let (s, c) = libm::sincosf(angle);
        Self { rotation: [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]], translation: [0.0; 3] }
    }

    /// Turns about the z axis by `angle` rad (x towards y).
    #[must_use]
    pub fn rotate_z(angle: f32) -> Self {
        let (s, c) = libm::sincosf(angle);
        Self { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] }
    }

    /// This transform first, then `next`.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        let column = |j: usize| [self.rotation[0][j], self.rotation[1][j], self.rotation[2][j]];
        Self {
            rotation: next.rotation.map(|row| [dot(row, column(0)), dot(row, column(1)), dot(row, column(2))]),
            translation: next.apply(self.translation),
        }
    }

    /// Where the point `p` goes.
    #[must_use]
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        add(self.rotation.map(|row| dot(row, p)), self.translation)
    }
}

impl Mesh {
    /// A mesh without faces.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A mesh of plain triangles, such as read from an OFF or OBJ file, in one grey material. Triangles with an index
    /// out of range are left out, as are those of vertices that are not finite.
    #[must_use]
    pub fn from_triangles(vertices: Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Self {
        let usable = |&i: &u32| vertices.get(i as usize).is_some_and(|v| v.iter().all(|c| c.is_finite()));
        let triangles =
            triangles.iter().filter(|v| v.iter().all(usable)).map(|&v| Triangle { v, material: 0 }).collect();
        Self { vertices, triangles, materials: vec![Material::plain([170, 170, 170])] }
    }

    /// Adds a material (or finds an equal one) and returns its index.
    pub fn material(&mut self, material: Material) -> u16 {
        let index = self.materials.iter().position(|m| *m == material).unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        index as u16
    }

    /// Adds another mesh as it stands.
    pub fn append(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        let materials: Vec<u16> = other.materials.iter().map(|m| self.material(*m)).collect();
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| Triangle {
            v: t.v.map(|i| i + base),
            material: materials.get(usize::from(t.material)).copied().unwrap_or(0),
        }));
    }

    /// The box along the axes that holds every vertex a face uses; `None` for a mesh without faces.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        let mut corners = self.triangles.iter().flat_map(|t| t.v).map(|i| self.vertices[i as usize]);
        let first = corners.next()?;
        Some(corners.fold(Bounds { min: first, max: first }, |b, p| Bounds {
            min: [0, 1, 2].map(|k| b.min[k].min(p[k])),
            max: [0, 1, 2].map(|k| b.max[k].max(p[k])),
        }))
    }

    /// Moves the whole mesh.
    pub fn transform(&mut self, transform: &Transform) {
        self.transform_since(0, transform);
    }

    /// Moves the vertices from number `mark` on (a former `vertices.len()`): the parts added since.
    pub fn transform_since(&mut self, mark: usize, transform: &Transform) {
        for vertex in self.vertices.iter_mut().skip(mark) {
            *vertex = transform.apply(*vertex);
        }
    }

    /// Scales the whole mesh about the origin.
    pub fn scale(&mut self, factor: f32) {
        self.scale_since(0, [factor; 3]);
    }

    /// Scales the vertices from number `mark` on about the origin, each axis by its own factor.
    pub fn scale_since(&mut self, mark: usize, factors: [f32; 3]) {
        for vertex in self.vertices.iter_mut().skip(mark) {
            *vertex = [0, 1, 2].map(|k| vertex[k] * factors[k]);
        }
    }

    /// Scales the mesh so that the longest side of its bounding box measures `side` metres.
    pub fn scale_longest_side_to(&mut self, side: f32) {
        if let Some(bounds) = self.bounds() {
            let longest = bounds.size().into_iter().fold(0.0, f32::max);
            if longest > 0.0 {
                self.scale(side / longest);
            }
        }
    }

    /// Puts the mesh on the floor: the least z becomes 0, the middle of the bounding box comes to x = y = 0.
    pub fn stand_on_floor(&mut self) {
        if let Some(bounds) = self.bounds() {
            let centre = bounds.centre();
            for vertex in &mut self.vertices {
                *vertex = [vertex[0] - centre[0], vertex[1] - centre[1], vertex[2] - bounds.min[2]];
            }
        }
    }

    /// Turns a mesh whose y axis points up (as in most OBJ files) so that z does.
    pub fn y_up_to_z_up(&mut self) {
        for vertex in &mut self.vertices {
            *vertex = [vertex[0], -vertex[2], vertex[1]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standing_on_the_floor_centres_and_lowers() {
        let mut mesh = Mesh::from_triangles(
            vec![[1.0, 2.0, 3.0], [3.0, 2.0, 3.0], [1.0, 6.0, 7.0], [f32::NAN; 3]],
            &[[0, 1, 2], [0, 1, 3], [0, 1, 9]],
        );
        assert_eq!(mesh.triangles.len(), 1);
        mesh.scale_longest_side_to(2.0);
        mesh.stand_on_floor();
        let bounds = mesh.bounds().unwrap();
        assert_eq!((bounds.min, bounds.max), ([-0.5, -1.0, 0.0], [0.5, 1.0, 2.0]));
    }

    #[test]
    fn transforms_chain_in_reading_order() {
        let quarter = core::f32::consts::FRAC_PI_2;
        let t = Transform::rotate_z(quarter).then(Transform::translate([1.0, 0.0, 0.0]));
        let p = t.apply([1.0, 0.0, 0.0]);
        assert!((p[0] - 1.0).abs() < 1e-6 && (p[1] - 1.0).abs() < 1e-6);
        assert!((Transform::rotate_x(quarter).apply([0.0, 1.0, 0.0])[2] - 1.0).abs() < 1e-6);
        assert!((Transform::rotate_y(quarter).apply([0.0, 0.0, 1.0])[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn appended_meshes_share_equal_materials() {
        let red = Material::plain([200, 0, 0]);
        let mut a = Mesh::new();
        let grey = a.material(Material::plain([90, 90, 90]));
        a.add_box([0.0; 3], [1.0; 3], grey);
        let mut b = Mesh::new();
        let m = b.material(red);
        b.add_box([2.0; 3], [3.0; 3], m);
        a.append(&b);
        a.append(&b);
        assert_eq!(a.materials.len(), 2);
        assert_eq!(a.triangles.len(), 36);
        assert_eq!(a.triangles[35].material, 1);
        assert_eq!(a.bounds().unwrap().max, [3.0; 3]);
    }
}
