//! The solids furniture is made of. Each method adds one closed solid (or, where said, a surface) to the mesh;
//! lengths are in metres, angles in rad.

use core::f32::consts::{PI, TAU};

use super::{Mesh, Triangle};
use crate::vec3::{add, cross, frame, scale, sub, unit};

impl Mesh {
    /// Adds one vertex and returns its index.
    fn vertex(&mut self, p: [f32; 3]) -> u32 {
        self.vertices.push(p);
        self.vertices.len() as u32 - 1
    }

    /// Adds a triangle between existing vertices.
    fn face(&mut self, v: [u32; 3], material: u16) {
        self.triangles.push(Triangle { v, material });
    }

    /// Adds a quadrilateral between existing vertices, in turn.
    fn quad(&mut self, [a, b, c, d]: [u32; 4], material: u16) {
        self.face([a, b, c], material);
        self.face([a, c, d], material);
    }

    /// Joins two rings of equally many vertices by a belt of quadrilaterals.
    fn belt(&mut self, lower: u32, upper: u32, n: u32, material: u16) {
        for i in 0..n {
            let j = (i + 1) % n;
            self.quad([lower + i, lower + j, upper + j, upper + i], material);
        }
    }

    /// Closes a ring of `n` vertices from number `first` on by a fan about `centre`.
    fn cap(&mut self, first: u32, n: u32, centre: [f32; 3], material: u16) {
        let middle = self.vertex(centre);
        for i in 0..n {
            self.face([first + i, first + (i + 1) % n, middle], material);
        }
    }

    /// A box along the axes between two corners.
    pub fn add_box(&mut self, min: [f32; 3], max: [f32; 3], material: u16) {
        let pick = |k: usize, high: bool| if high { max[k] } else { min[k] };
        let corners = [0, 1, 2, 3, 4, 5, 6, 7]
            .map(|i: u32| self.vertex([pick(0, i & 1 != 0), pick(1, i & 2 != 0), pick(2, i & 4 != 0)]));
        for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.quad(side.map(|i: usize| corners[i]), material);
        }
    }

    /// A box of this size whose base is centred on `base`.
    pub fn add_block(&mut self, base: [f32; 3], size: [f32; 3], material: u16) {
        let half = [0.5 * size[0], 0.5 * size[1]];
        self.add_box(
            [base[0] - half[0], base[1] - half[1], base[2]],
            [base[0] + half[0], base[1] + half[1], base[2] + size[2]],
            material,
        );
    }

    /// A leg of rectangular section, upright or slanted: centre and x, y extent at either end.
    pub fn add_leg(&mut self, from: [f32; 3], from_size: [f32; 2], to: [f32; 3], to_size: [f32; 2], material: u16) {
        let mut ring = |c: [f32; 3], s: [f32; 2]| {
            let corner = |x: f32, y: f32| [c[0] + 0.5 * x * s[0], c[1] + 0.5 * y * s[1], c[2]];
            let first = self.vertex(corner(-1.0, -1.0));
            self.vertex(corner(1.0, -1.0));
            self.vertex(corner(1.0, 1.0));
            self.vertex(corner(-1.0, 1.0));
            first
        };
        let (a, b) = (ring(from, from_size), ring(to, to_size));
        self.belt(a, b, 4, material);
        self.quad([a, a + 1, a + 2, a + 3], material);
        self.quad([b, b + 1, b + 2, b + 3], material);
    }

    /// A cone frustum between two centres with their radii; a cylinder where they are equal.
    pub fn add_frustum(&mut self, from: [f32; 3], r0: f32, to: [f32; 3], r1: f32, sides: u32, material: u16) {
        let axis = unit(sub(to, from)).unwrap_or([0.0, 0.0, 1.0]);
        let a = self.circle(from, r0, axis, sides);
        let b = self.circle(to, r1, axis, sides);
        self.belt(a, b, sides, material);
        self.cap(a, sides, from, material);
        self.cap(b, sides, to, material);
    }

    /// A cylinder between two centres.
    pub fn add_cylinder(&mut self, from: [f32; 3], to: [f32; 3], radius: f32, sides: u32, material: u16) {
        self.add_frustum(from, radius, to, radius, sides, material);
    }

    /// A ring of vertices about `centre`, in the plane across the unit vector `axis`; returns the first one's index.
    fn circle(&mut self, centre: [f32; 3], radius: f32, axis: [f32; 3], sides: u32) -> u32 {
        let (e1, e2) = frame(axis);
        let first = self.vertices.len() as u32;
        for i in 0..sides {
            // Half a step aside: the sides of a square section come to lie along the axes' directions.
            let (s, c) = libm::sincosf((i as f32 + 0.5) * TAU / sides as f32);
            self.vertex(add(centre, add(scale(e1, radius * c), scale(e2, radius * s))));
        }
        first
    }

    /// A surface of revolution about the upright axis through `base`: `profile` lists radius and height above `base`.
    /// Closed where the profile starts and ends on the axis (radius 0) or where it runs into itself.
    pub fn add_lathe(&mut self, base: [f32; 3], profile: &[[f32; 2]], sides: u32, material: u16) {
        let mut before: Option<(u32, f32)> = None;
        for &[radius, height] in profile {
            let centre = add(base, [0.0, 0.0, height]);
            let ring = self.circle(centre, radius, [0.0, 0.0, 1.0], sides);
            if let Some((lower, r)) = before {
                // On the axis half of each quadrilateral has no area.
                for i in 0..sides {
                    let j = (i + 1) % sides;
                    if r > 0.0 {
                        self.face([lower + i, lower + j, ring + j], material);
                    }
                    if radius > 0.0 {
                        self.face([lower + i, ring + j, ring + i], material);
                    }
                }
            }
            before = Some((ring, radius));
        }
    }

    /// An ellipsoid.
    pub fn add_ellipsoid(&mut self, centre: [f32; 3], radii: [f32; 3], sides: u32, material: u16) {
        self.add_rounded(centre, radii, 1.0, sides, material);
    }

    /// A cushion: a box between two corners with rounded edges and slightly swollen faces. `roundness` from about 0.15
    /// (a firm seat) to 1 (an ellipsoid).
    pub fn add_cushion(&mut self, min: [f32; 3], max: [f32; 3], roundness: f32, material: u16) {
        let centre = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
        let radii = [0, 1, 2].map(|k| 0.5 * (max[k] - min[k]));
        self.add_rounded(centre, radii, roundness, 20, material);
    }

    /// A superellipsoid |x/a|^(2/e) + |y/b|^(2/e) + |z/c|^(2/e) = 1, e = `exponent`.
    fn add_rounded(&mut self, centre: [f32; 3], radii: [f32; 3], exponent: f32, sides: u32, material: u16) {
        let power = |x: f32| libm::copysignf(libm::powf(x.abs(), exponent), x);
        let rings = (sides / 2).max(3);
        let first = self.vertices.len() as u32;
        for r in 1..rings {
            let (sin_lat, cos_lat) = libm::sincosf(PI * (r as f32 / rings as f32 - 0.5));
            for i in 0..sides {
                let (s, c) = libm::sincosf((i as f32 + 0.5) * TAU / sides as f32);
                let p = [power(c) * power(cos_lat), power(s) * power(cos_lat), power(sin_lat)];
                self.vertex([0, 1, 2].map(|k| centre[k] + radii[k] * p[k]));
            }
        }
        for r in 0..rings - 2 {
            self.belt(first + r * sides, first + (r + 1) * sides, sides, material);
        }
        self.cap(first, sides, add(centre, [0.0, 0.0, -radii[2]]), material);
        self.cap(first + (rings - 2) * sides, sides, add(centre, [0.0, 0.0, radii[2]]), material);
    }

    /// An upright prism over a polygon in the x-y plane, from height `z0` to `z1`. The polygon must be seen whole from
    /// the mean of its corners.
    pub fn add_prism(&mut self, polygon: &[[f32; 2]], z0: f32, z1: f32, material: u16) {
        let n = polygon.len() as u32;
        if n < 3 {
            return;
        }
        let mut middle = [0.0f32; 2];
        for corner in polygon {
            middle = [middle[0] + corner[0] / n as f32, middle[1] + corner[1] / n as f32];
        }
        let mut ring = |z: f32| {
            let first = self.vertices.len() as u32;
            for corner in polygon {
                self.vertex([corner[0], corner[1], z]);
            }
            first
        };
        let (a, b) = (ring(z0), ring(z1));
        self.belt(a, b, n, material);
        self.cap(a, n, [middle[0], middle[1], z0], material);
        self.cap(b, n, [middle[0], middle[1], z1], material);
    }

    /// A tube along a line of points, closed at both ends; `sides` of 4 gives a square bar.
    pub fn add_tube(&mut self, points: &[[f32; 3]], radius: f32, sides: u32, material: u16) {
        let mut before: Option<u32> = None;
        let mut e1 = None;
        for (i, &p) in points.iter().enumerate() {
            let ahead = points[(i + 1).min(points.len() - 1)];
            let behind = points[i.saturating_sub(1)];
            let axis = unit(sub(ahead, behind)).unwrap_or([0.0, 0.0, 1.0]);
            // The frame is carried along, else the tube would twist where the reference axis changes.
            let first = e1
                .and_then(|e: [f32; 3]| unit(sub(e, scale(axis, crate::vec3::dot(e, axis)))))
                .unwrap_or_else(|| frame(axis).0);
            e1 = Some(first);
            let second = cross(axis, first);
            let ring = self.vertices.len() as u32;
            for k in 0..sides {
                let (s, c) = libm::sincosf((k as f32 + 0.5) * TAU / sides as f32);
                self.vertex(add(p, add(scale(first, radius * c), scale(second, radius * s))));
            }
            match before {
                Some(lower) => self.belt(lower, ring, sides, material),
                None => self.cap(ring, sides, p, material),
            }
            if i + 1 == points.len() {
                self.cap(ring, sides, p, material);
            }
            before = Some(ring);
        }
    }

    /// A surface: a ribbon along a line of points, of the given half widths, spread along `across`.
    pub fn add_ribbon(&mut self, points: &[[f32; 3]], half_widths: &[f32], across: [f32; 3], material: u16) {
        let mut before: Option<u32> = None;
        for (&p, &w) in points.iter().zip(half_widths) {
            let left = self.vertex(sub(p, scale(across, w)));
            self.vertex(add(p, scale(across, w)));
            if let Some(b) = before {
                self.quad([b, b + 1, left + 1, left], material);
            }
            before = Some(left);
        }
    }

    /// A surface: a flat quadrilateral through four points, in turn.
    pub fn add_quad(&mut self, corners: [[f32; 3]; 4], material: u16) {
        let v = corners.map(|p| self.vertex(p));
        self.quad(v, material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether each edge belongs to exactly two triangles, with vertices told apart by position.
    fn closed(mesh: &Mesh) -> bool {
        let key = |i: u32| mesh.vertices[i as usize].map(|c| (c * 1e5).round() as i32);
        let mut edges = std::collections::BTreeMap::new();
        for t in &mesh.triangles {
            let k = t.v.map(key);
            if k[0] == k[1] || k[1] == k[2] || k[2] == k[0] {
                continue;
            }
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                *edges.entry((k[a].min(k[b]), k[a].max(k[b]))).or_insert(0) += 1;
            }
        }
        edges.values().all(|&n| n == 2)
    }

    #[test]
    fn solids_are_closed_and_as_large_as_asked() {
        type Build = fn(&mut Mesh);
        let cases: [(&str, Build, [f32; 3]); 8] = [
            ("box", |m| m.add_box([-1.0, -2.0, 0.0], [1.0, 2.0, 3.0], 0), [2.0, 4.0, 3.0]),
            ("leg", |m| m.add_leg([0.0; 3], [0.1, 0.2], [0.0, 0.0, 1.0], [0.2, 0.1], 0), [0.2, 0.2, 1.0]),
            ("cylinder", |m| m.add_cylinder([0.0; 3], [0.0, 0.0, 2.0], 0.5, 64, 0), [1.0, 1.0, 2.0]),
            ("ellipsoid", |m| m.add_ellipsoid([0.0; 3], [1.0, 0.5, 0.25], 64, 0), [2.0, 1.0, 0.5]),
            ("cushion", |m| m.add_cushion([0.0; 3], [1.0, 0.5, 0.25], 0.25, 0), [1.0, 0.5, 0.25]),
            ("prism", |m| m.add_prism(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.0, 1.0, 0), [1.0, 1.0, 1.0]),
            ("tube", |m| m.add_tube(&[[0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 1.5]], 0.1, 8, 0), [0.2, 1.1, 1.6]),
            (
                "lathe",
                |m| m.add_lathe([0.0; 3], &[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.4, 1.0], [0.0, 0.1]], 64, 0),
                [1.0, 1.0, 1.0],
            ),
        ];
        for (name, build, expected) in cases {
            let mut mesh = Mesh::new();
            mesh.material(crate::Material::plain([128; 3]));
            build(&mut mesh);
            assert!(closed(&mesh), "{name} has a hole");
            let size = mesh.bounds().unwrap().size();
            for k in 0..3 {
                assert!((size[k] - expected[k]).abs() < 0.06, "{name}: {size:?}, not {expected:?}");
            }
        }
    }
}
