//! The look of each pixel: Lambert shading of the procedural textures.

use super::camera::CameraPose;
use super::raster::{NOTHING, Raster};
use super::scene::{Scene, Sun};
use crate::mesh::{Material, Mesh, Transform};
use crate::rng::Rng;
use crate::vec3::{add, dot, scale, sub};

/// A mesh with its place in the world, as drawn under one label.
pub(super) struct Drawn<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) place: Transform,
}

impl Drawn<'_> {
    /// A triangle's material.
    pub(super) fn material(&self, triangle: u32) -> Material {
        let index = self.mesh.triangles[triangle as usize].material;
        self.mesh.materials.get(usize::from(index)).copied().unwrap_or(Material::plain([128; 3]))
    }

    /// A point of the world in the object's frame.
    pub(super) fn local(&self, world: [f32; 3]) -> [f32; 3] {
        let q = sub(world, self.place.translation);
        let r = self.place.rotation;
        [0, 1, 2].map(|k| dot([r[0][k], r[1][k], r[2][k]], q))
    }
}

/// What a surface does to light, for each pixel of a drawn scene.
pub(super) struct Shader<'a> {
    pub(super) drawn: &'a [Option<Drawn<'a>>],
    axes: [[f32; 3]; 3],
    origin: [f32; 3],
    light: super::Light,
}

/// A pixel's surface.
pub(super) struct Look {
    /// 0 to 1 each of red, green, blue.
    pub(super) albedo: [f32; 3],
    /// 0 matt to 1 polished.
    pub(super) gloss: f32,
    /// The point in the world in metres.
    pub(super) world: [f32; 3],
    /// Unit normal in the world.
    pub(super) normal: [f32; 3],
}

impl<'a> Shader<'a> {
    pub(super) fn new(scene: &Scene, camera: &CameraPose, drawn: &'a [Option<Drawn<'a>>]) -> Self {
        let axes = camera.axes().map(|a| a.map(|c| c as f32));
        Self { drawn, axes, origin: camera.position(), light: scene.light }
    }

    /// From the camera's axes to the world's.
    fn turn(&self, p: [f32; 3]) -> [f32; 3] {
        add(add(scale(self.axes[0], p[0]), scale(self.axes[1], p[1])), scale(self.axes[2], p[2]))
    }

    /// The surface at a pixel; `None` where there is nothing.
    pub(super) fn look(&self, raster: &Raster, u: usize, v: usize) -> Option<Look> {
        let k = raster.pinhole;
        let pixel = v * k.width + u;
        let number = raster.facet[pixel];
        if number == NOTHING {
            return None;
        }
        let facet = &raster.facets[number as usize];
        let drawn = self.drawn[usize::from(facet.label)].as_ref()?;
        let z = (1.0 / raster.inverse_z[pixel]) as f32;
        let ray = [((u as f64 - k.cx) / k.fx) as f32, ((v as f64 - k.cy) / k.fy) as f32, 1.0];
        let world = add(self.turn(scale(ray, z)), self.origin);
        let material = drawn.material(facet.triangle);
        Some(Look {
            albedo: material.albedo(drawn.local(world)),
            gloss: material.gloss,
            world,
            normal: self.turn(facet.normal),
        })
    }

    /// Whether the sun shines on the surface.
    pub(super) fn sunlit(&self, look: &Look) -> bool {
        self.light.sun.is_some_and(|sun: Sun| dot(look.normal, sun.direction) > 0.0 && sun.reaches(look.world))
    }

    /// Colours for each pixel, 8 bits each of red, green, blue, with normal noise of `sigma` (of 255).
    pub(super) fn colours(&self, raster: &Raster, sigma: f32, seed: u64) -> Vec<u8> {
        let mut rng = Rng::new(seed);
        let k = raster.pinhole;
        let mut colours = Vec::with_capacity(3 * k.width * k.height);
        for v in 0..k.height {
            for u in 0..k.width {
                let mut colour = [18.0f32; 3];
                if let Some(look) = self.look(raster, u, v) {
                    let lambert = dot(look.normal, self.light.direction).max(0.0);
                    // A little light from above, so that faces turned away from the lamp still differ.
                    let sky = 0.85 + 0.15 * look.normal[2];
                    let mut light = self.light.ambient * sky + self.light.diffuse * lambert;
                    if self.sunlit(&look) {
                        light += 0.7;
                    }
                    colour = look.albedo.map(|a| 255.0 * a * light);
                }
                // Brightness noise is common to the channels, colour noise is smaller.
                let common = if sigma > 0.0 { sigma * rng.normal() } else { 0.0 };
                for channel in colour {
                    let own = if sigma > 0.0 { 0.5 * sigma * rng.normal() } else { 0.0 };
                    colours.push((channel + common + own).clamp(0.0, 255.0).round() as u8);
                }
            }
        }
        colours
    }
}
