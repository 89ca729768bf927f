//! The planes pi_o and pi_f, and the homography between them that shows an object frontally (paper, section 4, Fig. 4).
//!
//! pi_o is the vertical plane through the object's centroid that faces the camera. Its points have coordinates
//! (s, t): metres to the right of the centroid and metres above the floor. The plane pi_f stands in the same way
//! straight ahead of the camera at [`FRONTAL_DISTANCE`]. The homography from pi_o to pi_f keeps (s, t): it turns the
//! object in front of the camera and takes its distance away. The view is then what a camera at the sensor's own height
//! sees of pi_f when it looks at the object's middle: so the view does not depend on the sensor's pitch either.

use crate::array::transposed;
use crate::{FloorAxes, Intrinsics, math};

/// Distance of pi_f from the camera along the floor, in metres: that of the templates' ring (paper, section 6.1), and about
/// the centre of the sensory area.
pub const FRONTAL_DISTANCE: f32 = 2.0;

/// A 3x3 matrix, row by row, that acts on homogeneous coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Homography(pub [[f32; 3]; 3]);

impl Homography {
    /// From the coordinates (s, t) of the vertical plane through the floor point `centroid` (right, forward in metres),
    /// facing the camera, to pixels. `None` for a centroid below the camera.
    pub fn plane_to_image(axes: &FloorAxes, intrinsics: &Intrinsics, centroid: [f32; 2]) -> Option<Self> {
        let [x, y] = centroid;
        let length = math::sqrt(x * x + y * y);
        // Written so that NaN fails the test.
        if !(length > 1e-3) {
            return None;
        }
        let (sin, cos) = (x / length, y / length);
        let foot = axes.to_camera([x, y, 0.0]);
        let rows = transposed([axes.right, axes.forward, axes.floor.normal]);
        let columns = [rows.map(|[right, forward, _]| cos * right - sin * forward), axes.floor.normal, foot];
        let (fx, fy, cx, cy) = (intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy);
        Some(Self([
            columns.map(|[x, _, z]| fx * x + cx * z),
            columns.map(|[_, y, z]| fy * y + cy * z),
            columns.map(|[_, _, z]| z),
        ]))
    }

    /// From a frontal view to the coordinates (s, t): the camera stands `height` metres above the floor and
    /// [`FRONTAL_DISTANCE`] before pi_f, and looks at the point (0, `middle`). View coordinates are those of the image
    /// plane at unit distance: x to the right, y down, (0, 0) where the camera looks.
    pub fn view_to_plane(height: f32, middle: f32) -> Self {
        let drop = height - middle;
        let length = math::sqrt(drop * drop + FRONTAL_DISTANCE * FRONTAL_DISTANCE);
        let (sin, cos) = (drop / length, FRONTAL_DISTANCE / length);
        // The ray (x, y, 1) goes x to the right, y cos + sin down and cos - y sin forward.
        let d = FRONTAL_DISTANCE;
        Self([[d, 0.0, 0.0], [0.0, -height * sin - d * cos, height * cos - d * sin], [0.0, -sin, cos]])
    }

    /// This map after another: `self.after(g)` takes x to self(g(x)).
    pub fn after(&self, first: &Self) -> Self {
        let columns = transposed(first.0);
        Self(self.0.map(|row| columns.map(|column| row[0] * column[0] + row[1] * column[1] + row[2] * column[2])))
    }

    /// The image of a point; `None` behind the camera or at infinity.
    #[inline(always)]
    pub fn apply(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let [u, v, w] = self.0.map(|r| r[0] * x + r[1] * y + r[2]);
        (w > 1e-9).then(|| {
            let s = 1.0 / w;
            [u * s, v * s]
        })
    }

    /// The inverse map, scaled so that points seen by the camera keep a positive third coordinate; `None` where there
    /// is none.
    pub fn inverse(&self) -> Option<Self> {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.0;
        let adjugate = [
            [e * i - f * h, c * h - b * i, b * f - c * e],
            [f * g - d * i, a * i - c * g, c * d - a * f],
            [d * h - e * g, b * g - a * h, a * e - b * d],
        ];
        let determinant = a * adjugate[0][0] + b * adjugate[1][0] + c * adjugate[2][0];
        if !(determinant.abs() > 1e-9) {
            return None;
        }
        Some(Self(adjugate.map(|row| row.map(|v| v / determinant))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Floor;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn plane_points_project_like_points_in_space(
            pitch in 0.0f32..0.9, roll in -0.2f32..0.2, right in -1.5f32..1.5, forward in 1.0f32..4.0,
            s in -0.8f32..0.8, t in 0.0f32..1.5,
        ) {
            let axes = Floor::from_pose(1.2, pitch, roll).unwrap().axes();
            let camera = Intrinsics::KINECT_QVGA;
            let h = Homography::plane_to_image(&axes, &camera, [right, forward]).unwrap();
            let d = (right * right + forward * forward).sqrt();
            let p = axes.to_camera([right + s * forward / d, forward - s * right / d, t]);
            if let (Some(a), Some(b)) = (h.apply(s, t), camera.project(p)) && p[2] > 0.2 {
                prop_assert!((a[0] - b[0]).abs() < 0.02 && (a[1] - b[1]).abs() < 0.02, "{a:?} {b:?}");
                let back = h.inverse().unwrap().apply(a[0], a[1]).unwrap();
                prop_assert!((back[0] - s).abs() < 1e-3 && (back[1] - t).abs() < 1e-3, "{back:?}");
            }
        }
    }

    #[test]
    fn the_view_looks_at_the_middle_of_pi_f() {
        let h = Homography::view_to_plane(1.2, 0.5);
        let [s, t] = h.apply(0.0, 0.0).unwrap();
        assert!(s.abs() < 1e-6 && (t - 0.5).abs() < 1e-6);
        // A level camera sees a metre on pi_f under 1 / 2.
        let level = Homography::view_to_plane(1.2, 1.2).inverse().unwrap();
        let [x, y] = level.apply(1.0, 2.2).unwrap();
        assert!((x - 1.0 / 2.0).abs() < 1e-6 && (y + 1.0 / 2.0).abs() < 1e-6);
        let both = h.after(&level).apply(1.0, 2.2).unwrap();
        let one = h.apply(x, y).unwrap();
        assert!((both[0] - one[0]).abs() < 1e-5 && (both[1] - one[1]).abs() < 1e-5);
    }

    #[test]
    fn a_point_below_the_camera_has_no_plane() {
        let axes = Floor::from_pose(1.2, 0.3, 0.0).unwrap().axes();
        assert_eq!(Homography::plane_to_image(&axes, &Intrinsics::KINECT_QVGA, [0.0, 0.0]), None);
        assert_eq!(Homography::plane_to_image(&axes, &Intrinsics::KINECT_QVGA, [f32::NAN, 1.0]), None);
    }
}
