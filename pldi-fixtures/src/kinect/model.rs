//! How a Kinect v1 turns surfaces into readings.

use super::noise::{normal_share, smooth_field};
use super::raster::{NOTHING, Raster};
use super::shade::Shader;
use crate::rng::derive;
use crate::vec3::dot;

/// The structured-light sensor's error model.
///
/// A reading is a disparity f b / z, rounded to a fraction of a pixel: at z metres the steps are 2.92e-3 z^2 m apart
/// (Khoshelham and Elberink 2012 give 2.85e-3). There is none where the projector's light does not reach, where it
/// comes back too weak, or where the sun outshines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KinectModel {
    /// Distance from the infrared camera to the projector in metres, along the camera's x axis; default +0.075. The
    /// shadows lie on the far side: to the left of objects.
    pub baseline: f32,
    /// Focal length at which the disparity is measured, in pixels; default 571.26. It stays when images of another size
    /// are made.
    pub focal: f32,
    /// Steps of the disparity per pixel; default 8.
    pub steps_per_pixel: f32,
    /// Standard deviation of the readings along z, rounding included, at 1 m, in metres; it grows with z^2. Default
    /// 1.425e-3 (Khoshelham and Elberink 2012).
    pub axial: f32,
    /// Standard deviation of edges in the image, in pixels at `focal`: `lateral[0] + lateral[1] t / (pi/2 - t)` for
    /// a surface at angle t. Default 0.8, 0.035 (Nguyen, Izadi and Lovell 2012).
    pub lateral: [f32; 2],
    /// Angles of incidence, in rad, between which readings fade from all to none; default 75 and 86 degrees.
    pub grazing: [f32; 2],
    /// Returned light, as reflectance x cosine / z^2 in 1/m^2, between which readings fade from none to all; default
    /// 0.0009 and 0.0035.
    pub signal: [f32; 2],
    /// How many times more light it takes in the sun; default 150.
    pub sun_loss: f32,
}

impl Default for KinectModel {
    fn default() -> Self {
        let degree = core::f32::consts::PI / 180.0;
        Self {
            baseline: 0.075,
            focal: 571.26,
            steps_per_pixel: 8.0,
            axial: 1.425e-3,
            lateral: [0.8, 0.035],
            grazing: [75.0 * degree, 86.0 * degree],
            signal: [0.0009, 0.0035],
            sun_loss: 150.0,
        }
    }
}

/// 0 below `range[0]`, 1 above `range[1]`, smooth between.
fn fade(x: f32, range: [f32; 2]) -> f32 {
    let t = ((x - range[0]) / (range[1] - range[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl KinectModel {
    /// The distance between two neighbouring readings of 1/z, in 1/m.
    fn step(&self) -> f64 {
        1.0 / (f64::from(self.focal) * f64::from(self.baseline.abs()) * f64::from(self.steps_per_pixel))
    }

    /// The standard deviation to add to 1/z before rounding, in 1/m, for `axial` to come out after it.
    fn spread(&self) -> f64 {
        let (total, step) = (f64::from(self.axial), self.step());
        (total * total - step * step / 12.0).max(0.0).sqrt()
    }

    /// Columns the projector's image must extend to the left of the camera's, for surfaces from `near` metres on.
    pub(super) fn margin(&self, fx: f64, near: f64) -> usize {
        (fx * f64::from(self.baseline.abs()) / near).ceil() as usize + 2
    }

    /// The image of depths in mm. `projector` is the scene as the projector sees it, its image wider by `margin` columns
    /// on either side.
    pub(super) fn measure(
        &self,
        raster: &Raster,
        projector: &Raster,
        margin: usize,
        shader: &Shader<'_>,
        range: [f32; 2],
        seed: u64,
    ) -> Vec<u16> {
        let k = raster.pinhole;
        let (w, h) = (k.width, k.height);
        let field = |stream| smooth_field(w, h, derive(seed, stream));
        let (aside, along, error, loss) = (field(1), field(2), field(3), field(4));
        let scale = k.fx / f64::from(self.focal);
        let (step, spread) = (self.step(), self.spread());
        let mut depth = vec![0u16; w * h];
        for v in 0..h {
            for u in 0..w {
                let pixel = v * w + u;
                let Some((facet, own)) = surface(raster, u, v) else { continue };
                let cosine = incidence(raster, facet, u, v);
                let angle = libm::acosf(cosine);
                // The cap keeps grazing surfaces from borrowing from far away.
                let blur = self.lateral[0] + self.lateral[1] * angle / (core::f32::consts::FRAC_PI_2 - angle).max(0.05);
                let jitter = |n: f32, size: usize, at: usize| {
                    let moved = (at as f64 + f64::from(n * blur) * scale).round();
                    moved.clamp(0.0, size as f64 - 1.0) as usize
                };
                let (ju, jv) = (jitter(aside[pixel], w, u), jitter(along[pixel], h, v));
                // The jitter moves edges; on the surface itself it must not add to the axial error, so the plane found
                // there is read off here.
                let Some((other, there)) = surface(raster, ju, jv) else { continue };
                let plane = &raster.facets[other];
                let w_true = plane.inverse_z(u as f64, v as f64).clamp(0.97 * there, 1.03 * there);
                let w_true = if other == facet { own } else { w_true };
                if self.shadowed(projector, margin, u, v, w_true, k.fx) {
                    continue;
                }
                // Half of the loss comes in blots, half in specks.
                let luck = 0.85 * loss[v / 3 * w + u / 3] + 0.53 * loss[pixel];
                if normal_share(luck) < self.missing(raster, shader, ju, jv, other) {
                    continue;
                }
                let reading = ((w_true + f64::from(error[pixel]) * spread) / step).round() * step;
                let z = 1.0 / reading;
                if reading > 0.0 && z >= f64::from(range[0]) && z <= f64::from(range[1]) {
                    depth[pixel] = (z * 1000.0).round() as u16;
                }
            }
        }
        depth
    }

    /// Whether the projector's view of the point at pixel (u, v) and 1/z is blocked.
    fn shadowed(&self, projector: &Raster, margin: usize, u: usize, v: usize, inverse_z: f64, fx: f64) -> bool {
        let column = u as f64 - fx * f64::from(self.baseline) * inverse_z + margin as f64;
        let width = projector.pinhole.width;
        if column < 0.0 || column >= width as f64 - 1.0 {
            return false;
        }
        // Between the two columns the surface itself passes from one value to the other; only what lies before both
        // blocks.
        let left = v * width + column.floor() as usize;
        let nearest = projector.inverse_z[left].min(projector.inverse_z[left + 1]);
        nearest > inverse_z * 1.006
    }

    /// The probability that a surface gives no reading for want of light.
    fn missing(&self, raster: &Raster, shader: &Shader<'_>, u: usize, v: usize, facet: usize) -> f32 {
        let cosine = incidence(raster, facet, u, v);
        let grazing = fade(libm::acosf(cosine), self.grazing);
        let Some(look) = shader.look(raster, u, v) else { return 1.0 };
        let z = 1.0 / raster.inverse_z[v * raster.pinhole.width + u] as f32;
        // Dyes that look dark still reflect some infrared.
        let luminance = 0.3 * look.albedo[0] + 0.6 * look.albedo[1] + 0.1 * look.albedo[2];
        let mut signal = (0.12 + 0.88 * luminance) * cosine / (z * z);
        if shader.sunlit(&look) {
            signal /= self.sun_loss;
        }
        let seen = (1.0 - grazing) * fade(signal, self.signal) * (1.0 - 0.5 * look.gloss);
        1.0 - seen
    }
}

/// The facet at a pixel and its 1/z.
fn surface(raster: &Raster, u: usize, v: usize) -> Option<(usize, f64)> {
    let pixel = v * raster.pinhole.width + u;
    let facet = raster.facet[pixel];
    (facet != NOTHING).then(|| (facet as usize, raster.inverse_z[pixel]))
}

/// The cosine between a pixel's ray and the facet's normal, 0 to 1.
pub(super) fn incidence(raster: &Raster, facet: usize, u: usize, v: usize) -> f32 {
    let k = raster.pinhole;
    let ray = [((u as f64 - k.cx) / k.fx) as f32, ((v as f64 - k.cy) / k.fy) as f32, 1.0];
    (-dot(raster.facets[facet].normal, ray) / dot(ray, ray).sqrt()).clamp(0.0, 1.0)
}
