//! The truth of the stages that turn a view into numbers, in float64: wavelets, statistics, distances.

/// Side of a view.
pub const SIDE: usize = 128;

/// Daubechies' scaling filter with 8 taps, in the order of a convolution (PyWavelets' `db4`, decomposition low-pass).
pub const LOW: [f64; 8] = [
    -0.010_597_401_785_069_032,
    0.032_883_011_666_885_2,
    0.030_841_381_835_560_764,
    -0.187_034_811_719_093_09,
    -0.027_983_769_416_859_854,
    0.630_880_767_929_858_9,
    0.714_846_570_552_915_7,
    0.230_377_813_308_896_5,
];

/// The wavelet filter: the scaling filter backwards with alternating signs.
pub fn high() -> [f64; 8] {
    core::array::from_fn(|j| if j % 2 == 0 { -LOW[7 - j] } else { LOW[7 - j] })
}

/// The four sub-bands of one level (approximation, horizontal, vertical, diagonal), each by a two-dimensional
/// convolution with periodic borders, every second value kept.
fn level(image: &[f64], size: usize) -> [Vec<f64>; 4] {
    let bands = [(LOW, LOW), (high(), LOW), (LOW, high()), (high(), high())];
    bands.map(|(vertical, horizontal)| {
        let half = size / 2;
        let value = |o: usize| {
            let (row, column) = (o / half, o % half);
            let mut sum = 0.0;
            for (i, a) in vertical.iter().enumerate() {
                for (j, b) in horizontal.iter().enumerate() {
                    let (y, x) = ((2 * row + 4 + 7 * size - i) % size, (2 * column + 4 + 7 * size - j) % size);
                    sum += a * b * image[y * size + x];
                }
            }
            sum
        };
        (0..half * half).map(value).collect()
    })
}

/// The transform of a view: the last approximation, then horizontal, vertical, diagonal from coarse to fine.
pub fn wavelets(view: &[f64]) -> (f64, Vec<[Vec<f64>; 3]>) {
    let (mut image, mut size, mut levels) = (view.to_vec(), SIDE, Vec::new());
    while size > 1 {
        let [approximation, horizontal, vertical, diagonal] = level(&image, size);
        levels.insert(0, [horizontal, vertical, diagonal]);
        (image, size) = (approximation, size / 2);
    }
    (image[0], levels)
}

/// Which statistics describe a sub-band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Mean, standard deviation, skewness.
    Paper,
    /// Mean of the upper half, mean of the lower half, standard deviation.
    Halves,
}

/// The 58 numbers of a view.
pub fn descriptor(view: &[f64], kind: Kind) -> Vec<f64> {
    let (approximation, levels) = wavelets(view);
    descriptor_of(approximation, &levels, kind)
}

/// The 58 numbers of a view's [`wavelets`].
pub fn descriptor_of(approximation: f64, levels: &[[Vec<f64>; 3]], kind: Kind) -> Vec<f64> {
    let details = levels.iter().flatten().flatten();
    let total = approximation.abs() + details.map(|c| c.abs()).sum::<f64>();
    if total == 0.0 {
        return vec![0.0; 58];
    }
    let mut out = vec![approximation.abs() / total];
    for band in &levels[0] {
        out.push(band[0].abs() / total);
    }
    for band in levels[1..].iter().flatten() {
        let shares: Vec<f64> = band.iter().map(|c| c.abs() / total).collect();
        let moment = |center: f64, power: i32| {
            let term = |a: &f64| (0..power).map(|_| a - center).product::<f64>();
            shares.iter().map(term).sum::<f64>() / shares.len() as f64
        };
        let mean = moment(0.0, 1);
        let deviation = moment(mean, 2).sqrt();
        let half = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let (upper, lower) = shares.split_at(shares.len() / 2);
        out.extend(match kind {
            Kind::Paper if deviation > 1e-12 => {
                [mean, deviation, moment(mean, 3) / (deviation * deviation * deviation)]
            }
            Kind::Paper => [mean, deviation, 0.0],
            Kind::Halves => [half(upper), half(lower), deviation],
        });
    }
    out
}

/// The Canberra distance.
pub fn canberra(a: &[f64], b: &[f64]) -> f64 {
    let term = |(a, b): (&f64, &f64)| if a.abs() + b.abs() > 0.0 { (a - b).abs() / (a.abs() + b.abs()) } else { 0.0 };
    a.iter().zip(b).map(term).sum()
}

/// What defines Daubechies' filter: how far its sum is from sqrt 2, its double shifts from orthogonality, and its
/// wavelet's first four moments from 0.
pub fn defect_of_the_filter() -> f64 {
    let mut worst = (LOW.iter().sum::<f64>() - 2.0f64.sqrt()).abs();
    for shift in 0..4 {
        let product: f64 = (2 * shift..8).map(|i| LOW[i] * LOW[i - 2 * shift]).sum();
        worst = worst.max((product - if shift == 0 { 1.0 } else { 0.0 }).abs());
    }
    for power in 0..4 {
        let term = |(k, g): (usize, &f64)| (0..power).fold(*g, |m, _| m * (k as f64 / 7.0));
        worst = worst.max(high().iter().enumerate().map(term).sum::<f64>().abs());
    }
    worst
}
