//! The pipeline in single precision.

use super::arithmetic::{Arithmetic, sealed::Sealed};
use super::digest::Bits;
use super::{Hypotheses, Params, Report, Settings};
use crate::descriptor::{self, Descriptor, View};
use crate::diffusion::diffusion;
use crate::floor::{FloorMode, ransac};
use crate::ground::density::Gaussian;
use crate::ground::{
    Cluster, ContourPoint, MAP_DEPTH, MAP_WIDTH, MAX_CONTOUR_POINTS, Map, SensoryArea, border, candidates, density,
};
use crate::reconstruct::{FilterScratch, GuideTable, reconstruct};
use crate::templates::{Encoding, Templates};
use crate::view::{Homography, framing, warp};
use crate::wavelet::{Plane, SIZE};
use crate::{Error, Floor, Frame, Image, Intrinsics, Rays, matching};
use heapless::Vec;

/// Single precision: for hosts, and for microcontrollers with an FPU and megabytes of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Float;

/// What is computed once for a camera and a set of parameters.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct FloatTables<const W: usize, const H: usize> {
    pub(super) rays: Rays<W, H>,
    guide: GuideTable,
    gaussian: Gaussian,
}

/// The images between the stages.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "megabytes should not be copied by accident")]
pub struct FloatImages<const W: usize, const H: usize> {
    /// The reconstructed depth in metres, 0 = none.
    pub depth: Image<f32, W, H>,
    /// The number of each pixel's cluster, from 1; 0 = none.
    pub labels: Image<u16, W, H>,
    /// N, 65535 = 1; 0 = none.
    pub n: Image<u16, W, H>,
    /// Image L: points above the floor per cell, in pixels as if seen from 2 m.
    pub counts: Map<f32>,
    /// Their density, in the same unit.
    pub density: Map<f32>,
    /// The number of each cell's cluster, from 1; 0 = none.
    pub map_labels: Map<u8>,
    /// The contours' points.
    pub points: Vec<ContourPoint, MAX_CONTOUR_POINTS>,
    /// The view of the last candidate, 65535 = 1.
    pub view: View,
    /// Its wavelet coefficients.
    pub coefficients: Plane,
    marks: Map<u8>,
    filter: FilterScratch<W, H>,
}

impl<const W: usize, const H: usize> FloatImages<W, H> {
    /// Empty images.
    pub const fn new() -> Self {
        Self {
            depth: [[0.0; W]; H],
            labels: [[0; W]; H],
            n: [[0; W]; H],
            counts: [[0.0; MAP_WIDTH]; MAP_DEPTH],
            density: [[0.0; MAP_WIDTH]; MAP_DEPTH],
            map_labels: [[0; MAP_WIDTH]; MAP_DEPTH],
            points: Vec::new(),
            view: [[0; SIZE]; SIZE],
            coefficients: [[0.0; SIZE]; SIZE],
            marks: [[0; MAP_WIDTH]; MAP_DEPTH],
            filter: FilterScratch::new(),
        }
    }
}

impl<const W: usize, const H: usize> Default for FloatImages<W, H> {
    fn default() -> Self {
        Self::new()
    }
}

impl Sealed for Float {}

impl Arithmetic for Float {
    type Params = Params;
    type Intrinsics = Intrinsics;
    type Tables<const W: usize, const H: usize> = FloatTables<W, H>;
    type Images<const W: usize, const H: usize> = FloatImages<W, H>;
    type Floor = Floor;
    type Length = f32;
    type Descriptor = Descriptor;
    type Distance = f32;

    fn tables<const W: usize, const H: usize>(
        params: &Params,
        intrinsics: &Intrinsics,
    ) -> Result<FloatTables<W, H>, Error> {
        params.validate()?;
        Ok(FloatTables {
            rays: Rays::new(intrinsics)?,
            guide: GuideTable::new(&params.filter),
            gaussian: Gaussian::new(),
        })
    }

    fn require(params: &Params, templates: &Templates<'_>) -> Result<(), Error> {
        Ok(templates.require(params.view.hash(), Encoding::Float)?)
    }

    fn reconstruct<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        frame: &Frame<'_, W, H>,
        images: &mut FloatImages<W, H>,
    ) {
        reconstruct(frame, params.range, &params.filter, &tables.guide, &mut images.filter, &mut images.depth);
    }

    fn find_floor<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FloatImages<W, H>,
    ) -> Option<Floor> {
        match &params.floor {
            FloorMode::Fixed(floor) => Some(*floor),
            FloorMode::Ransac(params) => ransac::find(&images.depth, &tables.rays, params),
        }
    }

    fn find_candidates<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        floor: &Floor,
        images: &mut FloatImages<W, H>,
        report: &mut Report<Self>,
    ) -> Result<(), Error> {
        let axes = floor.axes();
        let FloatTables { rays, gaussian, .. } = tables;
        let area = SensoryArea::new(&params.area, rays.intrinsics(), floor);
        let FloatImages { depth, labels, counts, density, marks, map_labels, points, .. } = images;
        density::project(depth, rays, &axes, &area, &params.density, labels, counts);
        density::spread(counts, &params.density, rays.intrinsics().fx, gaussian, density);
        density::occupied(density, params.density.threshold, marks);
        // As long as its capacity: always room.
        let _ = points.resize_default(MAX_CONTOUR_POINTS);
        let found = border::find(marks, map_labels, &mut report.contours, points);
        points.truncate(border::point_count(&report.contours));
        found?;
        report.clusters.clear();
        for _ in &report.contours {
            report.clusters.push(Cluster::EMPTY).map_err(|_| Error::Capacity("clusters"))?;
        }
        candidates::gather(labels, map_labels, depth, rays, &axes, &mut report.clusters);
        let (clusters, contours) = (&mut report.clusters, &report.contours);
        candidates::judge::<W, H>(clusters, contours, points, map_labels, &axes, &area, &params.limits);
        Ok(())
    }

    fn gather_mask<const W: usize, const H: usize>(
        Settings { tables, .. }: Settings<'_, Self, W, H>,
        floor: &Floor,
        mask: impl Fn(usize, usize) -> bool,
        images: &mut FloatImages<W, H>,
        report: &mut Report<Self>,
    ) {
        let FloatImages { depth, labels, map_labels, .. } = images;
        // A ground map of one cell, with the object in it.
        map_labels.as_flattened_mut().fill(0);
        map_labels[0][0] = 1;
        for (v, (line, depths)) in labels.iter_mut().zip(depth.iter()).enumerate() {
            for (u, (label, z)) in line.iter_mut().zip(depths).enumerate() {
                *label = if *z > 0.0 && mask(u, v) { 0 } else { density::NO_CELL };
            }
        }
        let _ = report.clusters.push(Cluster::EMPTY);
        candidates::gather(labels, map_labels, depth, &tables.rays, &floor.axes(), &mut report.clusters);
    }

    fn diffuse_candidates<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FloatImages<W, H>,
        report: &Report<Self>,
    ) {
        let FloatImages { depth, labels, n, .. } = images;
        let wanted = |u: usize, v: usize| {
            let label = usize::from(labels[v][u]);
            label.checked_sub(1).and_then(|i| report.clusters.get(i)).is_some_and(|c| c.rejection.is_none())
        };
        diffusion(depth, &tables.rays, params.view.radius, wanted, n);
    }

    fn diffuse_all<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FloatImages<W, H>,
    ) {
        diffusion(&images.depth, &tables.rays, params.view.radius, |_, _| true, &mut images.n);
    }

    fn frame_view<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        cluster: usize,
        floor: &Floor,
        images: &mut FloatImages<W, H>,
        report: &Report<Self>,
    ) -> Option<()> {
        let FloatImages { labels, n, view, .. } = images;
        let label = cluster as u16 + 1;
        let cluster = report.clusters.get(cluster)?;
        let (axes, intrinsics) = (floor.axes(), tables.rays.intrinsics());
        let to_image = Homography::plane_to_image(&axes, intrinsics, cluster.centroid)?;
        let (framing, pixel) = (params.view.framing, 1.0 / intrinsics.fx);
        let frontal = framing::frontal(framing, labels, label, cluster.bbox, &to_image, floor.height, pixel)?;
        warp::warp(n, labels, label, &frontal, view);
        Some(())
    }

    fn describe_view<const W: usize, const H: usize>(
        Settings { params, .. }: Settings<'_, Self, W, H>,
        images: &mut FloatImages<W, H>,
    ) -> Descriptor {
        descriptor::describe(&images.view, params.view.descriptor, &mut images.coefficients)
    }

    fn nearest(templates: &Templates<'_>, descriptor: &Descriptor) -> Result<Hypotheses<Self>, Error> {
        Ok(matching::nearest(templates, descriptor)?)
    }

    fn feed_depth<const W: usize, const H: usize>(images: &FloatImages<W, H>, crc: u32) -> u32 {
        images.depth.feed(crc)
    }

    fn feed_ground<const W: usize, const H: usize>(images: &FloatImages<W, H>, crc: u32) -> u32 {
        images.labels.feed(images.density.feed(crc))
    }

    fn feed_n<const W: usize, const H: usize>(images: &FloatImages<W, H>, crc: u32) -> u32 {
        images.n.feed(crc)
    }

    fn feed_coefficients<const W: usize, const H: usize>(images: &FloatImages<W, H>, crc: u32) -> u32 {
        images.coefficients.feed(crc)
    }
}

impl Bits for Floor {
    fn feed(&self, crc: u32) -> u32 {
        self.height.feed(self.normal.feed(crc))
    }
}
