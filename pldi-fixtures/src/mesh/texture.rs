//! What surfaces look like: a colour and a procedural pattern that follows from the position in the object's frame.

/// A pattern over a material's colour. Lengths are in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texture {
    /// One colour.
    Plain,
    /// Wood grain that runs along y.
    Wood,
    /// Woven cloth: a fine weave and soft stains.
    Cloth,
    /// Two shades in squares of this side.
    Checker(f32),
    /// Soft blotches, as of plaster.
    Noise,
    /// Floor boards of this width, with dark joints.
    Planks(f32),
    /// Tiles of this side, with joints and a shade of their own each.
    Tiles(f32),
    /// Upright stripes of this width, as of wallpaper.
    Stripes(f32),
}

/// The look of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Base colour, 8 bits each of red, green, blue.
    pub colour: [u8; 3],
    /// Pattern over the colour.
    pub texture: Texture,
    /// 0 (matt) to 1 (polished metal): how often the surface throws the projector's light elsewhere and gives no depth.
    pub gloss: f32,
}

impl Material {
    /// A matt material of one colour.
    #[must_use]
    pub const fn plain(colour: [u8; 3]) -> Self {
        Self { colour, texture: Texture::Plain, gloss: 0.0 }
    }

    /// A matt material with a pattern.
    #[must_use]
    pub const fn new(colour: [u8; 3], texture: Texture) -> Self {
        Self { colour, texture, gloss: 0.0 }
    }

    /// A shiny material of one colour; `gloss` from 0 to 1.
    #[must_use]
    pub const fn shiny(colour: [u8; 3], gloss: f32) -> Self {
        Self { colour, texture: Texture::Plain, gloss }
    }

    /// The colour (0 to 1 each of red, green, blue) at point `p` of the object's frame, in metres.
    #[must_use]
    pub fn albedo(&self, p: [f32; 3]) -> [f32; 3] {
        let factor = match self.texture {
            Texture::Plain => 1.0,
            Texture::Wood => {
                let warp = value_noise([p[0] * 5.0, p[1] * 1.5, p[2] * 5.0]);
                let rings = (p[0] + p[2]) * 22.0 + 3.0 * warp;
                let fibre = value_noise([p[0] * 260.0, p[1] * 12.0, p[2] * 260.0]);
                0.8 + 0.2 * triangle_wave(rings) + 0.1 * (fibre - 0.5)
            }
            Texture::Cloth => {
                let weave = value_noise([p[0] * 350.0, p[1] * 350.0, p[2] * 350.0]);
                let stain = value_noise([p[0] * 9.0, p[1] * 9.0, p[2] * 9.0]);
                0.8 + 0.25 * weave + 0.1 * stain
            }
            Texture::Checker(side) => {
                let sum: i32 = p.iter().map(|&c| ((c + 1e-4) / side).floor() as i32).fold(0, i32::wrapping_add);
                if sum & 1 == 0 { 1.0 } else { 0.72 }
            }
            Texture::Noise => 0.88 + 0.14 * value_noise([p[0] * 6.0, p[1] * 6.0, p[2] * 6.0]),
            Texture::Planks(width) => {
                let row = (p[1] / width).floor();
                // Each board is 1.1 m long and starts at its own place.
                let along = p[0] / 1.1 + 0.37 * row;
                let board = lattice(row as i32, along.floor() as i32, 3);
                let joint = joint(p[1] / width, 0.002 / width).min(joint(along, 0.002));
                let fibre = value_noise([p[0] * 12.0, p[1] * 160.0, board * 50.0]);
                (0.74 + 0.26 * board + 0.14 * (fibre - 0.5)) * joint
            }
            Texture::Tiles(side) => {
                let (u, v) = (p[0] / side, p[1] / side);
                let tile = lattice(u.floor() as i32, v.floor() as i32, 5);
                let mottle = value_noise([p[0] * 40.0, p[1] * 40.0, p[2] * 40.0]);
                let joint = joint(u, 0.003 / side).min(joint(v, 0.003 / side));
                (0.86 + 0.1 * tile + 0.08 * (mottle - 0.5)) * joint
            }
            Texture::Stripes(width) => {
                let stripe = ((p[0] + p[1]) / width).floor() as i32 & 1;
                let paper = value_noise([p[0] * 60.0, p[1] * 60.0, p[2] * 60.0]);
                (if stripe == 0 { 0.95 } else { 0.8 }) + 0.05 * paper
            }
        };
        self.colour.map(|c| (f32::from(c) / 255.0 * factor).clamp(0.0, 1.0))
    }
}

/// 0 at whole numbers, 1 halfway between.
fn triangle_wave(x: f32) -> f32 {
    1.0 - (2.0 * (x - x.floor()) - 1.0).abs()
}

/// Dark within `half` of a whole number.
fn joint(x: f32, half: f32) -> f32 {
    let distance = (x - x.round()).abs();
    if distance < half { 0.55 } else { 1.0 }
}

/// A number in 0..1 for each point of the integer lattice.
fn lattice(x: i32, y: i32, z: i32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343) ^ (y as u32).wrapping_mul(0xd816_3841);
    h ^= (z as u32).wrapping_mul(0xcb1a_b31f);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    (h >> 8) as f32 / 16_777_216.0
}

/// Smooth noise in 0..1: the lattice's numbers, interpolated.
fn value_noise(p: [f32; 3]) -> f32 {
    let cell = p.map(|c| c.floor() as i32);
    let t = p.map(|c| {
        let f = c - c.floor();
        f * f * (3.0 - 2.0 * f)
    });
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let at = |dx: i32, dy: i32, dz: i32| {
        lattice(cell[0].wrapping_add(dx), cell[1].wrapping_add(dy), cell[2].wrapping_add(dz))
    };
    let layer = |dz| mix(mix(at(0, 0, dz), at(1, 0, dz), t[0]), mix(at(0, 1, dz), at(1, 1, dz), t[0]), t[1]);
    mix(layer(0), layer(1), t[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedo_stays_in_range_and_patterns_show() {
        let textures = [
            Texture::Wood,
            Texture::Cloth,
            Texture::Checker(0.1),
            Texture::Noise,
            Texture::Planks(0.12),
            Texture::Tiles(0.3),
            Texture::Stripes(0.1),
        ];
        for texture in textures {
            let material = Material::new([200, 150, 100], texture);
            let (mut low, mut high) = (1.0f32, 0.0f32);
            for i in 0..2000 {
                let t = i as f32 * 0.0137;
                let c = material.albedo([t - 9.0, 0.31 * t - 3.0, 0.05 * t]);
                assert!(c.iter().all(|c| (0.0..=1.0).contains(c)));
                low = low.min(c[0]);
                high = high.max(c[0]);
            }
            assert!(high - low > 0.05, "{texture:?} is flat: {low}..{high}");
        }
        assert_eq!(Material::plain([255, 0, 51]).albedo([1.0, 2.0, 3.0]), [1.0, 0.0, 0.2]);
    }
}
