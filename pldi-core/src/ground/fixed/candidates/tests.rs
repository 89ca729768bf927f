use super::*;
use crate::floor::fixed::Floor;
use crate::ground::border::{find, point_count};
use crate::ground::fixed::{AreaParams, DensityParams, density};
use crate::ground::{self, MAP_DEPTH, MAP_WIDTH, MAX_CONTOUR_POINTS, density as float_density};
use proptest::prelude::*;

const W: usize = 320;
const H: usize = 240;

fn boxed<T: Copy, const W: usize, const H: usize>(value: T) -> Box<Image<T, W, H>> {
    vec![[value; W]; H].into_boxed_slice().try_into().ok().unwrap()
}

/// A camera and a floor in both arithmetics.
struct Setting {
    rays: Rays<W, H>,
    axes: FloorAxes,
    area: SensoryArea,
    density: DensityParams,
    limits: Limits,
    float: (crate::Rays<W, H>, crate::FloorAxes, ground::SensoryArea),
}

fn setting(pitch: f32, roll: f32) -> Setting {
    let camera = crate::Intrinsics::PRIMESENSE_QVGA;
    let fixed_camera = crate::rays::fixed::Intrinsics::new(&camera).unwrap();
    let float_floor = crate::Floor::from_pose(1.2, pitch, roll).unwrap();
    let normal = float_floor.normal.map(|v| (f64::from(v) * 1_073_741_824.0) as i32);
    let floor = Floor { normal, height: 153_600 };
    let params = ground::AreaParams::DEFAULT;
    Setting {
        rays: Rays::new(&fixed_camera).unwrap(),
        axes: floor.axes(),
        area: SensoryArea::new(&AreaParams::new(&params).unwrap(), &fixed_camera, &floor),
        density: DensityParams::new(&ground::DensityParams::DEFAULT).unwrap(),
        limits: Limits::new(&ground::Limits::DEFAULT).unwrap(),
        float: (
            crate::Rays::new(&camera).unwrap(),
            float_floor.axes(),
            ground::SensoryArea::new(&params, &camera, &float_floor),
        ),
    }
}

/// The depth of the floor and of upright boxes on it (right, forward, half width, height in metres).
fn scene(setting: &Setting, boxes: &[[f32; 4]]) -> Box<Image<u16, W, H>> {
    let (rays, axes, _) = &setting.float;
    let mut depth = boxed(0u16);
    for v in 0..H {
        for u in 0..W {
            let [right, forward, drop] = axes.to_floor(rays.point(u, v, 1.0));
            let drop = drop - axes.floor.height;
            let mut z = if drop < 0.0 { -axes.floor.height / drop } else { 0.0 };
            for [x, y, half, height] in boxes {
                let front = y / forward;
                let h = axes.floor.height + drop * front;
                if (right * front - x).abs() < *half && (0.0..*height).contains(&h) && (z == 0.0 || front < z) {
                    z = front;
                }
            }
            depth[v][u] = (z * 8000.0 + 0.5) as u16;
        }
    }
    depth
}

struct Found {
    counts: Box<Map<u16>>,
    density: Box<Map<u16>>,
    labels: Box<Image<u8, W, H>>,
    contours: Vec<Contour>,
    clusters: Vec<Cluster>,
}

fn fixed(s: &Setting, depth: &Image<u16, W, H>) -> Found {
    let (mut counts, mut density, mut labels) = (boxed(0), boxed(0), boxed(0));
    let (mut marks, mut map_labels) = (boxed(0), boxed(0));
    density::project(depth, &s.rays, &s.axes, &s.area, &s.density, &mut labels, &mut counts);
    density::spread(&counts, &s.density, s.rays.intrinsics().fx, &mut density);
    density::occupied(&density, s.density.threshold, &mut marks);
    let (mut contours, mut points) = (heapless::Vec::new(), vec![ContourPoint::default(); MAX_CONTOUR_POINTS]);
    find(&mut marks, &mut map_labels, &mut contours, &mut points).unwrap();
    points.truncate(point_count(&contours));
    let mut clusters = vec![Cluster::EMPTY; contours.len()];
    gather(depth, &s.rays, &s.axes, &map_labels, &mut labels, &mut clusters);
    judge::<W, H>(&mut clusters, &contours, &points, &map_labels, &s.axes, &s.area, &s.limits);
    Found { counts, density, labels, contours: contours.to_vec(), clusters }
}

struct FloatFound {
    counts: Box<Map<f32>>,
    density: Box<Map<f32>>,
    labels: Box<Image<u16, W, H>>,
    contours: Vec<Contour>,
    clusters: Vec<ground::Cluster>,
}

fn float(s: &Setting, depth: &Image<u16, W, H>) -> FloatFound {
    let (rays, axes, area) = &s.float;
    let (params, limits) = (ground::DensityParams::DEFAULT, ground::Limits::DEFAULT);
    let mut metres = boxed(0.0f32);
    for (to, from) in metres.as_flattened_mut().iter_mut().zip(depth.as_flattened()) {
        *to = f32::from(*from) / 8000.0;
    }
    let (mut counts, mut density, mut labels) = (boxed(0.0), boxed(0.0), boxed(0));
    let (mut marks, mut map_labels) = (boxed(0), boxed(0));
    float_density::project(&metres, rays, axes, area, &params, &mut labels, &mut counts);
    float_density::spread(&counts, &params, rays.intrinsics().fx, &float_density::Gaussian::new(), &mut density);
    float_density::occupied(&density, params.threshold, &mut marks);
    let (mut contours, mut points) = (heapless::Vec::new(), vec![ContourPoint::default(); MAX_CONTOUR_POINTS]);
    find(&mut marks, &mut map_labels, &mut contours, &mut points).unwrap();
    let mut clusters = vec![ground::Cluster::EMPTY; contours.len()];
    ground::candidates::gather(&mut labels, &map_labels, &metres, rays, axes, &mut clusters);
    ground::candidates::judge::<W, H>(&mut clusters, &contours, &points, &map_labels, axes, area, &limits);
    FloatFound { counts, density, labels, contours: contours.to_vec(), clusters }
}

fn near(fixed: i32, float: f32, tolerance: f32) -> bool {
    (fixed as f32 / 128_000.0 - float).abs() <= tolerance
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Everything that the two arithmetics find in a scene of two boxes. Fronts stand half a centimetre behind the front of
    /// a row of cells, so that none of them lies on the border between cells.
    #[test]
    fn scenes_agree_with_the_float_stages(
        pitch in 0.1f32..0.6, x in -0.6f32..0.6, row in 70u8..150, half in 0.1f32..0.4, height in 0.3f32..1.4,
    ) {
        let s = setting(pitch, 0.0);
        let y = f32::from(row) * 0.02 + 0.005;
        let depth = scene(&s, &[[x, y, half, height], [x + 0.5, y + 0.6, 0.2, 0.9]]);
        let (fixed, float) = (fixed(&s, &depth), float(&s, &depth));
        let different = fixed.labels.as_flattened().iter().zip(float.labels.as_flattened()).filter(|(a, b)| u16::from(**a) != **b);
        prop_assert!(different.count() <= W * H / 1000);
        for (row, (a, b)) in fixed.counts.iter().zip(float.counts.iter()).enumerate() {
            let unit = if row < density::FAR_ROW { 256.0 } else { 128.0 };
            let sums = (a.iter().map(|c| f32::from(*c) / unit).sum::<f32>(), b.iter().map(|c| c.min(65_535.0 / unit)).sum::<f32>());
            prop_assert!((sums.0 - sums.1).abs() <= 0.03 * sums.1 + 8.0, "{row}: {sums:?}");
        }
        let off = fixed.density.as_flattened().iter().zip(float.density.as_flattened()).filter(|(a, b)| {
            let b = b.min(65_535.0 / 1024.0);
            // A step of the Gaussian's table is 6 %; a whole front may stand just there.
            (f32::from(**a) / 1024.0 - b).abs() > 0.07 * b + 0.02
        });
        prop_assert!(off.count() <= MAP_WIDTH * MAP_DEPTH / 1000);
        prop_assert_eq!(fixed.clusters.len(), float.clusters.len());
        for i in 0..fixed.clusters.len() {
            let (a, b) = (&fixed.clusters[i], &float.clusters[i]);
            // A cell may be just above the threshold in one of them only.
            if a.pixels != b.pixels || a.pixels < 60 || fixed.contours[i].cells != float.contours[i].cells {
                continue;
            }
            prop_assert_eq!(a.bbox, b.bbox);
            prop_assert_eq!(a.rejection, b.rejection);
            prop_assert!(near(a.top, b.top, 2e-4), "{a:?} {b:?}");
            prop_assert!((0..2).all(|i| near(a.centroid[i], b.centroid[i], 1e-3)), "{a:?} {b:?}");
            prop_assert!((0..3).all(|i| near(a.center[i], b.center[i], 1e-3)), "{a:?} {b:?}");
            prop_assert!((0..3).all(|i| near(a.size[i], b.size[i], 1e-3)), "{a:?} {b:?}");
        }
    }

    /// Whatever the depth and the floor: no overflow, and the sums add up.
    #[test]
    fn any_depth_and_any_floor(
        seed in any::<u32>(), normal in proptest::array::uniform3(any::<i32>()), height in any::<i32>(), full in any::<bool>(),
    ) {
        let mut s = setting(0.3, 0.0);
        s.axes.floor = Floor { normal, height: height >> 2 };
        let mut depth = boxed(u16::MAX);
        if !full {
            let mut state = seed;
            for z in depth.as_flattened_mut() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *z = (state >> 16) as u16;
            }
        }
        let (mut counts, mut density, mut labels, map_labels) = (boxed(0), boxed(0), boxed(0), boxed(1));
        density::project(&depth, &s.rays, &s.axes, &s.area, &s.density, &mut labels, &mut counts);
        density::spread(&counts, &s.density, s.rays.intrinsics().fx, &mut density);
        let mut clusters = [Cluster::EMPTY];
        gather(&depth, &s.rays, &s.axes, &map_labels, &mut labels, &mut clusters);
        prop_assert_eq!(clusters[0].pixels as usize, labels.as_flattened().iter().filter(|l| **l == 1).count());
        gather_mask(&depth, &s.rays, &s.axes, |_, _| true, &mut labels, &mut clusters);
        prop_assert_eq!(clusters[0].pixels as usize, depth.as_flattened().iter().filter(|z| **z != 0).count());
    }
}

#[test]
fn a_mask_gathers_what_it_covers() {
    let s = setting(0.3, 0.1);
    let depth = scene(&s, &[[0.2, 2.005, 0.3, 0.8]]);
    let (mut labels, mut clusters) = (boxed(9), [Cluster::EMPTY]);
    gather_mask(&depth, &s.rays, &s.axes, |u, v| u > 100 && v < 200, &mut labels, &mut clusters);
    let (rays, axes, _) = &s.float;
    let (mut sum, mut count) = ([0.0f64; 2], 0);
    for v in 0..200 {
        for u in 101..W {
            if depth[v][u] != 0 {
                let q = axes.to_floor(rays.point(u, v, f32::from(depth[v][u]) / 8000.0));
                (sum, count) = ([sum[0] + f64::from(q[0]), sum[1] + f64::from(q[1])], count + 1);
                assert_eq!(labels[v][u], 1);
            }
        }
    }
    assert_eq!((clusters[0].pixels, labels[10][100], labels[230][200]), (count, 0, 0));
    for (got, sum) in clusters[0].centroid.iter().zip(sum) {
        assert!(near(*got, (sum / f64::from(count)) as f32, 1e-4), "{:?}", clusters[0]);
    }
}

#[test]
fn an_empty_image_has_no_pixels() {
    let s = setting(0.3, 0.0);
    let found = fixed(&s, &boxed(0));
    assert!(found.clusters.is_empty() && found.density.as_flattened().iter().all(|d| *d == 0));
}

#[test]
fn limits_out_of_range_are_named() {
    let good = ground::Limits::DEFAULT;
    let bad = [
        (ground::Limits { area: (2.0, 1.0), ..good }, "limits: area"),
        (ground::Limits { length: (0.0, f32::NAN), ..good }, "limits: length"),
        (ground::Limits { hidden: 1.5, ..good }, "limits: hidden"),
    ];
    for (limits, name) in bad {
        assert_eq!(Limits::new(&limits), Err(Error::OutOfRange(name)));
    }
    assert_eq!(size_of::<Contour>(), 12);
}
