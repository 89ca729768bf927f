//! Colours of a Bayer mosaic: bilinear, each missing value the mean of the nearest that were measured.

/// Colours of the first two pixels of the first row, then of the second one; 0 is red, 1 green, 2 blue.
pub(super) const RGGB: [usize; 4] = [0, 1, 1, 2];
pub(super) const BGGR: [usize; 4] = [2, 1, 1, 0];
pub(super) const GBRG: [usize; 4] = [1, 2, 0, 1];
pub(super) const GRBG: [usize; 4] = [1, 0, 2, 1];

/// Red, green and blue of a mosaic, row by row. The rim is mirrored, which keeps the pattern.
pub(super) fn demosaic((width, height): (u16, u16), mosaic: &[u8], pattern: [usize; 4]) -> Vec<u8> {
    let (width, height) = (usize::from(width), usize::from(height));
    // A missing neighbour is the one on the other side; an image of one row or column has neither.
    let around = |i: usize, n: usize| {
        let (low, high) = (i.checked_sub(1), Some(i + 1).filter(|i| *i < n));
        [low.or(high).unwrap_or(i), high.or(low).unwrap_or(i)]
    };
    let mut rgb = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        let ys = around(y, height);
        for x in 0..width {
            let xs = around(x, width);
            let at = |x: usize, y: usize| u32::from(mosaic[y * width + x]);
            let horizontal = (at(xs[0], y) + at(xs[1], y)).div_ceil(2) as u8;
            let vertical = (at(x, ys[0]) + at(x, ys[1])).div_ceil(2) as u8;
            let mean = |sum: u32| ((sum + 2) / 4) as u8;
            let mut pixel = [0; 3];
            let own = pattern[2 * (y % 2) + x % 2];
            if own == 1 {
                pixel[pattern[2 * (y % 2) + (x + 1) % 2]] = horizontal;
                pixel[pattern[2 * ((y + 1) % 2) + x % 2]] = vertical;
            } else {
                pixel[1] = mean(at(xs[0], y) + at(xs[1], y) + at(x, ys[0]) + at(x, ys[1]));
                let corners = at(xs[0], ys[0]) + at(xs[1], ys[0]) + at(xs[0], ys[1]) + at(xs[1], ys[1]);
                pixel[2 - own] = mean(corners);
            }
            pixel[own] = mosaic[y * width + x];
            rgb.extend(pixel);
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_colour_comes_back_from_every_pattern() {
        let colour = [200, 100, 50];
        for pattern in [RGGB, BGGR, GBRG, GRBG] {
            for (w, h) in [(2, 2), (4, 6), (5, 3)] {
                let mosaic: Vec<u8> =
                    (0..h).flat_map(|y| (0..w).map(move |x| colour[pattern[2 * (y % 2) + x % 2]])).collect();
                assert_eq!(
                    demosaic((w as u16, h as u16), &mosaic, pattern),
                    colour.repeat(w * h),
                    "{pattern:?} {w}x{h}"
                );
            }
        }
    }

    #[test]
    fn missing_values_are_means_of_their_neighbours() {
        #[rustfmt::skip]
        let mosaic = [
            10, 20, 30, 40,
            50, 60, 70, 81,
            90, 11, 21, 31,
            41, 51, 61, 71,
        ];
        let rgb = demosaic((4, 4), &mosaic, RGGB);
        let at = |x: usize, y: usize| [0, 1, 2].map(|c| rgb[3 * (4 * y + x) + c]);
        // Blue at (1, 1): red from the corners, green from the sides.
        assert_eq!(at(1, 1), [38, 38, 60]);
        // Green at (2, 1), in a row of blue: red above and below, blue left and right.
        assert_eq!(at(2, 1), [26, 70, 71]);
        // Red in the corner: neighbours on one side only.
        assert_eq!(at(0, 0), [10, 35, 60]);
    }

    #[test]
    fn images_of_one_row_or_column_do_not_panic() {
        for size in [(1, 1), (1, 5), (5, 1)] {
            assert_eq!(demosaic(size, &[9; 5], GBRG).len(), 3 * usize::from(size.0 * size.1));
        }
    }
}
