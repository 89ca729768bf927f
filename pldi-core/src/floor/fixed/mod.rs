//! The floor in fixed point.

use crate::fixed::{ONE_Q30, mul_q30, unit};

/// The floor in the camera frame: points p with normal . p + height = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Floor {
    /// Unit normal in Q30, pointing up (towards the camera).
    pub normal: [i32; 3],
    /// Height of the camera above the floor in 1/128 mm, positive.
    pub height: i32,
}

impl Floor {
    /// The frame on the floor below the camera.
    pub fn axes(&self) -> FloorAxes {
        let n = self.normal.map(i64::from);
        let one = i64::from(ONE_Q30);
        let square = one - ((n[2] * n[2]) >> 30);
        let forward = if square < one / 1_000_000 {
            [0, -ONE_Q30, 0]
        } else {
            unit([-((n[2] * n[0]) >> 30), -((n[2] * n[1]) >> 30), square]).unwrap_or([0, -ONE_Q30, 0])
        };
        let cross = |a: usize, b: usize| mul_q30(forward[a], self.normal[b]) - mul_q30(forward[b], self.normal[a]);
        FloorAxes { right: [cross(1, 2), cross(2, 0), cross(0, 1)], forward, floor: *self }
    }
}

/// Floor coordinates: x to the right, y forward (the principal direction along the floor), origin below the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FloorAxes {
    /// Unit vector to the right along the floor, in the camera frame, Q30.
    pub right: [i32; 3],
    /// Unit vector forward along the floor, in the camera frame, Q30.
    pub forward: [i32; 3],
    /// The plane.
    pub floor: Floor,
}

impl FloorAxes {
    /// Right, forward and height of a point of the camera frame, in 1/128 mm.
    pub fn to_floor(&self, p: [i32; 3]) -> [i32; 3] {
        let dot = |a: [i32; 3]| mul_q30(a[0], p[0]) + mul_q30(a[1], p[1]) + mul_q30(a[2], p[2]);
        [dot(self.right), dot(self.forward), dot(self.floor.normal) + self.floor.height]
    }

    /// The point of the camera frame with these floor coordinates, in 1/128 mm.
    pub fn to_camera(&self, q: [i32; 3]) -> [i32; 3] {
        let up = q[2] - self.floor.height;
        core::array::from_fn(|i| {
            mul_q30(q[0], self.right[i]) + mul_q30(q[1], self.forward[i]) + mul_q30(up, self.floor.normal[i])
        })
    }
}
