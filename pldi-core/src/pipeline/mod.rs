//! All stages behind one call: an RGB-D frame in, recognised objects out.
//!
//! The pipeline runs in either of two arithmetics, [`Float`] (f32) and [`Fixed`] (integers alone); what is not arithmetic is
//! the same code for both.

mod arithmetic;
pub mod digest;
mod events;
mod fixed;
mod fixed_params;
mod float;
pub mod mix;
mod overlay;
mod params;
pub mod plan;
mod report;
mod workspace;

pub use arithmetic::Arithmetic;
pub use fixed::{Fixed, FixedTables};
pub use fixed_params::FixedParams;
pub use float::{Float, FloatImages, FloatTables};
pub use overlay::{FixedImages, Ground, Views};
pub use params::Params;
pub use report::{Detection, Hypotheses, MAX_DETECTIONS, Report};
pub use workspace::Workspace;

use crate::frame::{QVGA_HEIGHT, QVGA_WIDTH};
use crate::templates::Templates;
use crate::{Error, Frame, Rays};

/// Everything that is computed once for a camera and a set of parameters.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct Pipeline<A: Arithmetic, const W: usize = QVGA_WIDTH, const H: usize = QVGA_HEIGHT> {
    params: A::Params,
    tables: A::Tables<W, H>,
}

/// A pipeline for QVGA frames.
pub type QvgaPipeline = Pipeline<Float, QVGA_WIDTH, QVGA_HEIGHT>;

/// The memory of a pipeline for QVGA frames.
pub type QvgaWorkspace = Workspace<Float, QVGA_WIDTH, QVGA_HEIGHT>;

/// A pipeline for QVGA frames in integers.
pub type QvgaFixedPipeline = Pipeline<Fixed, QVGA_WIDTH, QVGA_HEIGHT>;

/// The memory of a pipeline for QVGA frames in integers.
pub type QvgaFixedWorkspace = Workspace<Fixed, QVGA_WIDTH, QVGA_HEIGHT>;

/// What a stage may look up: the parameters and the tables made of them.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a, A: Arithmetic, const W: usize, const H: usize> {
    /// The parameters.
    pub params: &'a A::Params,
    /// The tables.
    pub tables: &'a A::Tables<W, H>,
}

impl<A: Arithmetic, const W: usize, const H: usize> Pipeline<A, W, H> {
    /// Checks the parameters and fills the tables.
    ///
    /// # Errors
    /// The first parameter that is out of range, by its name; intrinsics of another size than `W` x `H`.
    pub fn new(params: &A::Params, intrinsics: &A::Intrinsics) -> Result<Self, Error> {
        Ok(Self { params: *params, tables: A::tables(params, intrinsics)? })
    }

    /// The parameters.
    pub fn params(&self) -> &A::Params {
        &self.params
    }

    fn settings(&self) -> Settings<'_, A, W, H> {
        Settings { params: &self.params, tables: &self.tables }
    }

    /// Takes a frame all the way: fills `workspace.report`, and the images that the stages leave behind.
    ///
    /// A frame without depth, without a floor or without a candidate is no error: the report says so.
    ///
    /// # Errors
    /// `Templates` where the set was made with other view parameters or for the other arithmetic; `Capacity` where the
    /// frame has more clusters, contour points or candidates than there is room for.
    pub fn run(
        &self,
        frame: &Frame<'_, W, H>,
        templates: &Templates<'_>,
        workspace: &mut Workspace<A, W, H>,
    ) -> Result<(), Error> {
        events::error(A::require(&self.params, templates))?;
        self.reconstruct(frame, workspace);
        self.recognise(templates, workspace)
    }

    /// All stages after the first: from the reconstructed depth to the report.
    ///
    /// # Errors
    /// As [`Pipeline::run`].
    pub fn recognise(&self, templates: &Templates<'_>, workspace: &mut Workspace<A, W, H>) -> Result<(), Error> {
        events::error(A::require(&self.params, templates))?;
        workspace.report.clear();
        let Some(floor) = self.find_floor(workspace) else { return Ok(()) };
        self.find_candidates(&floor, workspace)?;
        self.classify(&floor, templates, workspace)
    }

    /// The stages after the third: from the candidates to the detections, which are added to the report.
    ///
    /// # Errors
    /// As [`Pipeline::run`].
    pub fn classify(
        &self,
        floor: &A::Floor,
        templates: &Templates<'_>,
        workspace: &mut Workspace<A, W, H>,
    ) -> Result<(), Error> {
        events::error(A::require(&self.params, templates))?;
        self.diffuse_candidates(workspace);
        for i in 0..workspace.report.clusters.len() {
            if workspace.report.clusters.get(i).is_none_or(|cluster| cluster.rejection.is_some()) {
                continue;
            }
            let Some(descriptor) = self.describe(i, floor, workspace) else {
                events::no_view(i);
                continue;
            };
            let hypotheses = events::error(A::nearest(templates, &descriptor))?;
            let detection = Detection { cluster: i as u16, descriptor, hypotheses };
            events::detection(&detection);
            let pushed = workspace.report.detections.push(detection);
            events::error(pushed.map_err(|_| Error::Capacity("detections")))?;
        }
        Ok(())
    }

    /// First stage: the reconstructed depth.
    pub fn reconstruct(&self, frame: &Frame<'_, W, H>, workspace: &mut Workspace<A, W, H>) {
        A::reconstruct(self.settings(), frame, &mut workspace.images);
        events::reconstructed::<W, H>();
    }

    /// Second stage: the floor (also in the report), from the pose or from the reconstructed depth.
    pub fn find_floor(&self, workspace: &mut Workspace<A, W, H>) -> Option<A::Floor> {
        workspace.report.floor = A::find_floor(self.settings(), &mut workspace.images);
        events::floor::<A>(workspace.report.floor.as_ref());
        workspace.report.floor
    }

    /// Third stage: the ground map, its clusters and their tests (`report.clusters`, and the images of the ground).
    ///
    /// # Errors
    /// `Capacity` where the frame has more clusters or contour points than there is room for.
    pub fn find_candidates(&self, floor: &A::Floor, workspace: &mut Workspace<A, W, H>) -> Result<(), Error> {
        let found = A::find_candidates(self.settings(), floor, &mut workspace.images, &mut workspace.report);
        events::clusters(&workspace.report);
        events::error(found)
    }

    /// Fourth stage: N at the pixels of candidates, 0 elsewhere.
    pub fn diffuse_candidates(&self, workspace: &mut Workspace<A, W, H>) {
        A::diffuse_candidates(self.settings(), &mut workspace.images, &workspace.report);
    }

    /// N of the whole image: what people look at.
    pub fn diffuse_all(&self, workspace: &mut Workspace<A, W, H>) {
        A::diffuse_all(self.settings(), &mut workspace.images);
    }

    /// Fifth stage: the view of a cluster, from N and the labels; `None` where it has no pixels.
    pub fn frame_view(&self, cluster: usize, floor: &A::Floor, workspace: &mut Workspace<A, W, H>) -> Option<()> {
        A::frame_view(self.settings(), cluster, floor, &mut workspace.images, &workspace.report)
    }

    /// Sixth and seventh stage: wavelet and descriptor of the view that [`Pipeline::frame_view`] left. Once only: in
    /// integers, the coefficients take the view's place.
    pub fn describe_view(&self, workspace: &mut Workspace<A, W, H>) -> A::Descriptor {
        A::describe_view(self.settings(), &mut workspace.images)
    }

    /// Fifth to seventh stage: view, wavelet and descriptor of a cluster; `None` where it has no pixels.
    pub fn describe(
        &self,
        cluster: usize,
        floor: &A::Floor,
        workspace: &mut Workspace<A, W, H>,
    ) -> Option<A::Descriptor> {
        self.frame_view(cluster, floor, workspace)?;
        Some(self.describe_view(workspace))
    }

    /// The descriptor of pixels that are known to be one object: those of the reconstructed depth where `mask` holds.
    ///
    /// For templates and benchmarks: no ground map, no tests. The report gets the object as its only cluster.
    /// `None` where no such pixel has depth.
    pub fn describe_mask(
        &self,
        floor: &A::Floor,
        mask: impl Fn(usize, usize) -> bool,
        workspace: &mut Workspace<A, W, H>,
    ) -> Option<A::Descriptor> {
        workspace.report.clear();
        workspace.report.floor = Some(*floor);
        A::gather_mask(self.settings(), floor, mask, &mut workspace.images, &mut workspace.report);
        self.diffuse_candidates(workspace);
        self.describe(0, floor, workspace)
    }
}

impl<const W: usize, const H: usize> Pipeline<Float, W, H> {
    /// The rays of the camera's pixels.
    pub fn rays(&self) -> &Rays<W, H> {
        &self.tables.rays
    }
}
