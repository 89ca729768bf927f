//! What the camera looks at: objects on a floor, perhaps between walls, under a light.

use std::sync::Arc;

use crate::mesh::{Material, Mesh, Texture, Transform};

/// Where an object stands: on the floor, turned about the upright axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Position along the world's x axis in metres.
    pub x: f32,
    /// Position along the world's y axis in metres.
    pub y: f32,
    /// Turn in rad, counter-clockwise seen from above.
    pub yaw: f32,
}

impl Pose {
    /// From the object's frame to the world.
    #[must_use]
    pub fn transform(&self) -> Transform {
        Transform::rotate_z(self.yaw).then(Transform::translate([self.x, self.y, 0.0]))
    }
}

/// One object in a scene.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The object's shape, standing on z = 0.
    pub mesh: Arc<Mesh>,
    /// Where it stands.
    pub pose: Pose,
}

/// Floor and walls: a rectangle along the world's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// Least x and y in metres.
    pub min: [f32; 2],
    /// Greatest x and y in metres.
    pub max: [f32; 2],
    /// Height of the walls in metres.
    pub wall_height: f32,
    /// The floor's look.
    pub floor: Material,
    /// The looks of the walls at least x, greatest x, least y, greatest y; `None` leaves that side open.
    pub walls: [Option<Material>; 4],
}

impl Room {
    /// A floor of `side` metres around the origin, without walls.
    #[must_use]
    pub const fn floor_only(side: f32, floor: Material) -> Self {
        let half = 0.5 * side;
        Self { min: [-half; 2], max: [half; 2], wall_height: 0.0, floor, walls: [None; 4] }
    }

    /// The room's surfaces, with a skirting board along each wall.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::new();
        let ([x0, y0], [x1, y1]) = (self.min, self.max);
        let floor = mesh.material(self.floor);
        mesh.add_quad([[x0, y0, 0.0], [x1, y0, 0.0], [x1, y1, 0.0], [x0, y1, 0.0]], floor);
        let board = Material::new([120, 110, 100], Texture::Plain);
        let sides = [([x0, y0], [x0, y1]), ([x1, y0], [x1, y1]), ([x0, y0], [x1, y0]), ([x0, y1], [x1, y1])];
        let thick = 0.015;
        for (wall, (a, b)) in self.walls.iter().zip(sides) {
            let Some(wall) = wall else { continue };
            let wall = mesh.material(*wall);
            let board = mesh.material(board);
            let h = self.wall_height;
            mesh.add_quad([[a[0], a[1], 0.0], [b[0], b[1], 0.0], [b[0], b[1], h], [a[0], a[1], h]], wall);
            let low = [a[0] - thick, a[1] - thick, 0.0];
            mesh.add_box(low, [b[0] + thick, b[1] + thick, 0.08], board);
        }
        mesh
    }
}

/// A patch of sunlight: the beam that falls through a window, a slanted prism over a rectangle on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards the sun, in the world.
    pub direction: [f32; 3],
    /// Middle of the patch on the floor, in metres.
    pub centre: [f32; 2],
    /// Half the patch's extent along its own axes, in metres.
    pub half: [f32; 2],
    /// Turn of the patch in rad.
    pub yaw: f32,
}

impl Sun {
    /// Whether the point of the world lies in the beam.
    pub(crate) fn reaches(&self, p: [f32; 3]) -> bool {
        let t = p[2] / self.direction[2].max(1e-3);
        let x = p[0] - self.direction[0] * t - self.centre[0];
        let y = p[1] - self.direction[1] * t - self.centre[1];
        let (s, c) = libm::sincosf(self.yaw);
        (c * x + s * y).abs() <= self.half[0] && (c * y - s * x).abs() <= self.half[1]
    }
}

/// The light in a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Unit vector towards the light, in the world.
    pub direction: [f32; 3],
    /// Share of light from everywhere, 0 to 1.
    pub ambient: f32,
    /// Share of light from `direction`, 0 to 1.
    pub diffuse: f32,
    /// A patch of sunlight, in which the depth sensor is blinded.
    pub sun: Option<Sun>,
}

impl Default for Light {
    /// A bright room, a lamp high up to the side, no sun.
    fn default() -> Self {
        Self { direction: [-0.36, 0.48, 0.8], ambient: 0.65, diffuse: 0.4, sun: None }
    }
}

/// Everything the camera may see. Labels: 0 is the room and nothing at all, i + 1 is `instances[i]` (at most 255).
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The objects.
    pub instances: Vec<Instance>,
    /// Floor and walls.
    pub room: Option<Room>,
    /// The light.
    pub light: Light,
}

impl Scene {
    /// One object alone at the origin, without a floor.
    #[must_use]
    pub fn of(mesh: Arc<Mesh>) -> Self {
        Self { instances: vec![Instance { mesh, pose: Pose::default() }], ..Self::default() }
    }
}
