//! The memory plan of the pipeline in integers: which buffer lies where, and when.

use super::overlay::FixedImages;
use super::report::Report;
use super::{Fixed, FixedTables, Pipeline, Workspace};
use crate::Image;
use crate::floor::fixed::ransac;
use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};
use crate::ground::{ContourPoint, MAX_CONTOUR_POINTS, Map};
use crate::reconstruct::fixed::recursive::Lines;
use crate::wavelet::fixed::Plane;

/// Bytes that the workspace may take: it fits the 520 KiB of an RP2350 and the 512 KiB AXI memory of an STM32H743, with room
/// for the stack and the rest of a firmware.
pub const MEMORY_LIMIT: usize = 480 * 1024;

const _: () = assert!(size_of::<Workspace<Fixed>>() <= MEMORY_LIMIT, "the workspace is larger than planned");

/// A buffer of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Buffer {
    /// What it holds.
    pub name: &'static str,
    /// When it is in use.
    pub stage: Stage,
    /// Where it lies.
    pub place: Place,
    /// Bytes from the beginning of the place.
    pub offset: usize,
    /// Bytes that it takes.
    pub bytes: usize,
}

/// When a buffer is in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// All the time.
    Always,
    /// While rows come in.
    Intake,
    /// While rows come in, and during the filter.
    Filter,
    /// During the floor's search.
    Floor,
    /// While points are counted and spread on the floor.
    Density,
    /// On the ground map.
    Ground,
    /// From the count of the points on.
    GroundAndViews,
    /// For N and the views.
    Views,
}

impl Stage {
    /// The name used in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::Intake => "rows come in",
            Self::Filter => "rows come in, filter",
            Self::Floor => "floor's search",
            Self::Density => "density",
            Self::Ground => "ground map",
            Self::GroundAndViews => "density, ground map, views",
            Self::Views => "views",
        }
    }
}

/// A part of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Place {
    /// The depth.
    Depth,
    /// What the stages share one after the other.
    Shared,
    /// Rows that come in, then lines of the filter.
    Lines,
    /// The result.
    Report,
}

impl Place {
    /// The name used in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Shared => "shared",
            Self::Lines => "lines",
            Self::Report => "report",
        }
    }

    /// Bytes of the place in a QVGA workspace.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Depth => size_of::<Image<u16, W, H>>(),
            Self::Shared => size_of::<Image<u32, W, H>>(),
            Self::Lines => size_of::<Lines<W>>(),
            Self::Report => size_of::<Report<Fixed>>(),
        }
    }
}

const BYTES: usize = size_of::<Image<u8, W, H>>();
const MAP: usize = size_of::<Map<u8>>();
const ROW: usize = size_of::<[u16; W]>();

/// All buffers of a QVGA workspace.
pub const BUFFERS: &[Buffer] = &[
    entry("depth, u16", Stage::Always, Place::Depth, 0, 2 * BYTES),
    entry("distances from the left, u8", Stage::Filter, Place::Shared, 0, BYTES),
    entry("distances from above, u8", Stage::Filter, Place::Shared, BYTES, BYTES),
    entry("mask weights, u16", Stage::Filter, Place::Shared, 2 * BYTES, 2 * BYTES),
    entry("points of the search", Stage::Floor, Place::Shared, 0, ransac::SCRATCH * size_of::<ransac::Points>()),
    entry("labels of pixels, u8", Stage::GroundAndViews, Place::Shared, 0, BYTES),
    entry("counts, u16", Stage::Density, Place::Shared, BYTES, 2 * MAP),
    entry("marks, u8", Stage::Ground, Place::Shared, BYTES, MAP),
    entry("labels of cells, u8", Stage::Ground, Place::Shared, BYTES + MAP, MAP),
    entry("density, u16", Stage::Ground, Place::Shared, BYTES + 2 * MAP, 2 * MAP),
    entry(
        "contour points",
        Stage::Ground,
        Place::Shared,
        BYTES + 4 * MAP,
        MAX_CONTOUR_POINTS * size_of::<ContourPoint>(),
    ),
    entry("N, u16", Stage::Views, Place::Shared, BYTES, 2 * BYTES),
    entry("view, then coefficients, i32", Stage::Views, Place::Shared, 3 * BYTES, size_of::<Plane>()),
    entry("the last row's depth and colour, u32 u32", Stage::Intake, Place::Lines, 0, 4 * ROW),
    entry("depth that is not in mm, u16", Stage::Intake, Place::Lines, 4 * ROW, ROW),
    entry("colour to be converted, 3 u8", Stage::Intake, Place::Lines, 5 * ROW, ROW + ROW / 2),
    entry("four lines, widened", Stage::Filter, Place::Lines, 0, size_of::<Lines<W>>()),
    entry("clusters, contours, detections", Stage::Always, Place::Report, 0, size_of::<Report<Fixed>>()),
];

const fn entry(name: &'static str, stage: Stage, place: Place, offset: usize, bytes: usize) -> Buffer {
    assert!(offset + bytes <= place.bytes(), "a buffer reaches beyond its place");
    Buffer { name, stage, place, offset, bytes }
}

/// Bytes of the tables of a QVGA pipeline beside the workspace: in flash, where the pipeline is a `static` made by
/// [`Pipeline::constant`].
pub const TABLES: usize = size_of::<Pipeline<Fixed>>();

const _: () = assert!(size_of::<FixedTables<W, H>>() <= TABLES && size_of::<FixedImages<W, H>>() < MEMORY_LIMIT);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace};
    use crate::{Floor, Frame, Intrinsics, floor::FloorMode, rays};

    fn address<T: ?Sized>(value: &T) -> usize {
        core::ptr::from_ref(value).cast::<u8>().addr()
    }

    /// The buffers that can be seen from outside lie where the plan says.
    #[test]
    fn the_plan_is_what_the_workspace_does() {
        let floor = FloorMode::Fixed(Floor::from_pose(1.0, 0.3, 0.0).unwrap());
        let params = FixedParams::new(&Params { floor, ..Params::DEFAULT }).unwrap();
        let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
        let pipeline = QvgaFixedPipeline::new(&params, &camera).unwrap();
        let mut workspace = Box::new(QvgaFixedWorkspace::new());
        let planned = |name: &str| BUFFERS.iter().find(|b| b.name.starts_with(name)).unwrap();
        assert!(workspace.images.labels().is_none() && workspace.images.ground().is_none());

        let depth = [[1500; W]; H];
        pipeline.reconstruct(&Frame { depth: &depth, colour: None }, &mut workspace);
        let floor = pipeline.find_floor(&mut workspace).unwrap();
        pipeline.find_candidates(&floor, &mut workspace).unwrap();
        let shared = address(workspace.images.labels().unwrap());
        let ground = workspace.images.ground().unwrap();
        for (name, found) in [
            ("labels of cells", address(ground.map_labels)),
            ("density", address(ground.density)),
            ("contour points", address(ground.points)),
        ] {
            assert_eq!(found - shared, planned(name).offset, "{name}");
        }
        assert!(workspace.images.views().is_none());
        pipeline.diffuse_all(&mut workspace);
        let views = workspace.images.views().unwrap();
        assert_eq!(address(views.n) - shared, planned("N,").offset);
        assert_eq!(address(views.plane) - shared, planned("view,").offset);
        assert!(workspace.images.ground().is_none());
    }

    /// Buffers of one stage do not overlap.
    #[test]
    fn what_is_used_together_lies_apart() {
        let together = |a: Stage, b: Stage| {
            let views = [Stage::GroundAndViews, Stage::Views];
            let ground = [Stage::GroundAndViews, Stage::Ground];
            let density = [Stage::GroundAndViews, Stage::Density];
            a == b || [views, ground, density].iter().any(|group| group.contains(&a) && group.contains(&b))
        };
        for (i, a) in BUFFERS.iter().enumerate() {
            for b in &BUFFERS[i + 1..] {
                let apart = a.offset + a.bytes <= b.offset || b.offset + b.bytes <= a.offset;
                assert!(a.place != b.place || !together(a.stage, b.stage) || apart, "{a:?} {b:?}");
            }
        }
        let places: usize = [Place::Depth, Place::Shared, Place::Lines, Place::Report].map(Place::bytes).iter().sum();
        assert!(size_of::<QvgaFixedWorkspace>() - places < 64);
    }
}
