//! From C's parameters to the core's, and back: every number is checked.

use crate::VERSION;
use crate::params::{
    DENSITY, pldi_disparity, pldi_filter, pldi_filter_kind, pldi_floor_mode, pldi_intrinsics, pldi_limits, pldi_params,
    pldi_pose, pldi_view,
};
use crate::status::Checked;
use crate::status::pldi_status::*;
use pldi_core::descriptor::DescriptorKind;
use pldi_core::floor::fixed::{Floor, FloorMode, RansacParams};
use pldi_core::ground::fixed::{AreaParams, Limits};
use pldi_core::pipeline::FixedParams;
use pldi_core::rays::fixed::Intrinsics;
use pldi_core::reconstruct::FilterKind;
use pldi_core::reconstruct::fixed::{Disparity, FilterParams};
use pldi_core::view::fixed::{Framing, ViewParams};
use pldi_core::{DepthRange, view};

/// The numbers of a template file's view parameters.
pub(crate) fn view_of(view: &view::ViewParams) -> Checked<pldi_view> {
    let (framing, side) = match view.framing {
        view::Framing::Fit => (0, 0),
        view::Framing::Metric { side } => (1, units(side, 128_000).ok_or(PLDI_ERROR_VIEW)?),
    };
    let radius = units(view.radius, 8_000).and_then(|radius| u16::try_from(radius).ok()).ok_or(PLDI_ERROR_VIEW)?;
    Ok(pldi_view { descriptor: view.descriptor as u32, framing, side, radius, hash: view.hash() })
}

/// A length in metres in units of 1/`scale`, rounded as [`pldi_core::fixed::quantise`] does, but out of its bits: a
/// microcontroller without FPU should not need the software floating point for two numbers. `None` for what is negative, not
/// finite or above 2^24 m.
fn units(metres: f32, scale: u32) -> Option<i32> {
    let bits = metres.to_bits();
    let exponent = bits >> 23;
    // 1.0 has the exponent 127, and a mantissa of 2^23.
    if exponent > 127 + 24 {
        return None;
    }
    let mantissa = if exponent == 0 { 0 } else { bits & 0x7F_FFFF | 0x80_0000 };
    // Below 2^56; halves are rounded up.
    let product = u64::from(mantissa) * u64::from(scale);
    let value = match (127 + 23u32).checked_sub(exponent) {
        Some(0) => product,
        Some(shift) if shift < 64 => (product + (1 << (shift - 1))) >> shift,
        Some(_) => 0,
        None => product << (exponent - 150),
    };
    i32::try_from(value).ok()
}

/// The core's parameters, each group checked under its name.
pub(crate) fn checked(params: &pldi_params) -> Checked<(FixedParams, Intrinsics, Disparity)> {
    if params.version != VERSION {
        return Err(PLDI_ERROR_VERSION);
    }
    let range = DepthRange { min: params.depth_min, max: params.depth_max };
    if range.min == 0 || range.min > range.max {
        return Err(PLDI_ERROR_DEPTH_RANGE);
    }
    let pldi_disparity { scale, offset, none } = params.disparity;
    let disparity = Disparity { scale, offset, none };
    if scale == 0 || offset == 0 {
        return Err(PLDI_ERROR_DISPARITY);
    }
    let pldi_intrinsics { width, height, fx, fy, cx, cy } = params.intrinsics;
    let camera = Intrinsics { width, height, fx, fy, cx, cy };
    let fits = usize::from(width) == crate::PLDI_WIDTH && usize::from(height) == crate::PLDI_HEIGHT;
    camera.validate().ok().filter(|()| fits).ok_or(PLDI_ERROR_INTRINSICS)?;
    let area =
        AreaParams { near: params.area.near, far: params.area.far, left: params.area.left, right: params.area.right };
    area.validate().map_err(|_| PLDI_ERROR_AREA)?;
    let params = FixedParams {
        range,
        filter: filter(&params.filter)?,
        floor: floor(params)?,
        area,
        density: DENSITY,
        limits: limits(&params.limits)?,
        view: view(&params.view)?,
    };
    Ok((params, camera, disparity))
}

fn filter(filter: &pldi_filter) -> Checked<FilterParams> {
    const KINDS: [(u32, FilterKind); 3] = [
        (pldi_filter_kind::PLDI_FILTER_JOINT as u32, FilterKind::Joint),
        (pldi_filter_kind::PLDI_FILTER_BILATERAL as u32, FilterKind::Bilateral),
        (pldi_filter_kind::PLDI_FILTER_NONE as u32, FilterKind::None),
    ];
    let kind = KINDS.iter().find(|(number, _)| *number == filter.kind).ok_or(PLDI_ERROR_FORMAT)?.1;
    let params = FilterParams {
        kind,
        sigma_space: filter.sigma_space,
        sigma_colour: filter.sigma_colour,
        sigma_depth: filter.sigma_depth,
        iterations: u8::try_from(filter.iterations).map_err(|_| PLDI_ERROR_FILTER)?,
        weight_floor: filter.weight_floor,
    };
    params.validate().map_err(|_| PLDI_ERROR_FILTER)?;
    Ok(params)
}

fn floor(params: &pldi_params) -> Checked<FloorMode> {
    const SEARCHED: u32 = pldi_floor_mode::PLDI_FLOOR_SEARCH as u32;
    const POSED: u32 = pldi_floor_mode::PLDI_FLOOR_POSE as u32;
    match params.floor_mode {
        SEARCHED => {
            let search = &params.search;
            let params = RansacParams {
                seed: search.seed,
                samples: u16::try_from(search.samples).map_err(|_| PLDI_ERROR_FLOOR)?,
                tolerance: search.tolerance,
                tolerance_per_z2: search.tolerance_per_z2,
                height: (search.height_min, search.height_max),
                pitch: (search.pitch_min, search.pitch_max),
                steep: search.steep,
                tilt: search.tilt,
                support: search.support,
                far: search.far,
            };
            params.validate().map_err(|_| PLDI_ERROR_FLOOR)?;
            Ok(FloorMode::Ransac(params))
        }
        POSED => {
            let pldi_pose { height, pitch, roll } = params.pose;
            Floor::from_pose(height, pitch, roll).map(FloorMode::Fixed).map_err(|_| PLDI_ERROR_FLOOR)
        }
        _ => Err(PLDI_ERROR_FORMAT),
    }
}

fn limits(limits: &pldi_limits) -> Checked<Limits> {
    let limits = Limits {
        min_pixels: limits.min_pixels,
        area: (limits.area_min, limits.area_max),
        length: (limits.length_min, limits.length_max),
        min_top: limits.min_top,
        max_occluded: limits.max_occluded,
        hidden: limits.hidden,
        margin: limits.margin,
    };
    limits.validate().map_err(|_| PLDI_ERROR_LIMITS)?;
    Ok(limits)
}

fn view(view: &pldi_view) -> Checked<ViewParams> {
    let descriptor = u8::try_from(view.descriptor).ok().and_then(DescriptorKind::from_number).ok_or(PLDI_ERROR_VIEW)?;
    let framing = match view.framing {
        0 => Framing::Fit,
        1 => Framing::Metric { side: view.side },
        _ => return Err(PLDI_ERROR_VIEW),
    };
    let params = ViewParams { descriptor, framing, radius: view.radius, hash: view.hash };
    params.validate().map_err(|_| PLDI_ERROR_VIEW)?;
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{CAMERA, CORE, DEFAULT};

    #[test]
    fn the_defaults_are_those_of_the_core() {
        let (params, camera, disparity) = checked(&DEFAULT).unwrap();
        assert_eq!((params, camera, disparity), (CORE, CAMERA, Disparity::KINECT));
    }

    #[test]
    fn lengths_by_bits_are_those_of_the_quantiser() {
        for i in 0..200_000u32 {
            // From below a micrometre to 30 m.
            let metres = f32::from_bits(0x3500_0000 + i * 1237);
            for scale in [8_000, 128_000] {
                let truth = pldi_core::fixed::quantise(metres, 0.0, 1000.0, f64::from(scale));
                assert_eq!(units(metres, scale).map(i64::from), truth, "{metres} {scale}");
            }
        }
        assert_eq!([0.0, 1e-40].map(|metres| units(metres, 8_000)), [Some(0); 2]);
        assert_eq!([-1.0, f32::NAN, f32::INFINITY, 1e30, 3e5].map(|metres| units(metres, 128_000)), [None; 5]);
    }
}
