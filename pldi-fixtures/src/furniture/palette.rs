//! Materials that several classes share.

use crate::mesh::{Material, Texture};
use crate::rng::Rng;

/// Wood, from birch to walnut, or lacquered white or black.
pub(super) fn wood(rng: &mut Rng) -> Material {
    let colours = [[222, 190, 145], [196, 150, 98], [160, 108, 62], [112, 72, 44], [84, 54, 38], [205, 170, 125]];
    match rng.below(9) {
        0 => Material::plain([226, 224, 218]),
        1 => Material::plain([72, 70, 68]),
        _ => Material::new(rng.pick(&colours), Texture::Wood),
    }
}

/// Upholstery.
pub(super) fn cloth(rng: &mut Rng) -> Material {
    let colours = [
        [120, 124, 130],
        [96, 116, 150],
        [158, 60, 52],
        [190, 176, 150],
        [86, 118, 92],
        [200, 160, 70],
        [110, 80, 66],
        [70, 74, 84],
    ];
    Material::new(rng.pick(&colours), Texture::Cloth)
}

/// Painted or plated metal.
pub(super) fn metal(rng: &mut Rng) -> Material {
    match rng.below(3) {
        0 => Material::shiny([176, 178, 182], 0.25),
        1 => Material::plain([88, 90, 94]),
        _ => Material::plain([208, 208, 204]),
    }
}

/// Moulded plastic.
pub(super) fn plastic(rng: &mut Rng) -> Material {
    let colours =
        [[70, 72, 78], [206, 208, 210], [60, 92, 140], [60, 120, 84], [176, 62, 54], [220, 196, 90], [130, 134, 140]];
    Material::plain(rng.pick(&colours))
}
