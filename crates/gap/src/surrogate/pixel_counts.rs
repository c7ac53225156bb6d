//! Hot and dead pixels: outliers against their neighbours.
//!
//! # Method
//! The expected count of a pixel is the mean of its neighbours within two pixels, without the three
//! busiest. A pixel is hot if its count is improbable for a Poisson process of that rate, raised by
//! three standard deviations of the differences between pixels; dead if zero events are improbable
//! at the lower quartile of its neighbours. The false discovery rate is 1 % (Benjamini and Hochberg
//! 1995).

use evpose_core::stats::quantile::upper_index;

use super::train::Train;

/// Radius of the neighbourhood, pixels.
const RADIUS: usize = 2;
/// Busiest neighbours that are left out, because they may be hot themselves.
const TRIMMED: usize = 3;
const FALSE_DISCOVERY_RATE: f64 = 0.01;
/// Minimum ratio of a hot pixel's count to the expected one.
const MIN_RATIO: f64 = 4.0;
/// Minimum expected count of a pixel that is used for the spread.
const MIN_MEAN: f64 = 10.0;

/// Standard deviation of a normal distribution over its median absolute deviation.
const MAD_TO_SD: f64 = 1.4826;

/// Event counts of every pixel and of its neighbours.
pub(super) struct Counts {
    counts: Vec<f64>,
    /// Trimmed mean of the neighbours.
    means: Vec<f64>,
    /// Lower quartile of the neighbours.
    quartiles: Vec<f64>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Outliers {
    pub(super) hot: Vec<u32>,
    pub(super) dead: Vec<u32>,
}

impl Counts {
    pub(super) fn from_train(train: &Train) -> Self {
        let (width, height) = (train.width(), usize::from(train.size.height));
        let mut counts = vec![0.0; width * height];
        for mark in &train.marks {
            counts[mark.pixel as usize] += 1.0;
        }
        let (mut means, mut quartiles) = (Vec::new(), Vec::new());
        let mut around: Vec<f64> = Vec::new();
        for pixel in 0..counts.len() {
            let (x, y) = (pixel % width, pixel / width);
            around.clear();
            for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height) {
                for column in x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width) {
                    if (column, row) != (x, y) {
                        around.push(counts[row * width + column]);
                    }
                }
            }
            around.sort_by(f64::total_cmp);
            quartiles.push(around.get(upper_index(around.len(), 1, 4)).copied().unwrap_or(0.0));
            // Without the largest, since a hot neighbour would hide a hot pixel.
            let trimmed = &around[..around.len().saturating_sub(TRIMMED)];
            // One more event, so that no rate is zero.
            means.push((trimmed.iter().sum::<f64>() + 1.0) / trimmed.len().max(1) as f64);
        }
        Self { counts, means, quartiles }
    }

    /// Largest excess of a pixel over its neighbours, in standard deviations of a Poisson count.
    pub(super) fn hottest(&self) -> f64 {
        let excess =
            self.counts.iter().zip(&self.means).map(|(n, mean)| (n - mean) / (mean + 1.0).sqrt());
        excess.fold(0.0, f64::max)
    }

    /// Largest lower quartile of the neighbours over all pixels without events.
    pub(super) fn max_silence(&self) -> f64 {
        let silent = self.counts.iter().zip(&self.quartiles).filter(|(n, _)| **n <= 0.0);
        silent.map(|(_, quartile)| *quartile).fold(0.0, f64::max)
    }

    /// Hot and dead pixels at the false discovery rate.
    pub(super) fn outliers(&self) -> Outliers {
        let spread = self.spread();
        // A logarithm of zero is p = 1: pixels below the minimum ratio are no discoveries.
        let hot = |pixel: usize| {
            let (n, mean) = (self.counts[pixel], self.means[pixel]);
            if n < MIN_RATIO * mean { 0.0 } else { ln_tail(n, mean * (1.0 + 3.0 * spread)) }
        };
        let dead = |pixel: usize| {
            if self.counts[pixel] > 0.0 {
                0.0
            } else {
                -self.quartiles[pixel] / (1.0 + 3.0 * spread)
            }
        };
        Outliers { hot: self.discoveries(hot), dead: self.discoveries(dead) }
    }

    /// Count of a pixel, and its expected count.
    pub(super) fn at(&self, pixel: u32) -> (f64, f64) {
        (self.counts[pixel as usize], self.means[pixel as usize])
    }

    pub(super) fn quartile(&self, pixel: u32) -> f64 {
        self.quartiles[pixel as usize]
    }

    /// Whether no pixel without events could be significant anywhere.
    pub(super) fn is_sparse(&self) -> bool {
        let pixels = self.counts.len() as f64;
        self.quartiles.iter().all(|quartile| *quartile < (pixels / FALSE_DISCOVERY_RATE).ln())
    }

    /// Standard deviation of differences between pixels beyond Poisson noise, relative to the
    /// count.
    fn spread(&self) -> f64 {
        let busy = self.counts.iter().zip(&self.means).filter(|(_, mean)| **mean >= MIN_MEAN);
        let mut apart: Vec<(f64, f64)> =
            busy.map(|(n, mean)| ((n - mean).abs() / mean, 1.0 / mean)).collect();
        if apart.is_empty() {
            return 0.0;
        }
        apart.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median, chance) = apart[apart.len() / 2];
        // The median is not moved by hot pixels; the variance of counts is taken off.
        ((MAD_TO_SD * median).powi(2) - chance).max(0.0).sqrt()
    }

    /// Pixels that are significant at the false discovery rate, from logarithms of p-values.
    fn discoveries(&self, ln_p: impl Fn(usize) -> f64) -> Vec<u32> {
        let mut ranked: Vec<(f64, u32)> = (0..self.counts.len())
            .map(|pixel| (ln_p(pixel), pixel as u32))
            .filter(|(ln_p, _)| *ln_p < 0.0)
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let tests = self.counts.len() as f64;
        let passes = |(rank, (ln_p, _)): (usize, &(f64, u32))| {
            *ln_p <= (FALSE_DISCOVERY_RATE * (rank + 1) as f64 / tests).ln()
        };
        // Step-up: all pixels up to the last that passes are discoveries, also some that fail
        // alone.
        let last = ranked.iter().enumerate().rposition(passes);
        let mut pixels: Vec<u32> =
            ranked[..last.map_or(0, |rank| rank + 1)].iter().map(|(_, pixel)| *pixel).collect();
        pixels.sort_unstable();
        pixels
    }
}

/// Logarithm of the probability that a Poisson variable is at least `n`, for `n` above the mean:
/// the first term of the tail, and the ratio of the tail to it.
fn ln_tail(n: f64, mean: f64) -> f64 {
    if n <= mean {
        return 0.0;
    }
    let ln_factorial: f64 = (2..=n as u64).map(|k| (k as f64).ln()).sum();
    let first = n * mean.ln() - mean - ln_factorial;
    let (mut term, mut rest, mut k) = (1.0, 1.0, n);
    while term > 1e-12 * rest {
        k += 1.0;
        term *= mean / k;
        rest += term;
    }
    first + rest.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_of_a_poisson_variable_is_one_less_its_beginning() {
        for (n, mean) in [(3.0, 2.0), (9.0, 2.0), (25.0, 10.0)] {
            let mut term = f64::exp(-mean);
            let mut below = 0.0;
            for k in 0..n as u64 {
                below += term;
                term *= mean / (k + 1) as f64;
            }
            assert!((ln_tail(n, mean).exp() / (1.0 - below) - 1.0).abs() < 1e-6, "{n} {mean}");
        }
    }
}
