//! The pipeline in integers.

use super::arithmetic::{Arithmetic, sealed::Sealed};
use super::digest::Bits;
use super::fixed_params::{FixedParams, attempt};
use super::overlay::{Clearing, FixedImages, Gallery};
use super::{Hypotheses, Pipeline, Report, Settings, Workspace, events};
use crate::descriptor::fixed::{self as descriptor, Descriptor};
use crate::diffusion::fixed::diffusion;
use crate::floor::fixed::{Floor, FloorMode, ransac};
use crate::ground::fixed::{Cluster, SensoryArea, candidates, density};
use crate::ground::{MAX_CLUSTERS, border};
use crate::rays::fixed::{Intrinsics, Rays};
use crate::reconstruct::fixed::{self as reconstruct, ColourRow, DepthRow, DistanceTable};
use crate::templates::{Encoding, Templates};
use crate::view::fixed::{Homography, framing, warp};
use crate::{Error, Frame, matching};

/// Integers alone: for microcontrollers without an FPU, in half a megabyte, and wherever bits must not differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fixed;

/// What is computed once for a camera and a set of parameters.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct FixedTables<const W: usize, const H: usize> {
    rays: Rays<W, H>,
    distances: DistanceTable,
}

impl<const W: usize, const H: usize> Pipeline<Fixed, W, H> {
    /// What [`Pipeline::new`] does, for a `static`: the tables are made by the compiler and lie in flash.
    ///
    /// # Errors
    /// As [`Pipeline::new`].
    pub const fn constant(params: &FixedParams, intrinsics: &Intrinsics) -> Result<Self, Error> {
        match tables(params, intrinsics) {
            Ok(tables) => Ok(Self { params: *params, tables }),
            Err(error) => Err(error),
        }
    }

    /// What [`Pipeline::new`] does, in place: a pipeline that is returned takes several times its size on the stack.
    ///
    /// # Errors
    /// As [`Pipeline::new`]; then everything is as it was.
    pub fn set(&mut self, params: &FixedParams, intrinsics: &Intrinsics) -> Result<(), Error> {
        check(params)?;
        self.tables.rays = Rays::new(intrinsics)?;
        self.tables.distances = DistanceTable::new(&params.filter);
        self.params = *params;
        Ok(())
    }

    /// The rays of the camera's pixels.
    pub fn rays(&self) -> &Rays<W, H> {
        &self.tables.rays
    }

    /// Begins a frame that comes in row by row: forgets what came in of another one.
    pub fn begin(&self, workspace: &mut Workspace<Fixed, W, H>) {
        workspace.images.begin();
    }

    /// Takes in the frame's next row. When all rows are in, [`Pipeline::finish`] makes the reconstructed depth of them.
    ///
    /// # Errors
    /// `PixelCount` for rows of a wrong length, `OutOfRange` for one row too many; the row then counts as not pushed.
    pub fn push(
        &self,
        depth: DepthRow<'_>,
        colour: Option<ColourRow<'_>>,
        workspace: &mut Workspace<Fixed, W, H>,
    ) -> Result<(), Error> {
        events::error(match workspace.images.intake() {
            Some(mut intake) => intake.push(self.params.range, &self.tables.distances, depth, colour),
            None => Err(Error::Capacity("rows")),
        })
    }

    /// First stage for a frame that was pushed: the same bits as [`Pipeline::reconstruct`] gives for a whole frame.
    /// [`Pipeline::recognise`] goes on from there.
    ///
    /// # Errors
    /// `PixelCount` where rows are missing: push them, or begin anew.
    pub fn finish(&self, workspace: &mut Workspace<Fixed, W, H>) -> Result<(), Error> {
        let rows = workspace.images.rows();
        if rows != H {
            return events::error(Err(Error::PixelCount { image: "pushed", expected: W * H, found: W * rows }));
        }
        self.filter(&mut workspace.images);
        events::reconstructed::<W, H>();
        Ok(())
    }

    fn filter(&self, images: &mut FixedImages<W, H>) {
        filter(self.settings(), images);
    }
}

fn filter<const W: usize, const H: usize>(
    Settings { params, tables }: Settings<'_, Fixed, W, H>,
    images: &mut FixedImages<W, H>,
) {
    if let Some((depth, mut scratch, lines)) = images.filter() {
        reconstruct::filter(&params.filter, &tables.distances, &mut scratch, lines, depth);
    }
}

/// Checks numbers that may have been put together by hand.
const fn check(params: &FixedParams) -> Result<(), Error> {
    if params.range.min == 0 || params.range.min > params.range.max {
        return Err(Error::OutOfRange("depth range"));
    }
    attempt!(params.filter.validate());
    attempt!(params.floor.validate());
    attempt!(params.area.validate());
    attempt!(params.limits.validate());
    params.view.validate()
}

const fn tables<const W: usize, const H: usize>(
    params: &FixedParams,
    intrinsics: &Intrinsics,
) -> Result<FixedTables<W, H>, Error> {
    attempt!(check(params));
    Ok(FixedTables { rays: attempt!(Rays::new(intrinsics)), distances: DistanceTable::new(&params.filter) })
}

impl Sealed for Fixed {}

impl Arithmetic for Fixed {
    type Params = FixedParams;
    type Intrinsics = Intrinsics;
    type Tables<const W: usize, const H: usize> = FixedTables<W, H>;
    type Images<const W: usize, const H: usize> = FixedImages<W, H>;
    type Floor = Floor;
    type Length = i32;
    type Descriptor = Descriptor;
    type Distance = u32;

    fn tables<const W: usize, const H: usize>(
        params: &FixedParams,
        intrinsics: &Intrinsics,
    ) -> Result<FixedTables<W, H>, Error> {
        tables(params, intrinsics)
    }

    fn require(params: &FixedParams, templates: &Templates<'_>) -> Result<(), Error> {
        Ok(templates.require(params.view.hash, Encoding::Logarithmic)?)
    }

    fn reconstruct<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        frame: &Frame<'_, W, H>,
        images: &mut FixedImages<W, H>,
    ) {
        images.begin();
        if let Some(mut intake) = images.intake() {
            intake.push_frame(settings.params.range, &settings.tables.distances, frame);
        }
        filter(settings, images);
    }

    fn find_floor<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FixedImages<W, H>,
    ) -> Option<Floor> {
        match &params.floor {
            FloorMode::Fixed(floor) => Some(*floor),
            FloorMode::Ransac(params) => {
                let (depth, points) = images.floor()?;
                ransac::find(depth, &tables.rays, params, points)
            }
        }
    }

    fn find_candidates<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        floor: &Floor,
        images: &mut FixedImages<W, H>,
        report: &mut Report<Self>,
    ) -> Result<(), Error> {
        let axes = floor.axes();
        let rays = &tables.rays;
        let area = SensoryArea::new(&params.area, rays.intrinsics(), floor);
        report.clusters.clear();
        report.contours.clear();
        if let Some((depth, labels, counts, density)) = images.counts() {
            density::project(depth, rays, &axes, &area, &params.density, labels, counts);
            density::spread(counts, &params.density, rays.intrinsics().fx, density);
        }
        let Some(Clearing { depth, labels, marks, map_labels, density, points, used }) = images.clearing() else {
            return Ok(());
        };
        density::occupied(density, params.density.threshold, marks);
        let found = border::find(marks, map_labels, &mut report.contours, points);
        *used = border::point_count(&report.contours);
        for _ in &report.contours {
            report.clusters.push(Cluster::EMPTY).map_err(|_| Error::Capacity("clusters"))?;
        }
        candidates::gather(depth, rays, &axes, map_labels, labels, &mut report.clusters);
        let (clusters, contours) = (&mut report.clusters, &report.contours);
        candidates::judge::<W, H>(clusters, contours, points, map_labels, &axes, &area, &params.limits);
        found
    }

    fn gather_mask<const W: usize, const H: usize>(
        Settings { tables, .. }: Settings<'_, Self, W, H>,
        floor: &Floor,
        mask: impl Fn(usize, usize) -> bool,
        images: &mut FixedImages<W, H>,
        report: &mut Report<Self>,
    ) {
        let _ = report.clusters.push(Cluster::EMPTY);
        if let Some(Clearing { depth, labels, .. }) = images.clearing() {
            candidates::gather_mask(depth, &tables.rays, &floor.axes(), mask, labels, &mut report.clusters);
        }
    }

    fn diffuse_candidates<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FixedImages<W, H>,
        report: &Report<Self>,
    ) {
        // By label, so that a pixel costs one look: 0 is no cluster.
        let mut candidate = [false; MAX_CLUSTERS + 1];
        let (mut first, mut last) = ([u16::MAX; 2], [0; 2]);
        for (candidate, cluster) in candidate.iter_mut().skip(1).zip(&report.clusters) {
            *candidate = cluster.rejection.is_none();
            if *candidate {
                let [left, top, right, bottom] = cluster.bbox;
                first = [first[0].min(left), first[1].min(top)];
                last = [last[0].max(right), last[1].max(bottom)];
            }
        }
        let bounds = [0, 1].map(|i| usize::from(first[i])..=usize::from(last[i]));
        if let Some(Gallery { depth, labels, n, .. }) = images.gallery() {
            let wanted = |u: usize, v: usize| {
                let label = labels.get(v).and_then(|row| row.get(u)).copied().unwrap_or(0);
                candidate.get(usize::from(label)).copied().unwrap_or(false)
            };
            diffusion(depth, &tables.rays, params.view.radius, bounds, wanted, n);
        }
    }

    fn diffuse_all<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        images: &mut FixedImages<W, H>,
    ) {
        if let Some(Gallery { depth, n, .. }) = images.gallery() {
            diffusion(depth, &tables.rays, params.view.radius, [0..=W - 1, 0..=H - 1], |_, _| true, n);
        }
    }

    fn frame_view<const W: usize, const H: usize>(
        Settings { params, tables }: Settings<'_, Self, W, H>,
        cluster: usize,
        floor: &Floor,
        images: &mut FixedImages<W, H>,
        report: &Report<Self>,
    ) -> Option<()> {
        let Gallery { labels, n, plane, .. } = images.gallery()?;
        let label = u8::try_from(cluster + 1).ok()?;
        let cluster = report.clusters.get(cluster)?;
        let to_rays = Homography::plane_to_rays(&floor.axes(), cluster.centroid)?;
        let frontal =
            framing::frontal(params.view.framing, labels, label, cluster.bbox, &tables.rays, &to_rays, floor.height)?;
        warp::warp(n, labels, label, &frontal, plane);
        Some(())
    }

    fn describe_view<const W: usize, const H: usize>(
        Settings { params, .. }: Settings<'_, Self, W, H>,
        images: &mut FixedImages<W, H>,
    ) -> Descriptor {
        match images.gallery() {
            Some(Gallery { plane, .. }) => descriptor::describe(plane, params.view.descriptor),
            None => [0; crate::descriptor::LENGTH],
        }
    }

    fn nearest(templates: &Templates<'_>, descriptor: &Descriptor) -> Result<Hypotheses<Self>, Error> {
        Ok(matching::fixed::nearest(templates, descriptor)?)
    }

    fn feed_depth<const W: usize, const H: usize>(images: &FixedImages<W, H>, crc: u32) -> u32 {
        images.depth().feed(crc)
    }

    fn feed_ground<const W: usize, const H: usize>(images: &FixedImages<W, H>, crc: u32) -> u32 {
        let crc = images.ground().map_or(crc, |ground| ground.density.feed(crc));
        images.labels().map_or(crc, |labels| labels.feed(crc))
    }

    fn feed_n<const W: usize, const H: usize>(images: &FixedImages<W, H>, crc: u32) -> u32 {
        images.views().map_or(crc, |views| views.n.feed(crc))
    }

    fn feed_coefficients<const W: usize, const H: usize>(images: &FixedImages<W, H>, crc: u32) -> u32 {
        images.views().map_or(crc, |views| views.plane.feed(crc))
    }
}

impl Bits for Floor {
    fn feed(&self, crc: u32) -> u32 {
        self.height.feed(self.normal.feed(crc))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DepthRange;
    use crate::Intrinsics as FloatIntrinsics;
    use crate::ground::fixed::{AreaParams, Limits};
    use crate::pipeline::Params;
    use crate::view::fixed::ViewParams;

    #[test]
    fn numbers_put_together_by_hand_are_checked_and_named() {
        let camera = Intrinsics::new(&FloatIntrinsics::KINECT_QVGA).unwrap();
        let good = FixedParams::new(&Params::DEFAULT).unwrap();
        let refused = |params: FixedParams| match Pipeline::<Fixed>::new(&params, &camera) {
            Err(Error::OutOfRange(name)) => name,
            other => panic!("{:?}", other.map(|_| ())),
        };
        assert!(Pipeline::<Fixed>::new(&good, &camera).is_ok());
        let (area, limits, view) = (good.area, good.limits, good.view);
        let bad = [
            (FixedParams { range: DepthRange { min: 9, max: 8 }, ..good }, "depth range"),
            (FixedParams { area: AreaParams { near: i32::MIN, ..area }, ..good }, "area: near"),
            (FixedParams { area: AreaParams { far: i32::MAX, ..area }, ..good }, "area: far"),
            (FixedParams { area: AreaParams { left: 1, ..area }, ..good }, "area: left"),
            (FixedParams { area: AreaParams { right: i32::MAX, ..area }, ..good }, "area: right"),
            (FixedParams { limits: Limits { area: (2, 1), ..limits }, ..good }, "limits: area"),
            (FixedParams { limits: Limits { length: (-1, 1), ..limits }, ..good }, "limits: length"),
            (FixedParams { limits: Limits { min_top: -1, ..limits }, ..good }, "limits: min_top"),
            (FixedParams { limits: Limits { max_occluded: u32::MAX, ..limits }, ..good }, "limits: max_occluded"),
            (FixedParams { limits: Limits { hidden: 65_537, ..limits }, ..good }, "limits: hidden"),
            (FixedParams { view: ViewParams { radius: 0, ..view }, ..good }, "normal radius"),
        ];
        let mut set = Pipeline::<Fixed>::new(&good, &camera).unwrap();
        for (params, name) in bad {
            assert_eq!(refused(params), name);
            assert_eq!(set.set(&params, &camera), Err(Error::OutOfRange(name)));
        }
        assert_eq!(*set.params(), good);
        let other = FixedParams { area: AreaParams { far: 3 << 17, ..area }, ..good };
        assert!(set.set(&other, &camera).is_ok() && *set.params() == other);
    }
}
