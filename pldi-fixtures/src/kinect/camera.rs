//! Where the camera is and where it looks.

use crate::vec3::{add, cross, dot, scale, sub};

/// Pose of the camera in the world (x, y on the floor, z up).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Position along the world's x axis in metres.
    pub x: f32,
    /// Position along the world's y axis in metres.
    pub y: f32,
    /// Heading in rad: 0 looks along +x, pi/2 along +y.
    pub yaw: f32,
    /// Height above the floor in metres.
    pub height: f32,
    /// Tilt in rad, positive looks down.
    pub pitch: f32,
    /// Rotation about the viewing direction in rad, positive lowers the camera's right side.
    pub roll: f32,
}

impl CameraPose {
    /// A level-headed camera (no roll).
    #[must_use]
    pub const fn new(x: f32, y: f32, yaw: f32, height: f32, pitch: f32) -> Self {
        Self { x, y, yaw, height, pitch, roll: 0.0 }
    }

    /// The camera's axes (right, down, forward) in the world.
    pub(crate) fn axes(&self) -> [[f64; 3]; 3] {
        let (sy, cy) = libm::sincos(f64::from(self.yaw));
        let (sp, cp) = libm::sincos(f64::from(self.pitch));
        let (sr, cr) = libm::sincos(f64::from(self.roll));
        let forward = [cy * cp, sy * cp, -sp];
        let level = [sy, -cy, 0.0];
        let below = cross(forward, level);
        [add(scale(level, cr), scale(below, sr)), sub(scale(below, cr), scale(level, sr)), forward]
    }

    /// The camera's position in the world, in metres.
    #[must_use]
    pub fn position(&self) -> [f32; 3] {
        [self.x, self.y, self.height]
    }

    /// A point of the world in the camera's frame (both in metres).
    #[must_use]
    pub fn to_camera(&self, world: [f32; 3]) -> [f32; 3] {
        let p = sub(world, self.position()).map(f64::from);
        self.axes().map(|axis| dot(axis, p) as f32)
    }

    /// A point of the camera's frame in the world (both in metres).
    #[must_use]
    pub fn to_world(&self, camera: [f32; 3]) -> [f32; 3] {
        let [right, down, forward] = self.axes();
        let p = camera.map(f64::from);
        let offset = add(add(scale(right, p[0]), scale(down, p[1])), scale(forward, p[2]));
        add(offset.map(|c| c as f32), self.position())
    }

    /// The floor in the camera's frame: the upward unit normal n and the camera's height h above it, so that points p of
    /// the floor satisfy n . p + h = 0.
    #[must_use]
    pub fn floor(&self) -> ([f32; 3], f32) {
        (self.axes().map(|axis| axis[2] as f32), self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_point_where_the_angles_say() {
        let camera = CameraPose::new(1.0, 2.0, 0.0, 1.2, 0.3);
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
        assert!(near(CameraPose { pitch: 0.0, ..camera }.to_camera([4.0, 1.5, 1.0]), [0.5, 0.2, 3.0]));
        let quarter = core::f32::consts::FRAC_PI_2;
        assert!(near(CameraPose { yaw: quarter, pitch: 0.0, ..camera }.to_camera([1.5, 4.0, 1.2]), [0.5, 0.0, 2.0]));
        // Rolled to the right, what lay to the right rises.
        assert!(CameraPose { roll: 0.1, pitch: 0.0, ..camera }.to_camera([4.0, 1.0, 1.2])[1] < 0.0);
        let camera = CameraPose { roll: 0.2, yaw: 2.0, ..camera };
        assert!(near(camera.to_world(camera.to_camera([3.0, -1.0, 0.4])), [3.0, -1.0, 0.4]));
        let (n, h) = camera.floor();
        let p = camera.to_camera([5.0, -3.0, 0.0]);
        assert!((dot(n, p) + h).abs() < 1e-5);
    }
}
