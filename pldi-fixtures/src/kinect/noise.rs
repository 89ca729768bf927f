//! Fields of random numbers over an image.

use crate::rng::Rng;

/// Normal numbers of mean 0 and standard deviation 1 for each pixel, smooth over about three pixels: the sensor
/// correlates windows of the pattern, so neighbouring readings err together.
pub(super) fn smooth_field(width: usize, height: usize, seed: u64) -> Vec<f32> {
    let mut rng = Rng::new(seed);
    let wide = width + 2;
    // Sums of three along the rows, kept for three rows; the sum of nine has a standard deviation of 3.
    let mut row = vec![0.0f32; wide];
    let mut sums = [vec![0.0f32; width], vec![0.0f32; width], vec![0.0f32; width]];
    let mut field = Vec::with_capacity(width * height);
    for line in 0..height + 2 {
        row.fill_with(|| rng.normal());
        for (sum, triple) in sums[line % 3].iter_mut().zip(row.windows(3)) {
            *sum = triple[0] + triple[1] + triple[2];
        }
        if line >= 2 {
            field.extend((0..width).map(|i| (sums[0][i] + sums[1][i] + sums[2][i]) / 3.0));
        }
    }
    field
}

/// The share of a normal distribution below `x` standard deviations (logistic approximation, off by 0.01 at most).
pub(super) fn normal_share(x: f32) -> f32 {
    1.0 / (1.0 + libm::expf(-1.702 * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_normal_and_correlated_over_three_pixels() {
        let (w, h) = (320, 240);
        let field = smooth_field(w, h, 3);
        assert_eq!(field.len(), w * h);
        let correlation = |du: usize, dv: usize| {
            let mut sum = 0.0f64;
            for v in 0..h - dv {
                for u in 0..w - du {
                    sum += f64::from(field[v * w + u]) * f64::from(field[(v + dv) * w + u + du]);
                }
            }
            sum / ((w - du) * (h - dv)) as f64
        };
        assert!((correlation(0, 0) - 1.0).abs() < 0.03);
        assert!((correlation(1, 0) - 2.0 / 3.0).abs() < 0.03);
        assert!((correlation(0, 2) - 1.0 / 3.0).abs() < 0.03);
        assert!(correlation(3, 0).abs() < 0.03);
        assert!((normal_share(1.0) - 0.8413).abs() < 0.01);
    }
}
