//! The truth of poses and views, in float64 and without matrices of homographies: rays, planes and where they meet.

use super::image::dot;
use pldi_core::Intrinsics;

/// A vector.
pub type Vector = [f64; 3];

/// a + t b.
fn along(a: Vector, t: f64, b: Vector) -> Vector {
    core::array::from_fn(|i| a[i] + t * b[i])
}

/// A camera above the floor: the directions of the floor's frame as the camera sees them.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// To the right along the floor.
    pub right: Vector,
    /// Forward along the floor.
    pub forward: Vector,
    /// Up.
    pub up: Vector,
    /// Metres above the floor.
    pub height: f64,
}

impl Pose {
    /// A level camera is first turned to look down, then clockwise about its own axis.
    pub fn new(height: f64, pitch: f64, roll: f64) -> Self {
        let turned = |p: Vector| {
            let (sin, cos) = libm::sincos(pitch);
            let p = [p[0], cos * p[1] - sin * p[2], sin * p[1] + cos * p[2]];
            let (sin, cos) = libm::sincos(roll);
            [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0], p[2]]
        };
        // In a level camera: x right, y down, z forward.
        let [right, up, forward] = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]].map(turned);
        Self { right, forward, up, height }
    }

    /// The camera above a floor that is given by its normal (made a unit vector) and the height.
    pub fn above(normal: Vector, height: f64) -> Self {
        let unit = |v: Vector| v.map(|c| c / dot(v, v).sqrt());
        let up = unit(normal);
        let forward = unit(along([0.0, 0.0, 1.0], -up[2], up));
        let right = [
            forward[1] * up[2] - forward[2] * up[1],
            forward[2] * up[0] - forward[0] * up[2],
            forward[0] * up[1] - forward[1] * up[0],
        ];
        Self { right, forward, up, height }
    }

    /// How far a metre along the principal axis goes along the floor.
    pub fn horizontal(&self) -> f64 {
        self.forward[2]
    }

    /// From the camera's frame to right, forward, height.
    pub fn to_floor(self, p: Vector) -> Vector {
        [dot(self.right, p), dot(self.forward, p), dot(self.up, p) + self.height]
    }

    /// From right, forward, height to the camera's frame.
    pub fn to_camera(self, q: Vector) -> Vector {
        along(along(along([0.0; 3], q[0], self.right), q[1], self.forward), q[2] - self.height, self.up)
    }
}

/// Where a point of the camera's frame is seen, in pixels.
pub fn project(k: &Intrinsics, p: Vector) -> [f64; 2] {
    [p[0] / p[2] * f64::from(k.fx) + f64::from(k.cx), p[1] / p[2] * f64::from(k.fy) + f64::from(k.cy)]
}

/// The plane pi_o of an object and the frontal camera before pi_f that looks at its middle.
#[derive(Debug, Clone, Copy)]
pub struct Frontal {
    pose: Pose,
    camera: Intrinsics,
    centroid: [f64; 2],
    /// Height of the point that the frontal camera looks at, in metres.
    pub middle: f64,
}

/// Distance of pi_f.
const AHEAD: f64 = 2.0;

impl Frontal {
    /// For an object whose points have their mean at this place on the floor.
    pub fn new(pose: Pose, camera: Intrinsics, centroid: [f64; 2], middle: f64) -> Self {
        Self { pose, camera, centroid, middle }
    }

    fn bearing(&self) -> [f64; 2] {
        let [x, y] = self.centroid;
        let length = (x * x + y * y).sqrt();
        [x / length, y / length]
    }

    /// From a point of pi_o (metres to the right of the centroid, metres above the floor) to pixels.
    pub fn plane_to_image(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.bearing();
        let q = [self.centroid[0] + s * y, self.centroid[1] - s * x, t];
        project(&self.camera, self.pose.to_camera(q))
    }

    /// From pixels to the point of pi_o on the pixel's ray.
    pub fn image_to_plane(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let k = &self.camera;
        let ray = [(u - f64::from(k.cx)) / f64::from(k.fx), (v - f64::from(k.cy)) / f64::from(k.fy), 1.0];
        let [right, forward, height] = self.pose.to_floor(ray);
        let [x, y] = self.bearing();
        let reach = (self.centroid[0] * x + self.centroid[1] * y) / (right * x + forward * y);
        [reach * (right * y - forward * x), self.pose.height + reach * (height - self.pose.height)]
    }

    /// The frontal camera's directions (right, forward, up): image right, image down, where it looks.
    fn frontal_axes(&self) -> [Vector; 3] {
        let drop = self.pose.height - self.middle;
        let length = (drop * drop + AHEAD * AHEAD).sqrt();
        let (sin, cos) = (drop / length, AHEAD / length);
        [[1.0, 0.0, 0.0], [0.0, -sin, -cos], [0.0, cos, -sin]]
    }

    /// From the frontal image plane at unit distance to a point of pi_f.
    pub fn view_to_plane(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [across, down, look] = self.frontal_axes();
        let ray = along(along(look, x, across), y, down);
        let reach = AHEAD / ray[1];
        [reach * ray[0], self.pose.height + reach * ray[2]]
    }

    /// From a point of pi_f to the frontal image plane at unit distance.
    pub fn plane_to_view(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let p = [s, AHEAD, t - self.pose.height];
        let [x, y, z] = self.frontal_axes().map(|axis| dot(axis, p));
        [x / z, y / z]
    }
}

/// An object's pixels seen frontally, in the square that fits them.
pub struct Fitted {
    /// The planes.
    pub frontal: Frontal,
    /// Centre of the square on the image plane at unit distance.
    pub centre: [f64; 2],
    /// Half of its side.
    pub half: f64,
}

impl Fitted {
    /// The square around the pixels' mean, half side a quarter beyond the farthest of them and a pixel more.
    pub fn new(pose: Pose, camera: Intrinsics, centroid: [f64; 2], pixels: &[(usize, usize)]) -> Self {
        let mean = |values: &[[f64; 2]]| [0, 1].map(|k| values.iter().map(|p| p[k]).sum::<f64>() / values.len() as f64);
        let level = Frontal::new(pose, camera, centroid, 0.0);
        let on_plane: Vec<_> = pixels.iter().map(|&(u, v)| level.image_to_plane([u as f64, v as f64])).collect();
        let frontal = Frontal::new(pose, camera, centroid, mean(&on_plane)[1]);
        let seen: Vec<_> = on_plane.iter().map(|p| frontal.plane_to_view(*p)).collect();
        let centre = mean(&seen);
        let farthest = seen.iter().flat_map(|p| [0, 1].map(|k| (p[k] - centre[k]).abs())).fold(0.0, f64::max);
        Self { frontal, centre, half: 1.25 * farthest + 1.0 / f64::from(camera.fx) }
    }

    /// The point of pi_o that is seen in the middle of a pixel of the 128x128 view.
    pub fn plane_point(&self, column: usize, row: usize) -> [f64; 2] {
        let at = |i: usize, k: usize| self.centre[k] + ((i as f64 + 0.5) / 64.0 - 1.0) * self.half;
        self.frontal.view_to_plane([at(column, 0), at(row, 1)])
    }

    /// The view, sampled between four pixels each; `n` is 0 beside the object.
    pub fn sample(&self, n: impl Fn(i64, i64) -> f64) -> Vec<f64> {
        let value = |i: usize| {
            let [u, v] = self.frontal.plane_to_image(self.plane_point(i % 128, i / 128));
            let (x, y) = (libm::floor(u), libm::floor(v));
            let weight = |dx: f64, dy: f64| (1.0 - (u - x - dx).abs()) * (1.0 - (v - y - dy).abs());
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
                .map(|(dx, dy)| weight(dx, dy) * n((x + dx) as i64, (y + dy) as i64))
                .iter()
                .sum()
        };
        (0..128 * 128).map(value).collect()
    }
}
