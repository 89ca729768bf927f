//! What a frame came to.

use crate::border;
use crate::pipeline::{State, pldi_workspace};
use crate::status::Checked;
use crate::status::pldi_status::{self, *};
use crate::templates::{pldi_templates, pldi_text};
use core::ffi::{CStr, c_char};
use pldi_core::ground::{Rejection, fixed::Cluster};
use pldi_core::matching::Hypothesis;
use pldi_core::templates::Templates;

/// The most detections of a frame.
pub const PLDI_MAX_DETECTIONS: usize = 32;

/// The most rejected clusters of a frame.
pub const PLDI_MAX_REJECTED: usize = 192;

/// The most hypotheses of a detection.
pub const PLDI_MAX_HYPOTHESES: usize = 5;

/// No class: the template set is empty.
pub const PLDI_NO_CLASS: u16 = 65_535;

const _: () = assert!(
    PLDI_MAX_DETECTIONS == pldi_core::pipeline::MAX_DETECTIONS
        && PLDI_MAX_REJECTED == pldi_core::ground::MAX_CLUSTERS
        && PLDI_MAX_HYPOTHESES == pldi_core::matching::MAX_HYPOTHESES
);

/// A cluster of pixels that stands on the floor. Lengths in mm; the camera frame has x to the right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_cluster {
    /// Its number in the frame.
    pub id: u32,
    /// Number of pixels.
    pub pixels: u32,
    /// Centre of the box around it in the camera frame.
    pub centre_mm: [i32; 3],
    /// Width (across the line of sight), height and depth (along it) of that box.
    pub size_mm: [i32; 3],
    /// First column, first row, last column, last row of its pixels.
    pub bbox: [u16; 4],
}

/// A possible class of an object.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_hypothesis {
    /// Index of the class in the template set, or PLDI_NO_CLASS.
    pub class_id: u16,
    /// Index of the object whose template is nearest.
    pub object: u16,
    /// Number of that template's view.
    pub view: u16,
    /// How much nearer than any other class, in 1/65536: 32768 where two are equally near, 65536 for a perfect fit.
    pub score: u32,
    /// Distance to that template, 0 to 58, in 1/65536.
    pub distance: u32,
    /// Name of the class, in the template file.
    pub class_name: pldi_text,
    /// Name of the object, in the template file.
    pub object_name: pldi_text,
}

/// An object that was found, and what it most likely is.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_detection {
    /// What it most likely is.
    pub best: pldi_hypothesis,
    /// Where it stands.
    pub cluster: pldi_cluster,
}

/// Why a cluster is no object: the first reason that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum pldi_rejection {
    /// Too few pixels to be a surface.
    PLDI_REJECTED_NOISE = 0,
    /// It reaches the border of the sensory area or of the image: only a part of it is seen.
    PLDI_REJECTED_AT_BORDER = 1,
    /// Its footprint or height is below the limits.
    PLDI_REJECTED_TOO_SMALL = 2,
    /// Its footprint is above the limits.
    PLDI_REJECTED_TOO_LARGE = 3,
    /// Another cluster stands in front of it.
    PLDI_REJECTED_OCCLUDED = 4,
}

/// A cluster that is no object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_rejected {
    /// One of pldi_rejection.
    pub reason: u32,
    /// Where it is.
    pub cluster: pldi_cluster,
}

/// The floor plane: points p of the camera frame with normal . p + height = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct pldi_floor {
    /// 1 where the floor was found, else 0; then there are no clusters either.
    pub found: u32,
    /// Unit vector, pointing up, in 2^-30.
    pub normal: [i32; 3],
    /// Height of the camera above the floor in 1/128 mm.
    pub height: i32,
}

/// The objects of the last frame, in the order of their clusters: writes at most `capacity` of them to `detections`, and how many there
/// are to `count` (PLDI_ERROR_ARRAY_SHORT where that is more). `templates` is the set that the frame was processed with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_detections(
    workspace: *const pldi_workspace,
    templates: *const pldi_templates,
    detections: *mut pldi_detection,
    capacity: usize,
    count: *mut usize,
) -> pldi_status {
    let get = || {
        border::apart(workspace, detections, capacity)?;
        border::apart(workspace, count, 1)?;
        // SAFETY: what the header asks for.
        let (workspace, set) = unsafe { (done(workspace)?, pldi_templates::get(templates)?) };
        same(workspace, set)?;
        let report = &workspace.inner().report;
        let all = report.detections.iter().map(|detection| pldi_detection {
            best: hypothesis(detection.hypotheses.first(), set),
            cluster: cluster(detection.cluster, report.clusters.get(usize::from(detection.cluster))),
        });
        // SAFETY: what the header asks for.
        unsafe { border::fill(all, detections, capacity, count) }
    };
    get().into()
}

/// What an object of the last frame may be, best first: one hypothesis a class, at most PLDI_MAX_HYPOTHESES. `detection` is its place
/// among the detections; for none of them, there are no hypotheses. Array, count and templates as in pldi_get_detections.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_hypotheses(
    workspace: *const pldi_workspace,
    templates: *const pldi_templates,
    detection: usize,
    hypotheses: *mut pldi_hypothesis,
    capacity: usize,
    count: *mut usize,
) -> pldi_status {
    let get = || {
        border::apart(workspace, hypotheses, capacity)?;
        border::apart(workspace, count, 1)?;
        // SAFETY: what the header asks for.
        let (workspace, set) = unsafe { (done(workspace)?, pldi_templates::get(templates)?) };
        same(workspace, set)?;
        let detection = workspace.inner().report.detections.get(detection);
        let all = detection.into_iter().flat_map(|detection| &detection.hypotheses);
        // SAFETY: what the header asks for.
        unsafe { border::fill(all.map(|one| hypothesis(Some(one), set)), hypotheses, capacity, count) }
    };
    get().into()
}

/// The clusters of the last frame that are no objects, and why. Array and count as in pldi_get_detections.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_rejected(
    workspace: *const pldi_workspace,
    rejected: *mut pldi_rejected,
    capacity: usize,
    count: *mut usize,
) -> pldi_status {
    let get = || {
        border::apart(workspace, rejected, capacity)?;
        border::apart(workspace, count, 1)?;
        // SAFETY: what the header asks for.
        let workspace = unsafe { done(workspace)? };
        let all = (0..).zip(&workspace.inner().report.clusters).filter_map(|(id, one)| {
            let reason = reason(one.rejection?) as u32;
            Some(pldi_rejected { reason, cluster: cluster(id, Some(one)) })
        });
        // SAFETY: what the header asks for.
        unsafe { border::fill(all, rejected, capacity, count) }
    };
    get().into()
}

/// The floor of the last frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_floor(workspace: *const pldi_workspace, floor: *mut pldi_floor) -> pldi_status {
    let get = || {
        border::apart(workspace, floor, 1)?;
        // SAFETY: what the header asks for.
        let plane = unsafe { done(workspace)? }.inner().report.floor;
        let plane = plane.map_or(pldi_floor { found: 0, normal: [0; 3], height: 0 }, |plane| pldi_floor {
            found: 1,
            normal: plane.normal,
            height: plane.height,
        });
        // SAFETY: what the header asks for.
        unsafe { border::put(floor, plane) }
    };
    get().into()
}

/// The reconstructed depth of the last frame: 320 * 240 values in 1/8 mm, 0 = none. In the workspace: valid until its next frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_depth(workspace: *const pldi_workspace, depth: *mut *const u16) -> pldi_status {
    let get = || {
        border::apart(workspace, depth, 1)?;
        // SAFETY: what the header asks for.
        let image = unsafe { done(workspace)? }.inner().images.depth();
        // SAFETY: what the header asks for.
        unsafe { border::put(depth, image.as_flattened().as_ptr()) }
    };
    get().into()
}

/// N of the last frame's candidates, 65535 = 1, and 0 at all other pixels: 320 * 240 values, or NULL where the frame had no floor. In the
/// workspace: valid until its next frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_get_n(workspace: *const pldi_workspace, n: *mut *const u16) -> pldi_status {
    let get = || {
        border::apart(workspace, n, 1)?;
        // SAFETY: what the header asks for.
        let views = unsafe { done(workspace)? }.inner().images.views();
        let image = views.map_or(core::ptr::null(), |views| views.n.as_flattened().as_ptr());
        // SAFETY: what the header asks for.
        unsafe { border::put(n, image) }
    };
    get().into()
}

/// Why a cluster is no object, in a word or two of English. Never NULL, and never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_rejection_text(reason: u32) -> *const c_char {
    use pldi_rejection::*;
    const TEXTS: [(pldi_rejection, &CStr); 5] = [
        (PLDI_REJECTED_NOISE, c"noise"),
        (PLDI_REJECTED_AT_BORDER, c"at border"),
        (PLDI_REJECTED_TOO_SMALL, c"too small"),
        (PLDI_REJECTED_TOO_LARGE, c"too large"),
        (PLDI_REJECTED_OCCLUDED, c"occluded"),
    ];
    TEXTS
        .iter()
        .find(|(known, _)| *known as u32 == reason)
        .map_or(c"no reason of this library", |(_, text)| text)
        .as_ptr()
}

/// A workspace with results.
///
/// # Safety
/// As [`pldi_workspace::get`].
unsafe fn done<'a>(workspace: *const pldi_workspace) -> Checked<&'a pldi_workspace> {
    // SAFETY: the caller's promise.
    let workspace = unsafe { pldi_workspace::get(workspace)? };
    workspace.expect(State::DONE)?;
    Ok(workspace)
}

/// Indices mean something in the set that they were found in.
fn same(workspace: &pldi_workspace, set: &Templates<'_>) -> Checked<()> {
    if set.checksum() == workspace.templates() { Ok(()) } else { Err(PLDI_ERROR_TEMPLATES_OTHER) }
}

fn hypothesis(hypothesis: Option<&Hypothesis<u32>>, set: &Templates<'_>) -> pldi_hypothesis {
    let (class_id, object, view, score, distance) =
        hypothesis.map_or((PLDI_NO_CLASS, 0, 0, 0, 0), |h| (h.class, h.object, h.view, h.score, h.distance));
    let object_name = if hypothesis.is_some() { set.object_name(object) } else { "" };
    pldi_hypothesis {
        class_id,
        object,
        view,
        score,
        distance,
        class_name: pldi_text::new(set.class_name(class_id)),
        object_name: pldi_text::new(object_name),
    }
}

fn cluster(id: u16, cluster: Option<&Cluster>) -> pldi_cluster {
    // 1/128 mm, rounded to nearest; lengths are below 2^24.
    let mm = |length: i32| length.saturating_add(64) >> 7;
    let cluster = cluster.copied().unwrap_or(Cluster::EMPTY);
    pldi_cluster {
        id: u32::from(id),
        pixels: cluster.pixels,
        centre_mm: cluster.center.map(mm),
        size_mm: cluster.size.map(mm),
        bbox: cluster.bbox,
    }
}

fn reason(rejection: Rejection) -> pldi_rejection {
    match rejection {
        Rejection::Noise => pldi_rejection::PLDI_REJECTED_NOISE,
        Rejection::AtBorder => pldi_rejection::PLDI_REJECTED_AT_BORDER,
        Rejection::TooSmall => pldi_rejection::PLDI_REJECTED_TOO_SMALL,
        Rejection::TooLarge => pldi_rejection::PLDI_REJECTED_TOO_LARGE,
        Rejection::Occluded => pldi_rejection::PLDI_REJECTED_OCCLUDED,
    }
}
