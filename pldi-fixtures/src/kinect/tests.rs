//! The simulator against what can be worked out by hand.

use std::sync::Arc;

use super::*;
use crate::furniture::{Class, furniture};
use crate::mesh::{Material, Mesh};

const QVGA: pldi_core::Intrinsics = pldi_core::Intrinsics::PRIMESENSE_QVGA;

/// A box of a light colour: extent along x, y, z in metres, its base's middle at x and z.
fn block(size: [f32; 3], x: f32, z: f32) -> Instance {
    let mut mesh = Mesh::new();
    let white = mesh.material(Material::plain([220; 3]));
    mesh.add_block([0.0, 0.0, z], size, white);
    Instance { mesh: Arc::new(mesh), pose: Pose { x, y: 0.0, yaw: 0.0 } }
}

/// A large wall whose face stands `distance` metres before the camera of [`ahead`].
fn wall(distance: f32) -> Instance {
    block([1.0, 30.0, 30.0], distance + 0.5, -15.0)
}

fn scene(instances: Vec<Instance>) -> Scene {
    Scene { instances, ..Scene::default() }
}

/// At the origin, level, 1 m high, looking along +x.
const fn ahead() -> CameraPose {
    CameraPose::new(0.0, 0.0, 0.0, 1.0, 0.0)
}

/// A Kinect that quantises and casts shadows, but does not err.
fn quiet() -> Sensor {
    let model = KinectModel { axial: 0.0, lateral: [0.0; 2], ..KinectModel::default() };
    Sensor { model: Some(model), ..Sensor::kinect_v1() }
}

/// FNV-1a.
fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3))
}

#[test]
fn a_wall_is_as_far_as_it_is() {
    let scene = scene(vec![wall(2.345)]);
    let sensor = Sensor::noise_free(QVGA);
    let capture = sensor.capture(&scene, &ahead(), 0);
    assert!(capture.depth.iter().all(|&d| d == 2345));
    let rendering = sensor.render(&scene, &ahead());
    assert!(rendering.depth.iter().all(|&d| (d - 2.345).abs() < 1e-6));
    // The middle's ray meets the wall head on, the corner's at the angle of the field of view.
    let corner = QVGA.back_project(0.0, 0.0, 1.0);
    let cosine = 1.0 / (1.0 + corner[0] * corner[0] + corner[1] * corner[1]).sqrt();
    assert!((rendering.cosine[0] - cosine).abs() < 1e-5);
    assert!(rendering.cosine[120 * 320 + 160] > 0.99999);
}

#[test]
fn the_floor_is_seen_where_the_rays_meet_it() {
    let floor = Room::floor_only(100.0, Material::plain([128; 3]));
    let scene = Scene { room: Some(floor), ..Scene::default() };
    let camera = CameraPose { roll: 0.1, ..CameraPose::new(1.0, -2.0, 0.7, 1.2, 0.4) };
    let rendering = Sensor::noise_free(QVGA).render(&scene, &camera);
    let (n, h) = camera.floor();
    for (u, v) in [(5u16, 150u16), (160, 120), (300, 230)] {
        let ray = QVGA.back_project(f32::from(u), f32::from(v), 1.0);
        let expected = -h / (n[0] * ray[0] + n[1] * ray[1] + n[2] * ray[2]);
        let found = rendering.depth[usize::from(v) * 320 + usize::from(u)];
        assert!((found - expected).abs() < 1e-4 * expected, "({u}, {v}): {found}, not {expected}");
    }
}

#[test]
fn a_box_covers_the_pixels_its_size_says() {
    // The front face is 0.6 x 0.5 m, 2 m away, its middle straight ahead.
    let instance = block([0.4, 0.6, 0.5], 2.2, 0.75);
    let scene = scene(vec![instance.clone()]);
    let capture = Sensor::noise_free(Sensor::VGA).capture(&scene, &ahead(), 0);
    let count = capture.labels.iter().filter(|&&l| l == 1).count();
    let expected = 571.26 * 571.26 * 0.6 * 0.5 / 4.0;
    assert!((count as f64 - expected).abs() < 0.01 * expected, "{count} pixels, not {expected}");
    assert_eq!(Sensor::noise_free(Sensor::VGA).pixels_alone(&instance, &ahead()), [count, count]);
    // Half beside the image.
    let aside = CameraPose { yaw: libm::atanf(319.5 / 571.26), ..ahead() };
    let [alone, unclipped] = Sensor::noise_free(Sensor::VGA).pixels_alone(&instance, &aside);
    assert!(alone > 0 && 3 * alone < 2 * unclipped);
}

#[test]
fn what_lies_behind_the_camera_is_cut_off() {
    // The camera stands inside a large box: every pixel sees its inner side.
    let rendering = Sensor::noise_free(QVGA).render(&scene(vec![block([4.0, 4.0, 4.0], 0.0, -1.0)]), &ahead());
    assert!(rendering.depth.iter().all(|&d| d > 0.0 && d <= 2.0 + 1e-5));
}

#[test]
fn readings_step_as_the_disparity_does() {
    let mut slanted = wall(3.0);
    slanted.pose.yaw = 0.5;
    let capture = quiet().capture(&scene(vec![slanted]), &ahead(), 0);
    let mut values: Vec<u16> = capture.depth.iter().copied().filter(|&d| d > 0).collect();
    values.sort_unstable();
    values.dedup();
    assert!(values.len() > 50);
    for pair in values.windows(2) {
        let z = 0.5 * (f64::from(pair[0]) + f64::from(pair[1])) / 1000.0;
        let step = f64::from(pair[1] - pair[0]) / 1000.0;
        let expected = z * z / (571.26 * 0.075 * 8.0);
        assert!((step - expected).abs() < 0.0011 + 0.01 * expected, "{step} at {z}, not {expected}");
    }
}

#[test]
fn noise_is_as_large_as_the_model_says() {
    for distance in [1.0, 2.0, 3.0, 4.0] {
        let mut slanted = wall(distance);
        // So that the rounding meets every phase.
        slanted.pose.yaw = 0.1;
        let scene = scene(vec![slanted]);
        let sensor = Sensor::kinect_v1();
        let (capture, truth) = (sensor.capture(&scene, &ahead(), 5), sensor.render(&scene, &ahead()));
        let (mut sum, mut squares, mut n) = (0.0f64, 0.0f64, 0.0f64);
        for (&d, &z) in capture.depth.iter().zip(&truth.depth) {
            if d > 0 {
                let z = f64::from(z);
                let error = (f64::from(d) / 1000.0 - z) / (z * z);
                sum += error;
                squares += error * error;
                n += 1.0;
            }
        }
        assert!(n > 0.98 * 307_200.0, "{n} readings at {distance} m");
        let deviation = (squares / n - (sum / n) * (sum / n)).sqrt();
        assert!((deviation / 1.425e-3 - 1.0).abs() < 0.04, "{deviation} at {distance} m");
        assert!((sum / n).abs() < 1e-4);
    }
}

#[test]
fn shadows_fall_to_the_left_as_wide_as_the_disparities_differ() {
    let (near, far) = (1.5f32, 2.5f32);
    let board = block([0.02, 0.4, 0.8], near + 0.01, 0.6);
    let scene = scene(vec![board, wall(far)]);
    let capture = quiet().capture(&scene, &ahead(), 0);
    let row = 240 * 640..241 * 640;
    let (depth, labels) = (&capture.depth[row.clone()], &capture.labels[row]);
    let first = labels.iter().position(|&l| l == 1).unwrap();
    let last = labels.iter().rposition(|&l| l == 1).unwrap();
    let shadow: Vec<usize> = (0..640).filter(|&u| depth[u] == 0).collect();
    let expected = 571.26 * 0.075 * (1.0 / near - 1.0 / far);
    assert!((shadow.len() as f32 - expected).abs() <= 1.5, "{} columns, not {expected}", shadow.len());
    assert!(shadow.iter().all(|&u| u < first && u + 14 > first) && last > first);
    // A projector on the other side casts them to the right.
    let mut mirrored = quiet();
    mirrored.model = mirrored.model.map(|m| KinectModel { baseline: -0.075, ..m });
    let capture = mirrored.capture(&scene, &ahead(), 0);
    let depth = &capture.depth[240 * 640..241 * 640];
    assert!((0..640).filter(|&u| depth[u] == 0).all(|u| u > last && u < last + 14));
}

#[test]
fn no_reading_comes_from_too_near_too_far_too_flat_or_out_of_the_sun() {
    let share = |sensor: Sensor, scene: &Scene, camera: CameraPose| {
        let depth = sensor.capture(scene, &camera, 1).depth;
        depth.iter().filter(|&&d| d > 0).count() as f32 / depth.len() as f32
    };
    let kinect = Sensor::kinect_v1();
    assert_eq!(share(kinect, &scene(vec![wall(0.45)]), ahead()), 0.0);
    assert!(share(kinect, &scene(vec![wall(0.6)]), ahead()) > 0.98);
    assert_eq!(share(kinect, &scene(vec![wall(8.5)]), ahead()), 0.0);

    let floor = Room::floor_only(60.0, Material::plain([150; 3]));
    let mut bare = Scene { room: Some(floor), ..Scene::default() };
    let down = CameraPose::new(0.0, 0.0, 0.0, 1.2, 0.8);
    assert!(share(kinect, &bare, down) > 0.98);
    // From 0.2 m above, all of the floor beyond 2.5 m is seen at more than 85 degrees.
    let low = CameraPose::new(0.0, 0.0, 0.0, 0.2, 0.0);
    let depth = kinect.capture(&bare, &low, 1).depth;
    assert!(depth.iter().filter(|&&d| d > 3200).count() < 100 && depth.iter().any(|&d| d > 700));

    bare.light.sun = Some(Sun { direction: [0.0, 0.6, 0.8], centre: [1.2, 0.0], half: [5.0, 5.0], yaw: 0.3 });
    assert!(share(kinect, &bare, down) < 0.3);
    assert!(share(Sensor::noise_free(QVGA), &bare, down) > 0.99);
}

#[test]
fn rings_start_in_front_and_turn_counter_clockwise() {
    let ring = ViewRing { views: 4, pitch: Pitch::At(0.2), ..ViewRing::default() };
    let positions = [(2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0)];
    let mesh = Arc::new(furniture(Class::Desk, 1));
    let views: Vec<_> = ring.captures(mesh, Sensor::noise_free(QVGA), 0).collect();
    assert_eq!(views.len(), 4);
    for ((camera, capture), (x, y)) in views.iter().zip(positions) {
        assert!((camera.x - x).abs() < 1e-5 && (camera.y - y).abs() < 1e-5);
        // It looks at the point 0.2 m above the object's foot.
        let target = camera.to_camera([0.0, 0.0, 0.2]);
        assert!(target[0].abs() < 1e-4 && target[1].abs() < 1e-4 && target[2] > 2.0);
        assert!(capture.labels.iter().filter(|&&l| l == 1).count() > 3000);
    }
}

#[test]
fn captures_are_the_same_bits_every_time() {
    let mut scene = Scene::of(Arc::new(furniture(Class::SwivelChair, 3)));
    scene.room = Some(Room::floor_only(12.0, Material::new([170, 120, 80], crate::Texture::Planks(0.1))));
    let camera = CameraPose::new(2.0, 0.5, 3.4, 1.2, 0.3);
    let sensor = Sensor::kinect_v1().with_intrinsics(QVGA);
    let a = sensor.capture(&scene, &camera, 9);
    assert_eq!(a, sensor.capture(&scene, &camera, 9));
    let depth = hash(a.depth.iter().flat_map(|d| d.to_le_bytes()));
    let all = (depth, hash(a.colour.iter().copied()), hash(a.labels.iter().copied()));
    // Another platform, another version: the same numbers. Renew them only with a reason.
    assert_eq!(all, (14_825_784_981_807_423_293, 13_604_224_636_065_998_920, 14_576_612_624_891_934_166));
    assert_ne!(a.depth, sensor.capture(&scene, &camera, 10).depth);
}
