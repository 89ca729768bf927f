//! All stages behind one call: an RGB-D frame in, recognised objects out.

mod params;
mod report;
mod workspace;

pub use params::Params;
pub use report::{Detection, MAX_DETECTIONS, Report};
pub use workspace::Workspace;

use crate::descriptor::{self, Descriptor};
use crate::diffusion::diffusion;
use crate::floor::{FloorMode, ransac};
use crate::ground::SensoryArea;
use crate::ground::density::Gaussian;
use crate::ground::{Cluster, border, candidates, density};
use crate::reconstruct::{GuideTable, reconstruct};
use crate::view::{Homography, framing, warp};
use crate::{Error, Floor, FloorAxes, Frame, Intrinsics, Rays, matching, templates::Templates};

/// Everything that is computed once for a camera and a set of parameters.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct Pipeline<const W: usize, const H: usize> {
    params: Params,
    rays: Rays<W, H>,
    guide: GuideTable,
    gaussian: Gaussian,
}

/// A pipeline for QVGA frames.
pub type QvgaPipeline = Pipeline<{ crate::frame::QVGA_WIDTH }, { crate::frame::QVGA_HEIGHT }>;

/// The memory of a pipeline for QVGA frames.
pub type QvgaWorkspace = Workspace<{ crate::frame::QVGA_WIDTH }, { crate::frame::QVGA_HEIGHT }>;

impl<const W: usize, const H: usize> Pipeline<W, H> {
    /// Checks the parameters and fills the tables.
    ///
    /// # Errors
    /// The first parameter that is out of range, by its name; intrinsics of another size than `W` x `H`.
    pub fn new(params: &Params, intrinsics: &Intrinsics) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            params: *params,
            rays: Rays::new(intrinsics)?,
            guide: GuideTable::new(&params.filter),
            gaussian: Gaussian::new(),
        })
    }

    /// The parameters.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// The rays of the camera's pixels.
    pub fn rays(&self) -> &Rays<W, H> {
        &self.rays
    }

    /// Takes a frame all the way: fills `workspace.report`, and the images that the stages leave behind.
    ///
    /// A frame without depth, without a floor or without a candidate is no error: the report says so.
    ///
    /// # Errors
    /// `Templates` where the set was made with other view parameters; `Capacity` where the frame has more clusters,
    /// contour points or candidates than there is room for.
    pub fn run(
        &self,
        frame: &Frame<'_, W, H>,
        templates: &Templates<'_>,
        workspace: &mut Workspace<W, H>,
    ) -> Result<(), Error> {
        templates.require(&self.params.view)?;
        workspace.report.clear();
        self.reconstruct(frame, workspace);
        let Some(floor) = self.find_floor(workspace) else { return Ok(()) };
        self.find_candidates(&floor, workspace)?;
        self.diffuse_candidates(workspace);
        for i in 0..workspace.report.clusters.len() {
            if workspace.report.clusters[i].rejection.is_some() {
                continue;
            }
            let Some(descriptor) = self.describe(i, &floor, workspace) else { continue };
            let hypotheses = matching::nearest(templates, &descriptor);
            let detection = Detection { cluster: i as u16, descriptor, hypotheses };
            workspace.report.detections.push(detection).map_err(|_| Error::Capacity("detections"))?;
        }
        Ok(())
    }

    /// First stage: the reconstructed depth (`workspace.depth`).
    pub fn reconstruct(&self, frame: &Frame<'_, W, H>, workspace: &mut Workspace<W, H>) {
        let Params { filter, range, .. } = &self.params;
        reconstruct(frame, *range, filter, &self.guide, &mut workspace.filter, &mut workspace.depth);
    }

    /// Second stage: the floor (also in the report), from the pose or from `workspace.depth`.
    pub fn find_floor(&self, workspace: &mut Workspace<W, H>) -> Option<Floor> {
        workspace.report.floor = match &self.params.floor {
            FloorMode::Fixed(floor) => Some(*floor),
            FloorMode::Ransac(params) => ransac::find(&workspace.depth, &self.rays, params),
        };
        workspace.report.floor
    }

    /// Third stage: the ground map, its clusters and their tests (`workspace.density`, `labels`, `report.clusters`).
    ///
    /// # Errors
    /// `Capacity` where the frame has more clusters or contour points than there is room for.
    pub fn find_candidates(&self, floor: &Floor, workspace: &mut Workspace<W, H>) -> Result<(), Error> {
        let params = &self.params;
        let axes = floor.axes();
        let area = SensoryArea::new(&params.area, self.rays.intrinsics(), floor);
        let Workspace { depth, labels, counts, density, marks, map_labels, report, .. } = workspace;
        density::project(depth, &self.rays, &axes, &area, &params.density, labels, counts);
        density::spread(counts, &params.density, self.rays.intrinsics().fx, &self.gaussian, density);
        border::find(density, params.density.threshold, marks, map_labels, &mut report.contours, &mut report.points)?;
        report.clusters.clear();
        for _ in &report.contours {
            report.clusters.push(Cluster::EMPTY).map_err(|_| Error::Capacity("clusters"))?;
        }
        candidates::gather(labels, map_labels, depth, &self.rays, &axes, &mut report.clusters);
        let (clusters, contours, points) = (&mut report.clusters, &report.contours, &report.points);
        candidates::judge::<W, H>(clusters, contours, points, map_labels, &axes, &area, &params.limits);
        Ok(())
    }

    /// Fourth stage: N (`workspace.n`) at the pixels of candidates, 0 elsewhere.
    pub fn diffuse_candidates(&self, workspace: &mut Workspace<W, H>) {
        let Workspace { depth, labels, n, report, .. } = workspace;
        let wanted = |u: usize, v: usize| {
            let label = usize::from(labels[v][u]);
            label.checked_sub(1).and_then(|i| report.clusters.get(i)).is_some_and(|c| c.rejection.is_none())
        };
        diffusion(depth, &self.rays, self.params.view.radius, wanted, n);
    }

    /// N (`workspace.n`) of the whole image: what people look at.
    pub fn diffuse_all(&self, workspace: &mut Workspace<W, H>) {
        let Workspace { depth, n, .. } = workspace;
        diffusion(depth, &self.rays, self.params.view.radius, |_, _| true, n);
    }

    /// Fifth stage: the view of a cluster (`workspace.view`), from N and the labels; `None` where it has no pixels.
    pub fn frame_view(&self, cluster: usize, floor: &Floor, workspace: &mut Workspace<W, H>) -> Option<()> {
        let Workspace { labels, n, view, report, .. } = workspace;
        let cluster_ = report.clusters.get(cluster)?;
        let (label, axes) = (cluster as u16 + 1, floor.axes());
        view_of(&self.params, &axes, self.rays.intrinsics(), cluster_, label, labels, n, view)
    }

    /// Fifth to seventh stage: view, wavelet and descriptor of a cluster (`workspace.view`, `workspace.coefficients`);
    /// `None` where it has no pixels.
    pub fn describe(&self, cluster: usize, floor: &Floor, workspace: &mut Workspace<W, H>) -> Option<Descriptor> {
        self.frame_view(cluster, floor, workspace)?;
        Some(descriptor::describe(&workspace.view, self.params.view.descriptor, &mut workspace.coefficients))
    }

    /// The descriptor of pixels that are known to be one object: those of `workspace.depth` where `mask` holds.
    ///
    /// For templates and benchmarks: no ground map, no tests. The report gets the object as its only cluster.
    /// `None` where no such pixel has depth.
    pub fn describe_mask(
        &self,
        floor: &Floor,
        mask: impl Fn(usize, usize) -> bool,
        workspace: &mut Workspace<W, H>,
    ) -> Option<Descriptor> {
        let Workspace { depth, labels, report, map_labels, .. } = workspace;
        report.clear();
        report.floor = Some(*floor);
        // A ground map of one cell, with the object in it.
        map_labels.as_flattened_mut().fill(0);
        map_labels[0][0] = 1;
        for (v, (line, depths)) in labels.iter_mut().zip(depth.iter()).enumerate() {
            for (u, (label, z)) in line.iter_mut().zip(depths).enumerate() {
                *label = if *z > 0.0 && mask(u, v) { 0 } else { density::NO_CELL };
            }
        }
        report.clusters.push(Cluster::EMPTY).ok()?;
        candidates::gather(labels, map_labels, depth, &self.rays, &floor.axes(), &mut report.clusters);
        self.diffuse_candidates(workspace);
        self.describe(0, floor, workspace)
    }
}

#[allow(clippy::too_many_arguments, reason = "parts of the workspace, borrowed one by one")]
fn view_of<const W: usize, const H: usize>(
    params: &Params,
    axes: &FloorAxes,
    intrinsics: &Intrinsics,
    cluster: &Cluster,
    label: u16,
    labels: &crate::Image<u16, W, H>,
    n: &crate::Image<u16, W, H>,
    view: &mut descriptor::View,
) -> Option<()> {
    let to_image = Homography::plane_to_image(axes, intrinsics, cluster.centroid)?;
    let (framing, pixel) = (params.view.framing, 1.0 / intrinsics.fx);
    let frontal = framing::frontal(framing, labels, label, cluster.bbox, &to_image, axes.floor.height, pixel)?;
    warp::warp(n, labels, label, &frontal, view);
    Some(())
}
