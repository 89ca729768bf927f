//! The z-buffer: which surface each pixel sees.

use pldi_core::Intrinsics;

use super::camera::CameraPose;
use crate::mesh::{Mesh, Transform};
use crate::vec3::{cross, dot, scale, sub};

/// Nearest distance that is drawn, in metres: triangles are cut off there.
const NEAR: f64 = 0.05;

/// No surface.
pub(super) const NOTHING: u32 = u32::MAX;

/// The plane of a drawn triangle as the camera sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// 1/z at pixel (u, v) is `inverse[0] * u + inverse[1] * v + inverse[2]`, in 1/m.
    inverse: [f64; 3],
    /// Unit normal in the camera's frame, towards the camera.
    pub(super) normal: [f32; 3],
    /// 0 for the room, i + 1 for the scene's instance i.
    pub(super) label: u8,
    /// The triangle's number in its mesh.
    pub(super) triangle: u32,
}

impl Facet {
    /// 1/z of the facet's plane at a pixel, in 1/m.
    pub(super) fn inverse_z(&self, u: f64, v: f64) -> f64 {
        self.inverse[0] * u + self.inverse[1] * v + self.inverse[2]
    }
}

/// A pinhole camera in double precision, free of the limits of an image's size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pinhole {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) fx: f64,
    pub(super) fy: f64,
    pub(super) cx: f64,
    pub(super) cy: f64,
}

impl From<Intrinsics> for Pinhole {
    fn from(k: Intrinsics) -> Self {
        Self {
            width: usize::from(k.width),
            height: usize::from(k.height),
            fx: f64::from(k.fx),
            fy: f64::from(k.fy),
            cx: f64::from(k.cx),
            cy: f64::from(k.cy),
        }
    }
}

/// A z-buffer with the facets drawn so far.
#[derive(Debug)]
pub(super) struct Raster {
    pub(super) pinhole: Pinhole,
    /// 1/z of the nearest surface at each pixel, 0 where there is none, in 1/m.
    pub(super) inverse_z: Vec<f64>,
    /// Number of the facet at each pixel, or [`NOTHING`].
    pub(super) facet: Vec<u32>,
    pub(super) facets: Vec<Facet>,
}

impl Raster {
    pub(super) fn new(pinhole: Pinhole) -> Self {
        let n = pinhole.width * pinhole.height;
        Self { pinhole, inverse_z: vec![0.0; n], facet: vec![NOTHING; n], facets: Vec::new() }
    }

    /// Draws a mesh that stands in the world as `place` says; `shift` moves the camera to its right, in metres.
    pub(super) fn draw(&mut self, mesh: &Mesh, place: &Transform, camera: &CameraPose, shift: f64, label: u8) {
        let (axes, origin) = (camera.axes(), camera.position().map(f64::from));
        let seen: Vec<[f64; 3]> = mesh
            .vertices
            .iter()
            .map(|&p| {
                let q = sub(place.apply(p).map(f64::from), origin);
                [dot(axes[0], q) - shift, dot(axes[1], q), dot(axes[2], q)]
            })
            .collect();
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            self.triangle(triangle.v.map(|k| seen[k as usize]), label, i as u32);
        }
    }

    /// Draws one triangle of the camera's frame.
    fn triangle(&mut self, [a, b, c]: [[f64; 3]; 3], label: u8, triangle: u32) {
        if a[2] < NEAR && b[2] < NEAR && c[2] < NEAR {
            return;
        }
        let k = self.pinhole;
        let normal = cross(sub(b, a), sub(c, a));
        let norm = dot(normal, normal).sqrt();
        if norm < 1e-14 {
            return;
        }
        let normal = scale(normal, 1.0 / norm);
        let distance = dot(normal, a);
        if distance.abs() < 1e-7 {
            return; // Seen exactly edge on.
        }
        let inverse = [normal[0] / (k.fx * distance), normal[1] / (k.fy * distance)];
        let constant = normal[2] / distance - inverse[0] * k.cx - inverse[1] * k.cy;
        let towards = if distance < 0.0 { normal } else { scale(normal, -1.0) };
        let facet =
            Facet { inverse: [inverse[0], inverse[1], constant], normal: towards.map(|x| x as f32), label, triangle };

        // Cut off what lies behind the near plane, project the rest.
        let mut corners = [[0.0f64; 2]; 4];
        let mut n = 0;
        let (mut least, mut greatest) = (f64::INFINITY, 0.0f64);
        let mut push = |p: [f64; 3]| {
            let w = 1.0 / p[2];
            corners[n] = [p[0] * w * k.fx + k.cx, p[1] * w * k.fy + k.cy];
            least = least.min(w);
            greatest = greatest.max(w);
            n += 1;
        };
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if p[2] >= NEAR {
                push(p);
            }
            if (p[2] >= NEAR) != (q[2] >= NEAR) {
                let t = (NEAR - p[2]) / (q[2] - p[2]);
                push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), NEAR]);
            }
        }
        if self.polygon(&corners[..n], &facet, [least, greatest]) {
            self.facets.push(facet);
        }
    }

    /// Fills a convex polygon of the image; whether any pixel was won.
    fn polygon(&mut self, corners: &[[f64; 2]], facet: &Facet, [least, greatest]: [f64; 2]) -> bool {
        let (width, height) = (self.pinhole.width, self.pinhole.height);
        let top = corners.iter().fold(f64::INFINITY, |m, p| m.min(p[1]));
        let bottom = corners.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[1]));
        let first = top.ceil().max(0.0);
        let last = bottom.floor().min(height as f64 - 1.0);
        if first > last {
            return false;
        }
        let number = self.facets.len() as u32;
        let mut won = false;
        for row in first as usize..=last as usize {
            let v = row as f64;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..corners.len() {
                let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
                // Always from the upper end, so that neighbours that share an edge find the same column.
                let (p, q) = if p[1] <= q[1] { (p, q) } else { (q, p) };
                if p[1] <= v && v <= q[1] && p[1] < q[1] {
                    let u = p[0] + (v - p[1]) * ((q[0] - p[0]) / (q[1] - p[1]));
                    left = left.min(u);
                    right = right.max(u);
                }
            }
            let from = left.ceil().max(0.0);
            let to = right.floor().min(width as f64 - 1.0);
            if from > to || !left.is_finite() {
                continue;
            }
            for column in from as usize..=to as usize {
                // Rounding must not carry the depth beyond the triangle's own.
                let w = facet.inverse_z(column as f64, v).clamp(least, greatest);
                let pixel = row * width + column;
                if w > self.inverse_z[pixel] {
                    self.inverse_z[pixel] = w;
                    self.facet[pixel] = number;
                    won = true;
                }
            }
        }
        won
    }
}
