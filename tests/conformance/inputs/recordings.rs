//! Generated recordings: the demo, and the drives through rooms that a trial takes.

use pldi_fixtures::Recording;
use pldi_host::input::reduce;
use pldi_host::trial::Trial;

use super::{Scene, W};

/// Rooms of the trial.
pub const ROOMS: u32 = 24;

/// One of the recordings: number 0 is the demo, the others are the trial's rooms, four stops each.
pub fn scenes(number: usize) -> Vec<Scene> {
    let recording = match number.checked_sub(1) {
        None => Recording::demo(),
        Some(room) => Trial { rooms: ROOMS, frames: 4, ..Trial::default() }.recording(room as u32),
    };
    let camera = recording.sensor.intrinsics.reduced(2).expect("VGA is twice QVGA");
    assert_eq!(usize::from(camera.width), W);
    let scene = |(i, frame): (usize, pldi_fixtures::RecordedFrame)| {
        let (depth, colour) = reduce(&frame.capture.depth, &frame.capture.colour, 2);
        let pose = [frame.camera.height, frame.camera.pitch, frame.camera.roll];
        // The costly truths are computed on a frame of each recording.
        let stride = if i == 0 { 3 } else { 0 };
        Scene { camera, depth, colour: Some(colour), pose: Some(pose), shows_floor: true, stride }
    };
    recording.frames().enumerate().map(scene).collect()
}
