//! The crate's own pseudo-random numbers: the same seed gives the same bits on every platform and in every version.

/// A splitmix64 generator (Steele, Lea, Flood 2014): 64 bits of state, every seed is a good seed.
#[allow(missing_copy_implementations, reason = "a copy would repeat the same numbers unnoticed")]
#[derive(Debug, Clone)]
pub struct Rng(u64);

/// The increment of the state: 2^64 divided by the golden ratio.
const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of splitmix64: a bijection that scatters neighbouring inputs.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Joins a seed and a stream number into a new seed, so that parts of one object draw independent numbers.
#[must_use]
pub fn derive(seed: u64, stream: u64) -> u64 {
    mix(seed.wrapping_mul(GAMMA).wrapping_add(mix(stream.wrapping_add(GAMMA))))
}

impl Rng {
    /// A generator whose numbers follow from `seed` alone.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(mix(seed.wrapping_add(GAMMA)))
    }

    /// 64 uniform bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GAMMA);
        mix(self.0)
    }

    /// A uniform number in 0..1, a multiple of 2^-24.
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// A uniform number in `low`..`high`.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.uniform()
    }

    /// A whole number in 0..`n` (0 where `n` is 0).
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f32) -> bool {
        self.uniform() < p
    }

    /// One of the items.
    ///
    /// # Panics
    /// Where there are none.
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// A number of mean 0 and standard deviation 1, nearly normal: the sum of four uniform 16-bit numbers, so it never
    /// exceeds 3.47 in magnitude. Cheap enough for every pixel of an image.
    pub fn normal(&mut self) -> f32 {
        let bits = self.bits();
        let sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
        // Mean 2 * 65535, variance 4 * 65536^2 / 12.
        (sum as f32 - 131_070.0) * (1.732_050_8 / 65_536.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut rng = Rng::new(7);
        let n = 200_000;
        let (mut u, mut s, mut s2) = (0.0f64, 0.0f64, 0.0f64);
        for _ in 0..n {
            u += f64::from(rng.uniform());
            let x = f64::from(rng.normal());
            s += x;
            s2 += x * x;
        }
        let n = f64::from(n);
        assert!((u / n - 0.5).abs() < 0.003);
        assert!((s / n).abs() < 0.01 && (s2 / n - 1.0).abs() < 0.01);
    }

    #[test]
    fn bounds_hold_and_streams_differ() {
        let mut rng = Rng::new(0);
        let mut seen = [0; 5];
        for _ in 0..1000 {
            seen[rng.below(5)] += 1;
            assert!((2.0..3.0).contains(&rng.range(2.0, 3.0)));
        }
        assert!(seen.iter().all(|&n| n > 150));
        assert_ne!(derive(1, 2), derive(2, 1));
        assert_ne!(Rng::new(1).bits(), Rng::new(2).bits());
    }
}
