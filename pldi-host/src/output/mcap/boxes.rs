//! Boxes around candidates, as poses in the camera's optical frame.

use pldi_core::Floor;

use super::messages::Pose;

/// The box with its middle at `center` whose cluster's points have their mean at `centroid` on the floor (right and
/// forward): it stands upright on the floor and is turned to the line of sight.
///
/// Its axes are named as the optical frame's: x across the line of sight to the right, y down onto the floor, z along
/// the line of sight over the floor, away from the camera. The lengths along them are width, height and depth, in the
/// order in which sizes are reported; a level camera sees a box straight ahead with the identity as orientation.
pub(super) fn pose(floor: &Floor, centroid: [f32; 2], center: [f32; 3]) -> Pose {
    let axes = floor.axes();
    let [right, forward] = centroid.map(f64::from);
    let length = (right * right + forward * forward).sqrt();
    // Below the camera any direction will do.
    let [sin, cos] = if length > 1e-6 { [right / length, forward / length] } else { [0.0, 1.0] };
    let (r, f) = (axes.right.map(f64::from), axes.forward.map(f64::from));
    let x = std::array::from_fn(|i| cos * r[i] - sin * f[i]);
    let z = std::array::from_fn(|i| sin * r[i] + cos * f[i]);
    let y = floor.normal.map(|n| -f64::from(n));
    Pose { position: center, orientation: quaternion([x, y, z]) }
}

/// The unit quaternion (x, y, z, w; w not negative) of the rotation that takes the axes to these.
fn quaternion([a, b, c]: [[f64; 3]; 3]) -> [f64; 4] {
    // Four times the squares of the parts. Dividing by the largest is exact enough for every rotation.
    let squares =
        [1.0 + a[0] - b[1] - c[2], 1.0 - a[0] + b[1] - c[2], 1.0 - a[0] - b[1] + c[2], 1.0 + a[0] + b[1] + c[2]];
    let (xy, xz, yz) = (a[1] + b[0], a[2] + c[0], b[2] + c[1]);
    let (xw, yw, zw) = (b[2] - c[1], c[0] - a[2], a[1] - b[0]);
    let [x, y, z, w] = squares;
    let parts = if w >= x && w >= y && w >= z {
        [xw, yw, zw, w]
    } else if x >= y && x >= z {
        [x, xy, xz, xw]
    } else if y >= z {
        [xy, y, yz, yw]
    } else {
        [xz, yz, z, zw]
    };
    let length = parts.iter().map(|p| p * p).sum::<f64>().sqrt();
    let scale = if parts[3] < 0.0 { -1.0 } else { 1.0 } / length;
    parts.map(|p| p * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A vector, turned.
    fn turned([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let q = [x, y, z];
        let t = cross(q, v).map(|c| 2.0 * c);
        let u = cross(q, t);
        std::array::from_fn(|i| v[i] + w * t[i] + u[i])
    }

    #[test]
    fn a_level_camera_sees_a_box_ahead_as_it_is() {
        let floor = Floor::from_pose(1.0, 0.0, 0.0).unwrap();
        let pose = pose(&floor, [0.0, 2.0], [0.0, 0.5, 2.0]);
        assert_eq!(pose.orientation.map(|p| (p * 1e6).round()), [0.0, 0.0, 0.0, 1e6]);
    }

    proptest! {
        #[test]
        fn the_box_stands_on_the_floor_and_faces_the_camera(
            pitch in -1.5f32..1.5, roll in -1.5f32..1.5, right in -3.0f32..3.0, forward in -3.0f32..3.0,
        ) {
            prop_assume!(right.abs() + forward.abs() > 0.01);
            let floor = Floor::from_pose(1.3, pitch, roll).unwrap();
            let axes = floor.axes();
            let pose = pose(&floor, [right, forward], [0.0; 3]);
            let q = pose.orientation;
            prop_assert!((q.iter().map(|p| p * p).sum::<f64>() - 1.0).abs() < 1e-9 && q[3] >= 0.0);
            let along = axes.to_camera([right, forward, floor.height]);
            let length = f64::from(libm::hypotf(right, forward));
            let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|v| turned(q, v));
            for i in 0..3 {
                prop_assert!((y[i] + f64::from(floor.normal[i])).abs() < 1e-5);
                prop_assert!((z[i] - f64::from(along[i]) / length).abs() < 1e-4);
            }
            // To the right of who looks along.
            let across = axes.to_camera([forward, -right, floor.height]);
            prop_assert!(x.iter().zip(across).all(|(x, a)| (x - f64::from(a) / length).abs() < 1e-4));
        }
    }
}
