//! Tails and percentiles of distributions.

/// 97.5th percentile of the standard normal distribution: either end of a 95% interval.
pub const NORMAL_975: f64 = 1.959_964;

/// 97.5th percentiles of Student's t for 1 to 9 degrees of freedom.
const STUDENT_975: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];

/// Below this the series of Kolmogorov's distribution has not converged, and the tail is one to
/// many digits.
const MIN_KOLMOGOROV: f64 = 0.2;

/// Probability that a standard normal variable exceeds `z`.
///
/// # Source
/// The rational Chebyshev form of Press et al., *Numerical Recipes*, 6.2: relative error 1.2e-7.
pub fn normal_upper_tail(z: f64) -> f64 {
    const TERMS: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let x = z.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.5 * x);
    // Horner's scheme, from the highest power.
    let sum = TERMS.iter().rev().fold(0.0, |sum, term| sum * t + term);
    let tail = 0.5 * t * (sum - x * x).exp();
    // The form holds for positive arguments; the other side is the complement.
    if z >= 0.0 { tail } else { 1.0 - tail }
}

/// 97.5th percentile of Student's t distribution.
///
/// # Panics
/// For no degrees of freedom.
///
/// # Source
/// Tables up to 9 degrees of freedom; beyond them the expansion of Abramowitz and Stegun, *Handbook
/// of Mathematical Functions*, 26.7.5.
pub fn student_975(degrees: usize) -> f64 {
    STUDENT_975.get(degrees - 1).copied().unwrap_or_else(|| {
        let (z, n) = (NORMAL_975, degrees as f64);
        let second = 5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z;
        let third = 3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z;
        let [first, second, third] =
            [(z.powi(3) + z) / (4.0 * n), second / (96.0 * n * n), third / (384.0 * n.powi(3))];
        z + first + second + third
    })
}

/// Probability that Kolmogorov's statistic `√n D` exceeds `x`: `2 Σ (-1)^(k-1) exp(-2 k² x²)`.
pub fn kolmogorov_upper_tail(x: f64) -> f64 {
    if x < MIN_KOLMOGOROV {
        return 1.0;
    }
    let term = |k: i32| {
        let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
        sign * (-2.0 * f64::from(k * k) * x * x).exp()
    };
    // Even at the smallest x, terms vanish before k = 30.
    (2.0 * (1..=100).map(term).sum::<f64>()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_the_normal_distribution_are_those_of_the_tables() {
        for (z, p) in [(0.0, 0.5), (1.959_964, 0.025), (5.0, 2.866_516e-7), (-1.0, 0.841_345)] {
            assert!((normal_upper_tail(z) / p - 1.0).abs() < 2e-6, "{z}");
        }
        // Abramowitz and Stegun, tables 26.1 and 26.2.
        for (z, p) in [
            (0.5, 0.308_537_538_7),
            (1.0, 0.158_655_253_9),
            (1.5, 0.066_807_201_3),
            (2.0, 0.022_750_131_9),
            (3.0, 0.001_349_898_03),
            (4.0, 3.167_124_2e-5),
        ] {
            assert!((normal_upper_tail(z) / p - 1.0).abs() < 2e-7, "{z}");
            assert!((normal_upper_tail(z) + normal_upper_tail(-z) - 1.0).abs() < 1e-15, "{z}");
        }
    }

    #[test]
    fn percentiles_of_t_continue_smoothly_beyond_the_table() {
        // Tables: 2.228 for 10 degrees of freedom, 2.042 for 30.
        assert!((student_975(10) - 2.228).abs() < 1e-3 && (student_975(30) - 2.042).abs() < 1e-3);
        assert!((1..200).all(|n| student_975(n) > student_975(n + 1)));
        // More digits: the expansion is good to 3e-4 at 10 and to 1e-6 from 60 on.
        for (n, t, error) in [
            (10, 2.228_138_9, 3e-4),
            (12, 2.178_812_8, 1e-4),
            (15, 2.131_449_5, 5e-5),
            (20, 2.085_963_4, 2e-5),
            (60, 2.000_297_8, 1e-6),
            (120, 1.979_930_4, 1e-6),
        ] {
            assert!((student_975(n) - t).abs() < error, "{n}: {}", student_975(n));
        }
        assert_eq!([1, 2, 9].map(student_975), [12.706, 4.303, 2.262]);
    }

    #[test]
    fn tails_of_kolmogorov_are_those_of_the_tables() {
        for (x, p) in [(1.2238, 0.10), (1.3581, 0.05), (1.6276, 0.01)] {
            assert!((kolmogorov_upper_tail(x) - p).abs() < 1e-4, "{x}");
        }
        assert_eq!(kolmogorov_upper_tail(0.1), 1.0);
        // The same distribution by its other series, which converges for small arguments.
        for x in [0.25, 0.4, 0.6, 0.8, 1.0, 1.5, 3.0] {
            let pi = std::f64::consts::PI;
            let term = |k: i32| (-f64::from((2 * k - 1).pow(2)) * pi * pi / (8.0 * x * x)).exp();
            let tail = 1.0 - (2.0 * pi).sqrt() / x * (1..50).map(term).sum::<f64>();
            assert!((kolmogorov_upper_tail(x) - tail).abs() < 1e-12, "{x}");
        }
    }
}
