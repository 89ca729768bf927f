//! Larger frames made QVGA: by whole blocks, so that intrinsics stay exact.

use std::path::Path;

use super::{DepthScale, MAX_FACTOR};
use crate::Error;

const WIDTH: usize = pldi_core::frame::QVGA_WIDTH;
const HEIGHT: usize = pldi_core::frame::QVGA_HEIGHT;

/// The whole factor by which an image is larger than QVGA, the same both ways.
pub(super) fn factor(path: &Path, size: (u16, u16)) -> Result<u16, Error> {
    let k = size.0 / WIDTH as u16;
    if (1..=MAX_FACTOR).contains(&k) && size == (k * WIDTH as u16, k * HEIGHT as u16) {
        return Ok(k);
    }
    Err(Error::UnsupportedSize { image: path.to_owned(), size: (size.0.into(), size.1.into()) })
}

/// Depth in mm from raw values: the top-left pixel of each block of k x k, because a mean would mix surfaces.
/// `raw` has k x 320 columns and k x 240 rows.
pub(super) fn depth(raw: &[u16], k: u16, scale: DepthScale) -> Vec<u16> {
    let k = usize::from(k);
    let rows = raw.chunks_exact(k * WIDTH).step_by(k);
    rows.flat_map(|row| row.iter().step_by(k).map(|&value| scale.to_mm(value))).collect()
}

/// Colour as the mean of each block of k x k, rounded half up.
pub(super) fn colour(rgb: &[u8], k: u16) -> Vec<u8> {
    if k == 1 {
        return rgb.to_vec();
    }
    let n = u32::from(k) * u32::from(k);
    let k = usize::from(k);
    let mut out = Vec::with_capacity(3 * WIDTH * HEIGHT);
    let mut sums = vec![0u32; 3 * WIDTH];
    for block_row in rgb.chunks_exact(3 * k * k * WIDTH) {
        sums.fill(0);
        for row in block_row.chunks_exact(3 * k * WIDTH) {
            for (sum, block) in sums.as_chunks_mut::<3>().0.iter_mut().zip(row.chunks_exact(3 * k)) {
                for pixel in block.as_chunks::<3>().0 {
                    for (s, &value) in sum.iter_mut().zip(pixel) {
                        *s += u32::from(value);
                    }
                }
            }
        }
        out.extend(sums.iter().map(|s| ((2 * s + n) / (2 * n)) as u8));
    }
    out
}

/// A frame of depth in mm and colour, `k` times as large as QVGA, reduced to it.
pub fn reduce(depth_mm: &[u16], rgb: &[u8], k: u16) -> (Vec<u16>, Vec<u8>) {
    (depth(depth_mm, k, DepthScale::Millimetres), colour(rgb, k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_multiples_of_qvga_pass() {
        let path = Path::new("depth.png");
        for k in 1..=MAX_FACTOR {
            assert_eq!(factor(path, (320 * k, 240 * k)).unwrap(), k);
        }
        let k = MAX_FACTOR + 1;
        for size in
            [(0, 0), (160, 120), (320, 480), (640, 360), (641, 480), (512, 424), (320 * k, 240 * k), (65_535, 65_535)]
        {
            let error = factor(path, size).unwrap_err().to_string();
            assert!(error.contains(&format!("{}x{}", size.0, size.1)) && error.contains("320x240"), "{error}");
        }
    }

    #[test]
    fn depth_takes_the_top_left_pixel() {
        for k in 1..=3usize {
            let w = k * WIDTH;
            let raw: Vec<u16> = (0..w * k * HEIGHT).map(|i| ((i % w) + (i / w) * 7) as u16).collect();
            let small = depth(&raw, k as u16, DepthScale::Millimetres);
            assert_eq!(small.len(), WIDTH * HEIGHT);
            assert_eq!(small[5 * WIDTH + 11], (11 * k + 5 * k * 7) as u16);
        }
    }

    #[test]
    fn colour_is_the_mean_rounded_half_up() {
        let mut rgb = vec![0u8; 3 * 640 * 480];
        // Block (1, 0), green: 1 + 1 of 4 is 0.5 and goes up; blue: 1 of 4 goes down; red saturates nothing.
        for (x, y, c, value) in
            [(2, 0, 1, 1), (3, 1, 1, 1), (2, 1, 2, 1), (2, 0, 0, 255), (3, 0, 0, 255), (2, 1, 0, 255), (3, 1, 0, 255)]
        {
            rgb[3 * (y * 640 + x) + c] = value;
        }
        let small = colour(&rgb, 2);
        assert_eq!((small.len(), &small[..9]), (3 * 320 * 240, &[0, 0, 0, 255, 1, 0, 0, 0, 0][..]));
        let small = colour(&[255; 3 * 960 * 720], 3);
        assert!(small.len() == 3 * 320 * 240 && small.iter().all(|&v| v == 255));
    }
}
