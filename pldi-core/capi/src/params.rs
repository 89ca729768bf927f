//! Parameters in integers.

use crate::VERSION;
use crate::border;
use crate::checked::view_of;
use crate::status::pldi_status::{self, *};
use crate::templates::pldi_templates;
use pldi_core::floor::fixed::RansacParams;
use pldi_core::ground::fixed::DensityParams;
use pldi_core::pipeline::{FixedParams, Params};
use pldi_core::rays::fixed::Intrinsics;
use pldi_core::reconstruct::fixed::Disparity;
use pldi_core::view::fixed::Framing;

/// How raw disparity becomes depth: z = scale / (offset - disparity), in mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_disparity {
    /// Focal length (px) times baseline (mm) times disparity steps per pixel. Kinect v1: 580 * 75 * 8.
    pub scale: u32,
    /// Disparity of a point at infinity, in steps. Kinect v1: 1090.
    pub offset: u16,
    /// From this disparity on there is no reading. Kinect v1: 2047.
    pub none: u16,
}

/// A pinhole camera. Focal lengths and principal point in 1/65536 pixel (PLDI_PIXELS).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_intrinsics {
    /// Width in pixels of the images that the numbers are for: PLDI_WIDTH.
    pub width: u16,
    /// Height in pixels of the images that the numbers are for: PLDI_HEIGHT.
    pub height: u16,
    /// Focal length, horizontally.
    pub fx: i32,
    /// Focal length, vertically.
    pub fy: i32,
    /// Column of the principal point, from the centre of the leftmost column.
    pub cx: i32,
    /// Row of the principal point, from the centre of the topmost row.
    pub cy: i32,
}

/// What guides the filter that reconstructs the depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum pldi_filter_kind {
    /// Colour and depth; depth alone where there is no colour.
    PLDI_FILTER_JOINT = 0,
    /// Depth alone.
    PLDI_FILTER_BILATERAL = 1,
    /// No filter: the measured depth as it is.
    PLDI_FILTER_NONE = 2,
}

/// Reconstruction of the depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_filter {
    /// One of pldi_filter_kind.
    pub kind: u32,
    /// Spatial standard deviation in 1/65536 pixel: 0.5 to 100 pixels.
    pub sigma_space: u32,
    /// Standard deviation of the sum of the three channels' differences, in 1/65536: 1 to 1000.
    pub sigma_colour: u32,
    /// Standard deviation of the depth in 1/128 mm (PLDI_MM): 1 to 250 mm.
    pub sigma_depth: u32,
    /// Passes over rows and columns, 1 to 5.
    pub iterations: u32,
    /// A pixel stays without depth where the filtered mask is not above this, in 2^-27: 1e-6 to 0.999.
    pub weight_floor: u32,
}

/// Where the floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum pldi_floor_mode {
    /// Found in each frame: see pldi_floor_search.
    PLDI_FLOOR_SEARCH = 0,
    /// The camera's pose is known: see pldi_pose.
    PLDI_FLOOR_POSE = 1,
}

/// The camera above the floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_pose {
    /// Height above the floor in 1/128 mm (PLDI_MM): 1 cm to 10 m.
    pub height: i32,
    /// How far it looks down, in 2^-28 radians (PLDI_DEGREES); 0 is level. Within a quarter turn.
    pub pitch: i32,
    /// How far it is turned clockwise about its axis, in 2^-28 radians (PLDI_DEGREES). Within a quarter turn.
    pub roll: i32,
}

/// The search for the floor: random samples of three points, the same ones for the same seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_floor_search {
    /// Seed of the random numbers.
    pub seed: u32,
    /// Samples that are drawn, 1 to 10,000.
    pub samples: u32,
    /// Tolerance at the camera in 1/128 mm (PLDI_MM): 0.1 mm to 0.5 m.
    pub tolerance: i32,
    /// Growth of the tolerance with the squared depth, in 1/1024 mm per square metre: up to 0.5 m.
    pub tolerance_per_z2: i32,
    /// Smallest height of the camera above the floor in 1/128 mm (PLDI_MM): 1 cm to 10 m.
    pub height_min: i32,
    /// Largest height.
    pub height_max: i32,
    /// Smallest pitch in 2^-28 radians (PLDI_DEGREES), within 1.6.
    pub pitch_min: i32,
    /// Largest pitch.
    pub pitch_max: i32,
    /// From this pitch on a plane counts for a fifth.
    pub steep: i32,
    /// Largest tilt to a side in 2^-28 radians, 0 to 1.6.
    pub tilt: i32,
    /// Share of the points with depth that must lie on the floor, in 1/65536.
    pub support: i32,
    /// Points beyond this depth in 1/128 mm (PLDI_MM) are not looked at: 0.1 m to 100 m.
    pub far: i32,
}

/// The sensory area: where on the floor objects are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_area {
    /// Nearest distance along the floor in 1/128 mm (PLDI_MM): 0 to 4 m.
    pub near: i32,
    /// Farthest distance along the floor in 1/128 mm: 2 cm more than the nearest, up to 4.12 m.
    pub far: i32,
    /// Leftmost angle from the direction of view in 2^-28 radians (PLDI_DEGREES): -1.5 to 0.
    pub left: i32,
    /// Rightmost angle: 0 to 1.5.
    pub right: i32,
}

/// What a cluster of pixels must be like to be a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_limits {
    /// Fewest pixels; below, it is noise.
    pub min_pixels: u32,
    /// Smallest area of the footprint in 25 mm^2 (PLDI_SQUARE_METRES).
    pub area_min: u32,
    /// Largest area of the footprint, up to 10,000 m^2.
    pub area_max: u32,
    /// Smallest length of the footprint's contour in 1/128 mm (PLDI_MM).
    pub length_min: i32,
    /// Largest length of the footprint's contour, up to 10 km.
    pub length_max: i32,
    /// Smallest height above the floor in 1/128 mm: up to 10 m.
    pub min_top: i32,
    /// Largest share of the contour that may lie behind another cluster, in 1/65536.
    pub max_occluded: u32,
    /// A cell counts as hidden where more than this share of the cluster's height is, in 1/65536.
    pub hidden: u32,
    /// Pixels within so many columns or rows of the image's left, right or lower border make a cluster reach it.
    pub margin: u16,
}

/// What the descriptors are made of: as the templates' are, see pldi_params_for_templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_view {
    /// 0 = the paper's moments, 1 = means of both halves.
    pub descriptor: u32,
    /// 0 = the view fits the object, 1 = it has a fixed side.
    pub framing: u32,
    /// That side in 1/128 mm: 0.1 m to 10 m. Not looked at where the view fits the object.
    pub side: i32,
    /// Radius of the normals in 1/8 mm: 5 mm to 500 mm.
    pub radius: u16,
    /// The hash by which templates know these parameters.
    pub hash: u32,
}

/// All parameters, in integers. Fill them with pldi_default_params, then change what is to be changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_params {
    /// Set by pldi_default_params: tells the library that this was filled, and for which version.
    pub version: u32,
    /// Smallest valid depth in mm, at least 1.
    pub depth_min: u16,
    /// Largest valid depth in mm. Beyond 8191 mm depths saturate.
    pub depth_max: u16,
    /// For rows of raw disparity.
    pub disparity: pldi_disparity,
    /// The camera. Default: the Kinect's nominal calibration at 320x240.
    pub intrinsics: pldi_intrinsics,
    /// Reconstruction of the depth.
    pub filter: pldi_filter,
    /// One of pldi_floor_mode. Default: the search.
    pub floor_mode: u32,
    /// The camera above the floor, for PLDI_FLOOR_POSE. Default: 1.2 m, level.
    pub pose: pldi_pose,
    /// The search, for PLDI_FLOOR_SEARCH.
    pub search: pldi_floor_search,
    /// Where objects are looked for.
    pub area: pldi_area,
    /// Which clusters are candidates.
    pub limits: pldi_limits,
    /// What the descriptors are made of.
    pub view: pldi_view,
}

/// The defaults of the core, turned into integers by the compiler.
pub(crate) const CORE: FixedParams = match FixedParams::new(&Params::DEFAULT) {
    Ok(params) => params,
    Err(_) => panic!("the defaults are in range"),
};

/// Not to be set from C: how points are counted on the floor.
pub(crate) const DENSITY: DensityParams = CORE.density;

const SEARCH: RansacParams = RansacParams::DEFAULT;

pub(crate) const CAMERA: Intrinsics = match Intrinsics::new(&pldi_core::Intrinsics::KINECT_QVGA) {
    Ok(camera) => camera,
    Err(_) => panic!("a nominal calibration is in range"),
};

/// [`pldi_default_params`].
pub(crate) const DEFAULT: pldi_params = pldi_params {
    version: VERSION,
    depth_min: CORE.range.min,
    depth_max: CORE.range.max,
    disparity: pldi_disparity {
        scale: Disparity::KINECT.scale,
        offset: Disparity::KINECT.offset,
        none: Disparity::KINECT.none,
    },
    intrinsics: pldi_intrinsics {
        width: CAMERA.width,
        height: CAMERA.height,
        fx: CAMERA.fx,
        fy: CAMERA.fy,
        cx: CAMERA.cx,
        cy: CAMERA.cy,
    },
    filter: pldi_filter {
        kind: pldi_filter_kind::PLDI_FILTER_JOINT as u32,
        sigma_space: CORE.filter.sigma_space,
        sigma_colour: CORE.filter.sigma_colour,
        sigma_depth: CORE.filter.sigma_depth,
        iterations: CORE.filter.iterations as u32,
        weight_floor: CORE.filter.weight_floor,
    },
    floor_mode: pldi_floor_mode::PLDI_FLOOR_SEARCH as u32,
    pose: pldi_pose { height: 1200 * 128, pitch: 0, roll: 0 },
    search: pldi_floor_search {
        seed: SEARCH.seed,
        samples: SEARCH.samples as u32,
        tolerance: SEARCH.tolerance,
        tolerance_per_z2: SEARCH.tolerance_per_z2,
        height_min: SEARCH.height.0,
        height_max: SEARCH.height.1,
        pitch_min: SEARCH.pitch.0,
        pitch_max: SEARCH.pitch.1,
        steep: SEARCH.steep,
        tilt: SEARCH.tilt,
        support: SEARCH.support,
        far: SEARCH.far,
    },
    area: pldi_area { near: CORE.area.near, far: CORE.area.far, left: CORE.area.left, right: CORE.area.right },
    limits: pldi_limits {
        min_pixels: CORE.limits.min_pixels,
        area_min: CORE.limits.area.0,
        area_max: CORE.limits.area.1,
        length_min: CORE.limits.length.0,
        length_max: CORE.limits.length.1,
        min_top: CORE.limits.min_top,
        max_occluded: CORE.limits.max_occluded,
        hidden: CORE.limits.hidden,
        margin: CORE.limits.margin,
    },
    view: pldi_view {
        descriptor: CORE.view.descriptor as u32,
        framing: 0,
        side: 0,
        radius: CORE.view.radius,
        hash: CORE.view.hash,
    },
};

const _: () = assert!(matches!(CORE.view.framing, Framing::Fit), "the default view fits the object");

/// Fills in the defaults: a Kinect at 320x240 whose pose is found in each frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_default_params(params: *mut pldi_params) -> pldi_status {
    // SAFETY: what the header asks for.
    unsafe { border::put(params, DEFAULT) }.into()
}

/// Sets params->view to what a template set was made with. Only needed for sets that were built with other options than
/// the defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_params_for_templates(
    params: *mut pldi_params,
    templates: *const pldi_templates,
) -> pldi_status {
    let set = || {
        // SAFETY: what the header asks for.
        let (params, templates) = unsafe { (border::exclusive(params)?, pldi_templates::get(templates)?) };
        if params.version != VERSION {
            return Err(PLDI_ERROR_VERSION);
        }
        params.view = view_of(templates.view_params())?;
        Ok(())
    };
    set().into()
}
