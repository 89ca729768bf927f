use super::*;
use crate::floor::ransac as float;
use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};
use crate::{Error, Intrinsics, rays};

type Depth = Box<Image<u16, W, H>>;

/// A plane, and where it is.
type Part = (crate::Floor, fn([f32; 3]) -> bool);

/// The nearest of some planes along each ray, each where its limit holds; some millimetres of noise.
fn render(planes: &[Part], noise: u32) -> Depth {
    let rays = crate::Rays::<W, H>::new(&Intrinsics::KINECT_QVGA).unwrap();
    let mut depth: Depth = vec![[0u16; W]; H].into_boxed_slice().try_into().unwrap();
    let mut random = Random::new(7);
    for (v, row) in depth.iter_mut().enumerate() {
        for (u, out) in row.iter_mut().enumerate() {
            let mut nearest = 8.0f32;
            for (plane, limit) in planes {
                let [x, y, z] = rays.point(u, v, 1.0);
                let z = -plane.height / (plane.normal[0] * x + plane.normal[1] * y + plane.normal[2] * z);
                if z > 0.0 && z < nearest && limit(rays.point(u, v, z)) {
                    nearest = z;
                    *out = (z * 8000.0) as u16 + random.below(noise as usize + 1).unwrap() as u16;
                }
            }
        }
    }
    depth
}

fn search(depth: &Depth, params: &RansacParams, blocks: usize) -> Option<Floor> {
    let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
    find(depth, &Rays::new(&camera).unwrap(), params, &mut vec![Points::NONE; blocks])
}

fn search_float(depth: &Depth, params: &float::RansacParams) -> Option<crate::Floor> {
    let metres: Vec<[f32; W]> = depth.iter().map(|row| row.map(|z| f32::from(z) / 8000.0)).collect();
    let metres: Box<Image<f32, W, H>> = metres.into_boxed_slice().try_into().unwrap();
    float::find(&metres, &crate::Rays::new(&Intrinsics::KINECT_QVGA).unwrap(), params)
}

#[test]
fn the_floor_is_found_below_a_larger_table_and_before_a_wall_as_in_floats() {
    for (height, pitch, roll, noise) in
        [(1.3, 0.5, 0.05, 0), (0.9, 0.5, -0.1, 16), (2.0, 1.0, 0.0, 40), (1.1, 0.4, 0.2, 16)]
    {
        let floor = crate::Floor::from_pose(height, pitch, roll).unwrap();
        let table = crate::Floor { height: height * 0.45, ..floor };
        let wall = crate::Floor { normal: [0.0, 0.0, -1.0], height: 3.0 };
        let depth = render(&[(floor, |_| true), (table, |p| p[0] > -0.3 && p[2] < 1.4), (wall, |_| true)], noise);
        let found = search(&depth, &RansacParams::DEFAULT, SCRATCH).unwrap().to_float();
        let truth = search_float(&depth, &float::RansacParams::DEFAULT).unwrap();
        assert!((found.height - truth.height).abs() < 4e-3, "{found:?} {truth:?}");
        assert!((0..3).all(|i| (found.normal[i] - truth.normal[i]).abs() < 4e-3), "{found:?} {truth:?}");
        assert!((found.height - height).abs() < 0.01, "{found:?}");
    }
}

#[test]
fn what_is_no_floor_is_not_found() {
    let wall = crate::Floor { normal: [0.0, 0.0, -1.0], height: 2.0 };
    let low = crate::Floor::from_pose(0.1, 0.3, 0.0).unwrap();
    for depth in [render(&[(wall, |_| true)], 0), render(&[], 0), render(&[(low, |_| true)], 0)] {
        assert_eq!(search(&depth, &RansacParams::DEFAULT, SCRATCH), None);
    }
}

#[test]
fn little_scratch_looks_at_fewer_points() {
    let depth = render(&[(crate::Floor::from_pose(1.2, 1.0, 0.0).unwrap(), |_| true)], 8);
    assert_eq!(search(&depth, &RansacParams::DEFAULT, 0), None);
    let params = RansacParams { steep: i32::from(u16::MAX) << 12, ..RansacParams::DEFAULT };
    for blocks in [10, 40, SCRATCH + 5] {
        let found = search(&depth, &params, blocks).unwrap();
        assert!((found.height - 153_600).abs() < 1500, "{blocks}: {found:?}");
    }
}

#[test]
fn extremes_end() {
    let mut random = Random::new(3);
    let mut noise = || -> Depth {
        let mut row = || core::array::from_fn(|_| random.below(65_536).unwrap() as u16);
        (0..H).map(|_| row()).collect::<Vec<[u16; W]>>().into_boxed_slice().try_into().unwrap()
    };
    let wide = Intrinsics { fx: 32.0, fy: 24.0, cx: 640.0, cy: 480.0, ..Intrinsics::KINECT_QVGA };
    let huge = float::RansacParams {
        tolerance: 0.5,
        tolerance_per_z2: 0.5,
        far: 100.0,
        height: (0.01, 10.0),
        ..float::RansacParams::DEFAULT
    };
    for camera in [Intrinsics::KINECT_QVGA, wide] {
        let rays = Rays::new(&rays::fixed::Intrinsics::new(&camera).unwrap()).unwrap();
        for params in [RansacParams::DEFAULT, RansacParams::new(&huge).unwrap()] {
            for depth in [noise(), vec![[u16::MAX; W]; H].into_boxed_slice().try_into().unwrap()] {
                if let Some(floor) = find(&depth, &rays, &params, &mut [Points::NONE; SCRATCH]) {
                    assert_eq!(floor.validate(), Ok(()));
                }
            }
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let good = RansacParams::DEFAULT;
    assert_eq!(good.validate(), Ok(()));
    assert_eq!(RansacParams { samples: 0, ..good }.validate(), Err(Error::OutOfRange("floor: samples")));
    assert_eq!(RansacParams { height: (9, 8), ..good }.validate(), Err(Error::OutOfRange("floor: height")));
    let float = float::RansacParams { support: f32::NAN, ..float::RansacParams::DEFAULT };
    assert_eq!(RansacParams::new(&float), Err(Error::OutOfRange("floor: support")));
}
