use super::*;
use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};
use crate::{Intrinsics, floor, rays};
use proptest::prelude::*;

type Depth = Box<Image<u16, W, H>>;

/// A floor, a wall and perhaps a table in front of it, with noise that grows with the square of the depth.
fn room(floor: &crate::Floor, wall: f32, table: bool, noise: f32) -> Depth {
    let rays = crate::Rays::<W, H>::new(&Intrinsics::KINECT_QVGA).unwrap();
    let axes = floor.axes();
    let mut depth: Depth = vec![[0u16; W]; H].into_boxed_slice().try_into().unwrap();
    let mut random = Random::new(7);
    for (v, row) in depth.iter_mut().enumerate() {
        for (u, out) in row.iter_mut().enumerate() {
            let ray = rays.point(u, v, 1.0);
            let [right, forward, up] = axes.to_floor(ray);
            let fall = floor.height - up;
            let mut z = if forward > 0.0 { wall / forward } else { 9.0 };
            if fall > 0.0 {
                z = z.min(floor.height / fall);
                let top = (floor.height - 0.7) / fall;
                if table && (right * top).abs() < 0.5 && (1.2..2.0).contains(&(forward * top)) {
                    z = top;
                }
            }
            let error: f32 = (0..12).map(|_| random.below(1000).unwrap() as f32 / 1000.0).sum::<f32>() - 6.0;
            *out = ((z + noise * z * z * error) * 8000.0) as u16;
        }
    }
    depth
}

fn search(depth: &Image<u16, W, H>) -> [Option<crate::Floor>; 2] {
    let params = floor::RansacParams::DEFAULT;
    let camera = Intrinsics::KINECT_QVGA;
    let metres: Vec<[f32; W]> = depth.iter().map(|row| row.map(|z| f32::from(z) / 8000.0)).collect();
    let metres: Box<Image<f32, W, H>> = metres.into_boxed_slice().try_into().unwrap();
    let float = floor::ransac::find(&metres, &crate::Rays::new(&camera).unwrap(), &params);
    let rays = Rays::new(&rays::fixed::Intrinsics::new(&camera).unwrap()).unwrap();
    let mut room = [Point { position: [0; 3], tolerance: 0 }; MAX_POINTS];
    let fixed = find(depth, &rays, &RansacParams::new(&params).unwrap(), &mut room);
    [float, fixed.map(|floor| floor.to_float())]
}

#[test]
fn walls_and_nothing_are_no_floor() {
    for depth in [0, 1, 16_000, u16::MAX] {
        assert_eq!(search(&[[depth; W]; H]), [None; 2], "{depth}");
    }
}

#[test]
fn little_room_is_no_panic() {
    let floor = crate::Floor::from_pose(1.2, 0.4, 0.0).unwrap();
    let rays = Rays::new(&rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap()).unwrap();
    let params = RansacParams::new(&floor::RansacParams::DEFAULT).unwrap();
    for points in [0, 1, 2, 40] {
        let mut room_ = vec![Point { position: [0; 3], tolerance: 0 }; points];
        let _ = find(&room(&floor, 3.0, false, 0.0), &rays, &params, &mut room_);
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let float = floor::RansacParams { samples: 0, ..floor::RansacParams::DEFAULT };
    assert_eq!(RansacParams::new(&float), Err(Error::OutOfRange("floor: samples")));
    let float = floor::RansacParams { tilt: f32::NAN, ..floor::RansacParams::DEFAULT };
    assert_eq!(RansacParams::new(&float), Err(Error::OutOfRange("floor: tilt")));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_same_floor_is_found_as_in_floats(
        height in 0.4f32..1.8, pitch in 0.1f32..0.7, roll in -0.2f32..0.2, wall in 2.0f32..5.0,
        table in any::<bool>(), noise in 0.0f32..0.0015,
    ) {
        let truth = crate::Floor::from_pose(height, pitch, roll).unwrap();
        let [float, fixed] = search(&room(&truth, wall, table, noise));
        prop_assert_eq!(float.is_some(), fixed.is_some());
        if let (Some(float), Some(fixed)) = (float, fixed) {
            prop_assert!((float.height - fixed.height).abs() < 0.003, "{float:?} {fixed:?}");
            let cosine: f32 = (0..3).map(|i| float.normal[i] * fixed.normal[i]).sum();
            prop_assert!(cosine > 0.999_99, "{float:?} {fixed:?}");
        }
    }
}
