//! Surfaces given by formulas: exact, and as a sensor measures them.

use super::{H, Scene, W};
use crate::common::{BENCH, Block, CHAIR, CHEST, Random, Room};
use pldi_core::Intrinsics;

/// The camera of all scenes: off-centre, pixels not quite square.
pub const CAMERA: Intrinsics = Intrinsics { width: 320, height: 240, fx: 285.63, fy: 283.1, cx: 161.2, cy: 117.9 };

/// The pose assumed where a scene has none of its own.
const POSE: [f32; 3] = [1.2, 0.4, 0.05];

/// Builds a scene from the depth in metres and the colour at each pixel's ray (x, y, 1).
fn build(
    surface: impl Fn(f64, f64) -> (f64, [f64; 3]),
    mut measure: impl FnMut(f64, [f64; 3]) -> (u16, [u8; 3]),
) -> Scene {
    let (mut depth, mut colours) = (Vec::new(), Vec::new());
    for v in 0..H {
        for u in 0..W {
            let x = (u as f64 - f64::from(CAMERA.cx)) / f64::from(CAMERA.fx);
            let y = (v as f64 - f64::from(CAMERA.cy)) / f64::from(CAMERA.fy);
            let (z, colour) = surface(x, y);
            let (z, colour) = measure(z, colour);
            depth.push(z);
            colours.extend(colour);
        }
    }
    Scene { camera: CAMERA, depth, colour: Some(colours), pose: Some(POSE), shows_floor: false, stride: 1 }
}

/// The surface as it is, to the nearest mm.
fn exact(surface: impl Fn(f64, f64) -> (f64, [f64; 3])) -> Scene {
    build(surface, |z, colour| ((z * 1000.0 + 0.5) as u16, colour.map(|c| c.clamp(0.0, 255.0) as u8)))
}

/// The surface as it is measured: noise and steps of depth that grow with z^2, missing readings, sentinels.
fn scene(seed: u64, surface: impl Fn(f64, f64) -> (f64, [f64; 3])) -> Scene {
    let mut random = Random(seed);
    let mut out = build(surface, |z, colour| {
        let z = measured(z, &mut random);
        (z, colour.map(|c| (c + 2.0 * random.normal()).clamp(0.0, 255.0) as u8))
    });
    holes(&mut out, &mut random);
    out
}

/// What a sensor makes of a depth in metres.
fn measured(z: f64, random: &mut Random) -> u16 {
    let step = 2.85e-3 * z * z;
    let noisy = z + 1.0e-3 * z * z * random.normal();
    let z = if step > 0.0 { libm::round(noisy / step) * step } else { 0.0 };
    match random.bits() % 200 {
        0 | 1 => 0,
        2 => 65_535,
        _ if (0.3..9.5).contains(&z) => (z * 1000.0 + 0.5) as u16,
        _ => 0,
    }
}

/// Round and square regions without readings, as dark or shining things have, and shadows right of steps.
fn holes(scene: &mut Scene, random: &mut Random) {
    for i in 0..6 {
        let (cu, cv, r) = (random.between(0.0, 320.0), random.between(0.0, 240.0), random.between(2.0, 24.0));
        for v in 0..H {
            for u in 0..W {
                let (du, dv) = ((u as f64 - cu).abs(), (v as f64 - cv).abs());
                if if i % 2 == 0 { du * du + dv * dv < r * r } else { du.max(dv) < r } {
                    scene.depth[v * W + u] = 0;
                }
            }
        }
    }
    for v in 0..H {
        let mut shadow = 0;
        for u in 1..W {
            let (left, here) = (scene.depth[v * W + u - 1], scene.depth[v * W + u]);
            if left > 0 && here > left.saturating_add(150) && here < 10_000 {
                shadow = 5;
            }
            if shadow > 0 {
                shadow -= 1;
                scene.depth[v * W + u] = 0;
            }
        }
    }
}

/// Slanted planes that meet in edges, under a texture that has nothing to do with them.
fn planes() -> Scene {
    scene(1, |x, y| {
        let planes = [(0.5, 0.1, 0.85, 1.4), (-0.6, 0.0, 0.8, 1.5), (0.1, 0.75, 0.65, 1.1)];
        let z = planes.map(|(a, b, c, d)| d / (a * x + b * y + c));
        let near = z.into_iter().filter(|z| *z > 0.0).fold(4.0, f64::min);
        let texture = 60.0 * libm::sin(31.0 * x) * libm::sin(23.0 * y);
        (near, [128.0 + texture, 120.0 + 0.5 * texture, 110.0 - texture])
    })
}

/// Steps of 3 cm to 1 m between planes that face the camera, with edges of colour on some of them.
fn steps() -> Scene {
    scene(2, |x, y| {
        let column = libm::floor((x + 0.6) * 6.0);
        let row = libm::floor((y + 0.5) * 5.0);
        let z = 1.0 + 0.03 * column * column + 0.25 * (row + column).rem_euclid(3.0);
        let bright = if row.rem_euclid(2.0) < 1.0 { 70.0 * column.rem_euclid(3.0) } else { 100.0 };
        (z, [bright, bright + 20.0, 180.0 - bright])
    })
}

/// A sphere before a wall that slants.
fn sphere() -> Scene {
    scene(3, |x, y| {
        let (a, b, c) = (x * x + y * y + 1.0, -2.0 * (0.1 * x + 1.6), 0.1 * 0.1 + 1.6 * 1.6 - 0.5 * 0.5);
        let root = b * b - 4.0 * a * c;
        let wall = 2.6 / (1.0 - 0.2 * x);
        if root > 0.0 {
            let z = (-b - root.sqrt()) / (2.0 * a);
            let light = 80.0 + 250.0 * (1.6 - z);
            (z, [light, 0.6 * light, 0.5 * light])
        } else {
            (wall, [170.0 + 40.0 * x, 170.0, 165.0])
        }
    })
}

/// A plane that faces the camera, 1.5 m away.
fn facing() -> Scene {
    exact(|_, _| (1.5, [120.0; 3]))
}

/// A plane that leans to one side and back.
fn slanted() -> Scene {
    exact(|x, y| (1.6 / (0.9 + 0.35 * x - 0.25 * y), [90.0, 140.0, 60.0]))
}

/// A ball before nothing.
fn ball() -> Scene {
    exact(|x, y| {
        let (a, b, c) = (x * x + y * y + 1.0, -2.0 * 1.7, 1.7 * 1.7 - 0.6 * 0.6);
        let root = b * b - 4.0 * a * c;
        (if root > 0.0 { (-b - root.sqrt()) / (2.0 * a) } else { 0.0 }, [200.0, 40.0, 40.0])
    })
}

/// An upright column before a wall.
fn column() -> Scene {
    exact(|x, _| {
        let (a, b, c) = (x * x + 1.0, -2.0 * (0.2 * x + 1.5), 0.2 * 0.2 + 1.5 * 1.5 - 0.25 * 0.25);
        let root = b * b - 4.0 * a * c;
        if root > 0.0 { ((-b - root.sqrt()) / (2.0 * a), [220.0; 3]) } else { (2.5, [60.0; 3]) }
    })
}

/// A step of 10 cm that colour does not show.
fn step() -> Scene {
    exact(|x, y| (if x + 0.2 * y > 0.05 { 1.3 } else { 1.4 }, [128.0; 3]))
}

/// What a room's camera sees, with noise or without.
fn room_scene(room: &Room<'_>, seed: u64) -> Scene {
    let shot = room.shoot(&CAMERA, seed);
    let pose = [room.height as f32, room.pitch as f32, 0.0];
    Scene {
        camera: CAMERA,
        depth: shot.depth,
        colour: Some(shot.colour),
        pose: Some(pose),
        shows_floor: true,
        stride: 1,
    }
}

/// A room with furniture, and pixels that lost their reading.
fn furniture() -> Scene {
    let mut out = room_scene(&rooms()[1], 4);
    holes(&mut out, &mut Random(44));
    out
}

/// The frames: exact ones, then measured ones, then rooms.
pub const SCENES: &[fn() -> Scene] = &[
    facing,
    slanted,
    ball,
    column,
    step,
    || room_scene(&Room { noise: 0.0, ..rooms()[0] }, 1),
    planes,
    steps,
    sphere,
    furniture,
    || room_scene(&rooms()[0], 7),
    || room_scene(&rooms()[1], 8),
    || room_scene(&rooms()[2], 9),
];

/// Rooms with one object each.
pub fn rooms() -> [Room<'static>; 3] {
    let room = |object: &'static [Block], at, pitch| Room { height: 1.2, pitch, wall: 3.7, at, object, noise: 1.4e-3 };
    [room(CHEST, [-0.2, 2.1], 0.4), room(CHAIR, [0.3, 1.8], 0.45), room(BENCH, [0.0, 2.4], 0.3)]
}
