//! Draws what the crate makes: a sheet of every class by eight seeds, and one capture of a generated recording.
//!
//! `cargo run --release -p pldi-fixtures --example contact_sheet -- OUTPUT_FOLDER`

use std::path::PathBuf;
use std::sync::Arc;

use image::RgbImage;
use pldi_fixtures::{
    Capture, Class, Drive, HELD_OUT_SEEDS, Material, Recording, RoomPlan, Sensor, Texture, ViewRing, furniture,
};

/// Side of one picture on the sheet, in pixels.
const CELL: u32 = 160;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    for (name, first) in [("templates", 0), ("held_out", HELD_OUT_SEEDS)] {
        let mut sheet = RgbImage::new(8 * CELL, Class::ALL.len() as u32 * CELL);
        let intrinsics = pldi_core::Intrinsics { width: 160, height: 160, fx: 170.0, fy: 170.0, cx: 79.5, cy: 79.5 };
        let floor = Some(Material::new([190, 190, 190], Texture::Tiles(0.5)));
        for (row, class) in Class::ALL.into_iter().enumerate() {
            for column in 0..8 {
                let mesh = Arc::new(furniture(class, first + column));
                let size = mesh.bounds().map_or(1.0, |b| b.size().into_iter().fold(0.0, f32::max));
                let ring = ViewRing {
                    views: 9,
                    distance: 0.5 + 1.15 * size,
                    height: 0.3 + 0.8 * size,
                    floor,
                    ..ViewRing::default()
                };
                // The view a little to the side of the front.
                let Some((_, capture)) = ring.captures(mesh, Sensor::noise_free(intrinsics), 0).nth(1) else {
                    continue;
                };
                paste(&mut sheet, &capture.colour, 160, [column as u32 * CELL, row as u32 * CELL]);
            }
        }
        sheet.save(folder.join(format!("{name}.png")))?;
    }
    let plan = RoomPlan::generate(3, &Class::ALL, HELD_OUT_SEEDS..HELD_OUT_SEEDS + 100);
    let drive = Recording::new(plan, Sensor::kinect_v1(), Drive::default(), 3);
    captures(&Recording::demo(), &[0, 4, 8, 11]).save(folder.join("demo.png"))?;
    captures(&drive, &[0, 14, 29, 44]).save(folder.join("drive.png"))?;
    Ok(())
}

/// Copies flat colours into the sheet.
fn paste(sheet: &mut RgbImage, colours: &[u8], width: u32, [x, y]: [u32; 2]) {
    for (i, pixel) in colours.chunks_exact(3).enumerate() {
        sheet.put_pixel(x + i as u32 % width, y + i as u32 / width, image::Rgb([pixel[0], pixel[1], pixel[2]]));
    }
}

/// Some frames of a recording one above the other: colour to the left, depth to the right.
fn captures(recording: &Recording, frames: &[usize]) -> RgbImage {
    let mut sheet = RgbImage::new(1280, 480 * frames.len() as u32);
    for (row, frame) in frames.iter().filter_map(|&i| recording.frame(i)).enumerate() {
        paste(&mut sheet, &frame.capture.colour, 640, [0, 480 * row as u32]);
        paste(&mut sheet, &depth_colours(&frame.capture), 640, [640, 480 * row as u32]);
        for t in frame.truth {
            let state = [if t.occluded { "occluded" } else { "" }, if t.cut_by_frame { "cut" } else { "" }];
            println!("{:.1} s: {} {:.2} m, {} px {}", frame.stamp, t.class, t.distance, t.visible, state.join(" "));
        }
    }
    sheet
}

/// Depth as grey: near is bright, no reading dark blue; a ripple of 0.1 m shows the relief.
fn depth_colours(capture: &Capture) -> Vec<u8> {
    let colour = |&d: &u16| match d {
        0 => [0, 0, 70],
        _ => [(255 - (u32::from(d) / 24).min(215)) as u8 - (d % 100 / 4) as u8; 3],
    };
    capture.depth.iter().flat_map(colour).collect()
}
