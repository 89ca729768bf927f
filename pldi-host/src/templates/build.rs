//! Descriptors of meshes: a ring of views, noise-free or through the Kinect's simulation and the same pipeline as
//! real frames (paper, section 6.1).

use std::sync::Arc;

use pldi_core::floor::FloorMode;
use pldi_core::ground::{AreaParams, Limits};
use pldi_core::pipeline::{Pipeline, Workspace};
use pldi_core::view::ViewParams;
use pldi_core::{Floor, Frame, Intrinsics, Params};
use pldi_fixtures::kinect::{CameraPose, Capture, Pitch, Room, Scene, Sensor, ViewRing};
use pldi_fixtures::{Class, Material, Mesh, TEMPLATE_SEEDS, Texture, furniture, rng};

use super::write::{TemplateSet, View};
use crate::input::reduce;
use crate::{Error, Numbers, parallel};

/// How a mesh becomes views.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Horizontal distances of the camera from the object's centre in metres, one ring each. An object too large to be
    /// seen whole from there is seen from the nearest distance that shows all of it.
    pub distances: Vec<f32>,
    /// Height of the camera above the floor in metres.
    pub height: f32,
    /// Views on each ring.
    pub views: u16,
    /// `None` looks at half the object's height; otherwise the camera's pitch in radians, looking down positive.
    pub pitch: Option<f32>,
    /// Through the Kinect's simulation and the whole pipeline; otherwise the exact depth without a filter.
    pub simulate: bool,
    /// Never move the camera back for large objects.
    pub exact_distance: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self { distances: vec![2.0], height: 1.2, views: 20, pitch: None, simulate: true, exact_distance: false }
    }
}

/// A mesh with the names of its class and itself.
#[derive(Debug, Clone)]
pub struct ObjectMesh {
    /// Name of the class.
    pub class: String,
    /// Name of the object.
    pub name: String,
    /// The mesh in metres, z up, standing on z = 0, centred on x = y = 0.
    pub mesh: Arc<Mesh>,
}

/// The first `count` procedural objects of each class, out of those meant for templates, class by class.
pub fn procedural(count: u16) -> Vec<ObjectMesh> {
    let object = |class: Class, i: u16| ObjectMesh {
        class: class.name().to_owned(),
        name: format!("{} {i}", class.name()),
        mesh: Arc::new(furniture(class, TEMPLATE_SEEDS + u64::from(i))),
    };
    Class::ALL.iter().flat_map(|class| (0..count).map(move |i| object(*class, i))).collect()
}

/// Builds template sets.
#[derive(Debug, Clone)]
pub struct Builder {
    view: ViewParams,
    look: Look,
}

/// The camera of noise-free views: the PrimeSense depth camera at QVGA.
const CAMERA: Intrinsics = Intrinsics::PRIMESENSE_QVGA;

impl Builder {
    /// A builder for descriptors with these view parameters.
    ///
    /// # Errors
    /// `Usage` where a number is out of range.
    pub fn new(view: ViewParams, look: Look) -> Result<Self, Error> {
        let usage = |what: &str| Err(Error::Usage(what.to_owned()));
        view.validate().map_err(|e| Error::Usage(e.to_string()))?;
        if look.views == 0 {
            return usage("--views must be at least 1");
        }
        if look.distances.is_empty() || !look.distances.iter().all(|d| (0.3..=10.0).contains(d)) {
            return usage("--distance must lie between 0.3 and 10 m");
        }
        if !(0.05..=5.0).contains(&look.height) {
            return usage("--height must lie between 0.05 and 5 m");
        }
        if look.pitch.is_some_and(|p| !(-1.5..=1.5).contains(&p)) {
            return usage("--pitch must lie between -86 and 86 degrees");
        }
        Ok(Self { view, look })
    }

    /// The template set of some objects, computed in the arithmetic `A`; `done` is called after each object (from several threads) and stops the work by
    /// returning `false`.
    ///
    /// # Errors
    /// `Usage` for an object of which no view shows anything, or where `done` stopped the work.
    pub fn build<A: Numbers>(
        &self,
        objects: &[ObjectMesh],
        threads: usize,
        done: impl Fn(&ObjectMesh) -> bool + Sync,
    ) -> Result<TemplateSet<A>, Error> {
        let mut classes: Vec<String> = objects.iter().map(|o| o.class.clone()).collect();
        classes.sort();
        classes.dedup();
        let described = parallel::map_ordered(objects.len(), threads, A::workspace, |workspace, i| {
            let views = self.describe(&objects[i], i, workspace)?;
            if done(&objects[i]) { Ok(views) } else { Err(Error::Interrupted) }
        })?;
        let mut set = TemplateSet {
            view: self.view,
            distance: self.look.distances[0],
            height: self.look.height,
            simulated: self.look.simulate,
            classes,
            objects: Vec::new(),
            views: Vec::new(),
        };
        for (i, (object, views)) in objects.iter().zip(described).enumerate() {
            let class = set.classes.binary_search(&object.class).unwrap_or(0) as u16;
            set.objects.push((class, object.name.clone()));
            set.views.extend(views.into_iter().map(|(view, descriptor)| View { object: i as u16, view, descriptor }));
        }
        Ok(set)
    }

    /// The descriptors of all views of one object that show it, with the views' numbers. `number` is the object's in its
    /// set: the simulated noise depends on it.
    ///
    /// # Errors
    /// `Usage` where no view shows anything.
    pub fn describe<A: Numbers>(
        &self,
        object: &ObjectMesh,
        number: usize,
        workspace: &mut Workspace<A>,
    ) -> Result<Vec<(u16, A::Descriptor)>, Error> {
        let mut out = Vec::new();
        for (ring_number, distance) in self.look.distances.iter().enumerate() {
            let pitch = self.look.pitch.map_or(Pitch::HalfHeight, Pitch::Fixed);
            let mut ring = ViewRing {
                views: usize::from(self.look.views),
                distance: *distance,
                height: self.look.height,
                pitch,
                floor: None,
            };
            if !self.look.exact_distance {
                ring.distance = seen_whole(&ring, &object.mesh);
            }
            for i in 0..ring.views {
                let camera = ring.camera(i, height_of(&object.mesh));
                let descriptor = if self.look.simulate {
                    self.simulated(object, number, ring_number, i, &camera, workspace)
                } else {
                    self.exact(object, &camera, workspace)
                }?;
                let view = (ring_number * ring.views + i) as u16;
                out.extend(descriptor.map(|d| (view, d)));
            }
        }
        if out.is_empty() {
            return Err(Error::Usage(format!("no view shows anything of {}: is its unit right?", object.name)));
        }
        Ok(out)
    }

    /// Exact depth without a filter; everything that is seen is the object.
    fn exact<A: Numbers>(
        &self,
        object: &ObjectMesh,
        camera: &CameraPose,
        workspace: &mut Workspace<A>,
    ) -> Result<Option<A::Descriptor>, Error> {
        let floor = floor_of(camera)?;
        let params = Params { view: self.view, floor: FloorMode::Fixed(floor), ..Params::DEFAULT };
        let pipeline = pipeline::<A>(&params, &CAMERA)?;
        let rendering = Sensor::noise_free(CAMERA).render(&Scene::of(object.mesh.clone()), camera);
        A::set_depth(workspace, &rendering.depth);
        Ok(pipeline.describe_mask(&A::floor(&floor)?, |_, _| true, workspace))
    }

    /// Through the simulation and the pipeline: the object stands on a floor, and is what the ground map finds there;
    /// where it finds nothing (a flat or tiny object), it is the pixels that truly show it.
    fn simulated<A: Numbers>(
        &self,
        object: &ObjectMesh,
        number: usize,
        ring: usize,
        view: usize,
        camera: &CameraPose,
        workspace: &mut Workspace<A>,
    ) -> Result<Option<A::Descriptor>, Error> {
        let mut scene = Scene::of(object.mesh.clone());
        scene.room = Some(Room::floor_only(20.0, Material::new([150, 140, 125], Texture::Plain)));
        let seed = rng::derive(rng::derive(number as u64, ring as u64), view as u64);
        let sensor = Sensor::kinect_v1();
        let Capture { depth, colour, labels, .. } = sensor.capture(&scene, camera, seed);
        let (depth, colour) = reduce(&depth, &colour, 2);
        let intrinsics = sensor.intrinsics.reduced(2).map_err(Error::core)?;
        let floor = floor_of(camera)?;
        let params = Params {
            view: self.view,
            floor: FloorMode::Fixed(floor),
            area: AreaParams { near: 0.0, ..AreaParams::DEFAULT },
            limits: Limits { area: (0.0, 100.0), length: (0.0, 1000.0), min_top: 0.0, ..Limits::DEFAULT },
            ..Params::DEFAULT
        };
        let (pipeline, floor) = (pipeline::<A>(&params, &intrinsics)?, A::floor(&floor)?);
        let frame = Frame::new(&depth, Some(&colour)).map_err(Error::core)?;
        pipeline.reconstruct(&frame, workspace);
        workspace.report.clear();
        pipeline.find_candidates(&floor, workspace).map_err(Error::core)?;
        let clusters = &mut workspace.report.clusters;
        for cluster in clusters.iter_mut() {
            cluster.rejection = None;
        }
        let largest = clusters.iter().enumerate().max_by_key(|(i, c)| (c.pixels, usize::MAX - i));
        if let Some((i, cluster)) = largest
            && cluster.pixels >= Limits::DEFAULT.min_pixels
        {
            pipeline.diffuse_candidates(workspace);
            return Ok(pipeline.describe(i, &floor, workspace));
        }
        Ok(pipeline.describe_mask(&floor, |u, v| labels.get(2 * v * 640 + 2 * u) == Some(&1), workspace))
    }
}

fn pipeline<A: Numbers>(params: &Params, intrinsics: &Intrinsics) -> Result<Pipeline<A>, Error> {
    Pipeline::new(&A::params(params)?, &A::intrinsics(intrinsics)?).map_err(Error::core)
}

fn height_of(mesh: &Mesh) -> f32 {
    mesh.bounds().map_or(0.0, |b| b.max[2])
}

fn floor_of(camera: &CameraPose) -> Result<Floor, Error> {
    Floor::from_pose(camera.height, camera.pitch, camera.roll).map_err(Error::core)
}

/// The distance from which the lower image border and the sides leave room for the whole footprint of an object.
fn seen_whole(ring: &ViewRing, mesh: &Mesh) -> f32 {
    let Some(bounds) = mesh.bounds() else { return ring.distance };
    let size = bounds.size();
    let radius = 0.5 * (size[0] * size[0] + size[1] * size[1]).sqrt();
    let mut distance = ring.distance;
    // The pitch depends on the distance: a few rounds settle it.
    for _ in 0..8 {
        let camera = ViewRing { distance, ..*ring }.camera(0, size[2]);
        let lower = camera.pitch + libm::atanf(0.95 * (CAMERA.height as f32 / 2.0) / CAMERA.fy);
        let nearest_floor = ring.height / libm::tanf(lower.clamp(0.05, 1.5));
        let side = 0.95 * (CAMERA.width as f32 / 2.0) / CAMERA.fx;
        distance = ring.distance.max(nearest_floor + radius).max(radius / side + 0.3 * radius);
    }
    distance
}
