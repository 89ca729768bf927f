//! The sensor: from a scene and a pose to a frame.

use pldi_core::Intrinsics;

use super::camera::CameraPose;
use super::model::{KinectModel, incidence};
use super::raster::{NOTHING, Pinhole, Raster};
use super::scene::{Instance, Scene};
use super::shade::{Drawn, Shader};
use crate::mesh::{Mesh, Transform};
use crate::rng::derive;

/// An RGB-D camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Size and focal length of the images; depth and colour are registered.
    pub intrinsics: Intrinsics,
    /// Least and greatest depth in metres that is reported.
    pub range: [f32; 2],
    /// How depth is measured; `None` for exact depth, rounded to mm.
    pub model: Option<KinectModel>,
    /// Standard deviation of the colours' noise, of 255.
    pub colour_noise: f32,
}

/// One frame with its truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Capture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Depth in mm row by row, 0 = no reading.
    pub depth: Vec<u16>,
    /// Colour row by row, 8 bits each of red, green, blue.
    pub colour: Vec<u8>,
    /// What each pixel truly shows, by geometry: 0 the room or nothing, i + 1 the scene's instance i.
    pub labels: Vec<u8>,
}

/// What the camera truly sees, without rounding.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Depth in metres row by row, 0 where there is nothing.
    pub depth: Vec<f32>,
    /// 0 the room or nothing, i + 1 the scene's instance i.
    pub labels: Vec<u8>,
    /// Cosine between the pixel's ray and the surface's normal, 0 to 1; 0 where there is nothing.
    pub cosine: Vec<f32>,
}

impl Sensor {
    /// The PrimeSense depth camera's factory calibration at VGA.
    pub const VGA: Intrinsics = Intrinsics { width: 640, height: 480, fx: 571.26, fy: 571.26, cx: 319.5, cy: 239.5 };

    /// A Kinect v1 at 640x480: 0.5 to 8 m, f = 571.26 px.
    #[must_use]
    pub fn kinect_v1() -> Self {
        Self { intrinsics: Self::VGA, range: [0.5, 8.0], model: Some(KinectModel::default()), colour_noise: 2.5 }
    }

    /// A perfect camera: exact depth rounded to mm, colours without noise.
    #[must_use]
    pub const fn noise_free(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, range: [0.001, 65.535], model: None, colour_noise: 0.0 }
    }

    /// The same sensor with images of another size.
    #[must_use]
    pub const fn with_intrinsics(self, intrinsics: Intrinsics) -> Self {
        Self { intrinsics, ..self }
    }

    /// Takes a frame. The same arguments give the same bits everywhere.
    #[must_use]
    pub fn capture(&self, scene: &Scene, camera: &CameraPose, seed: u64) -> Capture {
        let room = scene.room.as_ref().map(super::Room::mesh);
        let drawn = drawn(scene, room.as_ref());
        let raster = rasterise(self.intrinsics.into(), camera, 0.0, &drawn);
        let shader = Shader::new(scene, camera, &drawn);
        let depth = match &self.model {
            None => raster.inverse_z.iter().map(|&w| self.exact(w)).collect(),
            Some(model) => {
                let pinhole = raster.pinhole;
                let margin = model.margin(pinhole.fx, f64::from(self.range[0]).max(0.3));
                let wide = Pinhole { width: pinhole.width + 2 * margin, cx: pinhole.cx + margin as f64, ..pinhole };
                let projector = rasterise(wide, camera, f64::from(model.baseline), &drawn);
                model.measure(&raster, &projector, margin, &shader, self.range, derive(seed, 0))
            }
        };
        let colour = shader.colours(&raster, self.colour_noise, derive(seed, 1));
        let labels = labels(&raster);
        Capture { width: raster.pinhole.width, height: raster.pinhole.height, depth, colour, labels }
    }

    /// What the camera truly sees: depth in metres as computed, labels and angles. Ignores the sensor's range and model.
    #[must_use]
    pub fn render(&self, scene: &Scene, camera: &CameraPose) -> Rendering {
        let room = scene.room.as_ref().map(super::Room::mesh);
        let raster = rasterise(self.intrinsics.into(), camera, 0.0, &drawn(scene, room.as_ref()));
        let (width, height) = (raster.pinhole.width, raster.pinhole.height);
        let mut cosine = vec![0.0; width * height];
        for (pixel, value) in cosine.iter_mut().enumerate() {
            if raster.facet[pixel] != NOTHING {
                *value = incidence(&raster, raster.facet[pixel] as usize, pixel % width, pixel / width);
            }
        }
        let depth = raster.inverse_z.iter().map(|&w| if w > 0.0 { (1.0 / w) as f32 } else { 0.0 }).collect();
        Rendering { width, height, depth, labels: labels(&raster), cosine }
    }

    /// How many pixels an instance would cover alone: within the image, and on an image without borders (as far as two
    /// image sizes beyond each border).
    #[must_use]
    pub fn pixels_alone(&self, instance: &Instance, camera: &CameraPose) -> [usize; 2] {
        let k = Pinhole::from(self.intrinsics);
        let size = [k.width as f64, k.height as f64];
        let [[left, right], [top, bottom]] = self.reach(instance, camera);
        let column = left.clamp(-2.0 * size[0], 2.0 * size[0]).floor();
        let row = top.clamp(-2.0 * size[1], 2.0 * size[1]).floor();
        let wide = Pinhole {
            width: (right.clamp(column, 3.0 * size[0]) - column) as usize + 2,
            height: (bottom.clamp(row, 3.0 * size[1]) - row) as usize + 2,
            cx: k.cx - column,
            cy: k.cy - row,
            ..k
        };
        let mut raster = Raster::new(wide);
        raster.draw(&instance.mesh, &instance.pose.transform(), camera, 0.0, 1);
        let mut counts = [0; 2];
        for (v, line) in raster.facet.chunks_exact(wide.width).enumerate() {
            let inside = (0.0..size[1]).contains(&(v as f64 + row));
            for (u, &facet) in line.iter().enumerate() {
                if facet != NOTHING {
                    counts[1] += 1;
                    counts[0] += usize::from(inside && (0.0..size[0]).contains(&(u as f64 + column)));
                }
            }
        }
        counts
    }

    /// The columns and rows between which an instance is seen, in pixels, without regard to the image's borders; endless
    /// where a part of it lies beside or behind the camera.
    fn reach(&self, instance: &Instance, camera: &CameraPose) -> [[f64; 2]; 2] {
        let place = instance.pose.transform();
        let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for &vertex in &instance.mesh.vertices {
            let p = camera.to_camera(place.apply(vertex));
            let Some(pixel) = self.intrinsics.project(p).filter(|_| p[2] > 0.1) else {
                return [[f64::NEG_INFINITY, f64::INFINITY]; 2];
            };
            for (range, c) in reach.iter_mut().zip(pixel) {
                *range = [range[0].min(f64::from(c) - 1.0), range[1].max(f64::from(c) + 1.0)];
            }
        }
        reach
    }

    /// Exact depth in mm.
    fn exact(&self, inverse_z: f64) -> u16 {
        let z = 1.0 / inverse_z;
        let within = inverse_z > 0.0 && z >= f64::from(self.range[0]) && z <= f64::from(self.range[1]);
        if within { (z * 1000.0).round() as u16 } else { 0 }
    }
}

/// The scene's meshes in the order of their labels; the room, where there is one, is number 0.
fn drawn<'a>(scene: &'a Scene, room: Option<&'a Mesh>) -> Vec<Option<Drawn<'a>>> {
    let room = room.map(|mesh| Drawn { mesh, place: Transform::IDENTITY });
    let objects = scene.instances.iter().take(255).map(|i| Some(Drawn { mesh: &i.mesh, place: i.pose.transform() }));
    core::iter::once(room).chain(objects).collect()
}

fn rasterise(pinhole: Pinhole, camera: &CameraPose, shift: f64, drawn: &[Option<Drawn<'_>>]) -> Raster {
    let mut raster = Raster::new(pinhole);
    for (label, drawn) in drawn.iter().enumerate() {
        if let Some(drawn) = drawn {
            raster.draw(drawn.mesh, &drawn.place, camera, shift, label as u8);
        }
    }
    raster
}

fn labels(raster: &Raster) -> Vec<u8> {
    let label = |&facet: &u32| if facet == NOTHING { 0 } else { raster.facets[facet as usize].label };
    raster.facet.iter().map(label).collect()
}
