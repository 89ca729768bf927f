use super::*;
use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};
use crate::{Intrinsics, diffusion as float, rays};

type Depth = Box<Image<u16, W, H>>;
type N = Box<Image<u16, W, H>>;

fn image(f: impl Fn(usize, usize) -> u16) -> Depth {
    let rows: Vec<[u16; W]> = (0..H).map(|v| core::array::from_fn(|u| f(u, v))).collect();
    rows.into_boxed_slice().try_into().unwrap()
}

fn fixed_rays(camera: &Intrinsics) -> Rays<W, H> {
    Rays::new(&rays::fixed::Intrinsics::new(camera).unwrap()).unwrap()
}

fn both(camera: &Intrinsics, depth: &Depth, radius: u16, wanted: impl Fn(usize, usize) -> bool + Copy) -> [N; 2] {
    let mut fixed = image(|_, _| 1);
    diffusion(depth, &fixed_rays(camera), radius, [0..=W - 1, 0..=H - 1], wanted, &mut fixed);
    let metres: Vec<[f32; W]> = depth.iter().map(|row| row.map(|z| f32::from(z) / 8000.0)).collect();
    let metres: Box<Image<f32, W, H>> = metres.into_boxed_slice().try_into().unwrap();
    let mut truth = image(|_, _| 1);
    let rays = crate::Rays::new(camera).unwrap();
    float::diffusion(&metres, &rays, f32::from(radius) / 8000.0, wanted, &mut truth);
    [fixed, truth]
}

/// Share of the pixels with N in either that differ by more than 1/128, and the root mean square error.
fn errors([fixed, float]: &[N; 2]) -> (f64, f64) {
    let pairs = fixed.iter().flatten().zip(float.iter().flatten()).filter(|(a, b)| **a > 0 || **b > 0);
    let e: Vec<f64> = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)) / 65_535.0).collect();
    let far = e.iter().filter(|e| e.abs() > 1.0 / 128.0).count();
    (far as f64 / e.len() as f64, (e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt())
}

/// A room: floor, wall, a ball before it, holes and noise.
fn room(camera: &Intrinsics, noise: u32) -> Depth {
    let mut state = 1u32;
    let rough = core::cell::RefCell::new(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    });
    image(|u, v| {
        let [x, y, _] = camera.back_project(u as f32, v as f32, 1.0);
        let slanted = 2.9 / (1.0 + 0.4 * x);
        let floor = if y > 0.05 { 0.9 / y } else { 9.0 };
        let (a, b, c) = (x * x + y * y + 1.0, -2.0 * (1.4 + 0.3 * x), 1.4 * 1.4 + 0.09 - 0.16);
        let root = b * b - 4.0 * a * c;
        let ball = if root > 0.0 { (-b - root.sqrt()) / (2.0 * a) } else { 9.0 };
        let z = slanted.min(floor).min(ball);
        let random = (rough.borrow_mut())();
        if random % 23 == 0 { 0 } else { (z * 8000.0) as u16 + ((random >> 8) % (noise + 1)) as u16 }
    })
}

#[test]
fn a_room_is_as_in_floats() {
    let camera = Intrinsics::KINECT_QVGA;
    for (radius, noise) in [(320, 0), (320, 40), (160, 16), (800, 40)] {
        let images = both(&camera, &room(&camera, noise), radius, |u, v| v % 5 == 0 && u != 7);
        assert!(images[0].iter().enumerate().all(|(v, row)| row[7] == 0 && (v % 5 == 0 || row == &[0; W])));
        let (far, rms) = errors(&images);
        assert!(far < 0.004 && rms < 0.002, "{radius} {noise}: {far} {rms}");
    }
}

#[test]
fn a_fronto_parallel_plane_gives_the_cosine_of_the_rays_angle() {
    let camera = Intrinsics::KINECT_QVGA;
    for z in [3000, 16_000, 60_000, 65_535] {
        let images = both(&camera, &image(|_, _| z), 320, |_, v| v % 16 == 0);
        for (a, b) in images[0].iter().flatten().zip(images[1].iter().flatten()) {
            assert!(a.abs_diff(*b) <= 24, "{z}: {a} {b}");
        }
    }
}

#[test]
fn extremes_end() {
    let wide = Intrinsics { fx: 32.0, fy: 24.0, cx: 640.0, cy: 480.0, ..Intrinsics::KINECT_QVGA };
    let long = Intrinsics { fx: 30_000.0, fy: 24_000.0, ..Intrinsics::KINECT_QVGA };
    for camera in [Intrinsics::KINECT_QVGA, wide, long] {
        let rays = fixed_rays(&camera);
        for radius in [0, 40, 320, 4000, u16::MAX] {
            for kind in 0..4 {
                let depth = image(|u, v| match kind {
                    0 => 0,
                    1 => u16::MAX,
                    2 => radius.clamp(40, 4000) + 20,
                    _ => ((u * 7919 + v * 104_729) * 31 % 65_536) as u16,
                });
                let mut n = image(|_, _| 1);
                diffusion(&depth, &rays, radius, [0..=W - 1, 0..=H - 1], |u, v| u % 97 < 3 && v % 60 == 1, &mut n);
                assert!(kind > 0 || n.iter().flatten().all(|n| *n == 0));
            }
        }
    }
}

#[test]
fn too_few_neighbours_give_no_normal() {
    let camera = Intrinsics::KINECT_QVGA;
    let row = both(&camera, &image(|_, v| if v == 120 { 8000 } else { 0 }), 320, |_, v| (118..123).contains(&v));
    assert!(row[0].iter().flatten().all(|n| *n == 0));
    let alone = both(&camera, &image(|u, v| if (u, v) == (9, 9) { 8000 } else { 0 }), 320, |_, _| true);
    assert!(alone[0].iter().flatten().all(|n| *n == 0));
}

#[test]
fn cosines_are_right() {
    for normal in [[1 << 28, 0, 0], [-(1 << 28), 5000, 1 << 27], [3, -(1 << 29), 1 << 20], [1 << 20, 12_345, 1 << 29]] {
        for (x, y) in [(0, 0), (40_000_000, -30_000_000), (i32::MAX, i32::MIN), (5, 0)] {
            let (n, v) = (normal.map(f64::from), [f64::from(x), f64::from(y), 67_108_864.0]);
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let truth = dot(n, v).abs() / (dot(n, n) * dot(v, v)).sqrt() * 65_535.0;
            assert!((f64::from(cosine(normal, x, y)) - truth).abs() < 1.3, "{normal:?} {x} {y}: {truth}");
        }
    }
}
