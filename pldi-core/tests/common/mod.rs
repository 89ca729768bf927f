//! What several tests look at: rooms whose depth and colour are computed ray by ray, and a small random generator.
#![allow(dead_code, reason = "not every test needs all of it")]

pub mod pldt;

use pldi_core::Intrinsics;

/// SplitMix64: the same numbers on every machine.
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly distributed in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Evenly distributed between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// About normally distributed: mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// A box, as seen from above: its own centre at (0, 0), to the right and forward.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// Centre on the floor, right and forward, in metres from the object's middle.
    pub at: [f64; 2],
    /// Width, depth in metres.
    pub size: [f64; 2],
    /// Height of the lower and the upper side above the floor in metres.
    pub height: [f64; 2],
}

/// A floor, a wall straight ahead, and an object made of boxes.
#[derive(Debug, Clone, Copy)]
pub struct Room<'a> {
    /// Height of the camera above the floor in metres.
    pub height: f64,
    /// How far the camera looks down, in radians.
    pub pitch: f64,
    /// Distance of the wall along the floor in metres.
    pub wall: f64,
    /// Where the object stands, right and forward in metres.
    pub at: [f64; 2],
    /// The object's parts.
    pub object: &'a [Block],
    /// Standard deviation of the depth: this times z^2 (per metre).
    pub noise: f64,
}

/// A room as a camera sees it.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Depth in mm, row by row.
    pub depth: Vec<u16>,
    /// Red, green, blue, row by row.
    pub colour: Vec<u8>,
    /// Whether the pixel shows the object.
    pub object: Vec<bool>,
}

impl Room<'_> {
    /// The room seen by a camera that is level but for the pitch.
    pub fn shoot(&self, camera: &Intrinsics, seed: u64) -> Shot {
        let pixels = usize::from(camera.width) * usize::from(camera.height);
        let mut shot = Shot {
            depth: Vec::with_capacity(pixels),
            colour: Vec::with_capacity(3 * pixels),
            object: Vec::with_capacity(pixels),
        };
        let mut random = Random(seed);
        let (sin, cos) = libm::sincos(self.pitch);
        for v in 0..camera.height {
            for u in 0..camera.width {
                let x = (f64::from(u) - f64::from(camera.cx)) / f64::from(camera.fx);
                let y = (f64::from(v) - f64::from(camera.cy)) / f64::from(camera.fy);
                // Right, forward and up, per metre of depth.
                let ray = [x, cos - y * sin, -sin - y * cos];
                let (z, object) = self.hit(ray);
                let noisy = z + self.noise * z * z * random.normal();
                shot.depth.push(if noisy < 9.9 { (noisy * 1000.0 + 0.5) as u16 } else { 0 });
                shot.object.push(object);
                shot.colour.extend(self.colour(ray, z, object));
            }
        }
        shot
    }

    /// Depth along a ray, and whether it ends at the object.
    fn hit(&self, ray: [f64; 3]) -> (f64, bool) {
        let mut z = f64::INFINITY;
        if ray[2] < 0.0 {
            z = z.min(self.height / -ray[2]);
        }
        if ray[1] > 0.0 {
            z = z.min(self.wall / ray[1]);
        }
        let behind = z;
        for block in self.object {
            let middle = [0, 1].map(|i| self.at[i] + block.at[i]);
            let sides = [
                [middle[0] - 0.5 * block.size[0], middle[0] + 0.5 * block.size[0]],
                [middle[1] - 0.5 * block.size[1], middle[1] + 0.5 * block.size[1]],
                [block.height[0] - self.height, block.height[1] - self.height],
            ];
            let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
            for (direction, side) in ray.iter().zip(sides) {
                let [a, b] = side.map(|s| s / direction);
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            }
            if enter < leave && enter > 0.0 {
                z = z.min(enter);
            }
        }
        (z, z < behind)
    }

    /// Tiles on floor and wall, grain on the object.
    fn colour(&self, ray: [f64; 3], z: f64, object: bool) -> [u8; 3] {
        let [x, y, up] = ray.map(|d| d * z);
        if object {
            let grain = 12.0 * libm::sin(40.0 * (up + x));
            return [150.0 + grain, 100.0 + grain, 60.0 + 0.5 * grain].map(|c| c as u8);
        }
        let on_wall = y > self.wall - 0.01;
        let (a, b) = if on_wall { (x, up) } else { (x, y) };
        let odd = (libm::floor(a * 2.0) + libm::floor(b * 2.0)).rem_euclid(2.0) > 0.5;
        match (on_wall, odd) {
            (true, false) => [210, 205, 190],
            (true, true) => [204, 200, 188],
            (false, false) => [90, 96, 101],
            (false, true) => [120, 124, 126],
        }
    }
}

/// A chest: 60 cm wide, 40 cm deep, 50 cm high.
pub const CHEST: &[Block] = &[Block { at: [0.0, 0.0], size: [0.6, 0.4], height: [0.0, 0.5] }];

/// A chair: a seat on a box, and a back.
pub const CHAIR: &[Block] = &[
    Block { at: [0.0, 0.0], size: [0.45, 0.45], height: [0.4, 0.46] },
    Block { at: [0.0, 0.2], size: [0.45, 0.05], height: [0.46, 0.95] },
    Block { at: [0.0, 0.0], size: [0.3, 0.3], height: [0.0, 0.4] },
];

/// A bench: long and low.
pub const BENCH: &[Block] = &[Block { at: [0.0, 0.0], size: [1.0, 0.35], height: [0.0, 0.4] }];

/// Runs a test on a stack that holds a workspace by value.
pub fn with_stack(test: impl FnOnce() + Send + 'static) {
    let thread = std::thread::Builder::new().stack_size(64 << 20).spawn(test);
    if let Err(panic) = thread.expect("a thread").join() {
        std::panic::resume_unwind(panic);
    }
}

/// A packet of the serial protocol.
pub fn packet(kind: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    pldi_core::serial::packet::write(
        &mut |bytes| out.extend_from_slice(bytes),
        kind,
        sequence,
        payload.len() as u16,
        |body| body.put(payload),
    );
    out
}
