//! Hot and dead pixels: single ones that differ from all their neighbours.
//!
//! # Method
//! The expected count of a pixel is that of its neighbours within two pixels, without the three
//! busiest of them. A pixel is hot if a Poisson process of that rate, made larger by three
//! standard deviations of how counts differ from pixel to pixel anyway, would hardly have its
//! count; dead if one of the rate of the quieter neighbours would hardly have none. False
//! discoveries are held at one in a hundred (Benjamini and Hochberg 1995).

use super::train::Train;

/// Reach of the neighbourhood.
const REACH: usize = 2;
/// Busiest neighbours that do not count: they may be hot themselves.
const TRIMMED: usize = 3;
/// Part of false discoveries.
const FALSE_PART: f64 = 0.01;
/// A hot pixel has this many times the expected events.
const LEAST_RATIO: f64 = 4.0;
/// Neighbours' counts from which on a pixel says something about the spread.
const LEAST_MEAN: f64 = 10.0;

/// Events of every pixel, and what its neighbours have.
pub(super) struct Counts {
    counts: Vec<f64>,
    /// Mean of the neighbours, without the busiest.
    means: Vec<f64>,
    /// The count that a quarter of the neighbours are below.
    quartiles: Vec<f64>,
}

/// Pixels that stand out.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Outliers {
    pub(super) hot: Vec<u32>,
    pub(super) dead: Vec<u32>,
}

impl Counts {
    pub(super) fn of(train: &Train) -> Self {
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
            for row in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
                for column in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                    if (column, row) != (x, y) {
                        around.push(counts[row * width + column]);
                    }
                }
            }
            around.sort_by(f64::total_cmp);
            quartiles.push(around.get(around.len() / 4).copied().unwrap_or(0.0));
            let kept = &around[..around.len().saturating_sub(TRIMMED)];
            // One more event, so that no rate is zero.
            means.push((kept.iter().sum::<f64>() + 1.0) / kept.len().max(1) as f64);
        }
        Self { counts, means, quartiles }
    }

    /// How far the hottest pixel is above its neighbours, in standard deviations of a Poisson count.
    pub(super) fn hottest(&self) -> f64 {
        let excess =
            self.counts.iter().zip(&self.means).map(|(n, mean)| (n - mean) / (mean + 1.0).sqrt());
        excess.fold(0.0, f64::max)
    }

    /// The least busy neighbourhood's count of the pixels without any event, the largest of them.
    pub(super) fn deadest(&self) -> f64 {
        let silent = self.counts.iter().zip(&self.quartiles).filter(|(n, _)| **n <= 0.0);
        silent.map(|(_, quartile)| *quartile).fold(0.0, f64::max)
    }

    pub(super) fn outliers(&self) -> Outliers {
        let spread = self.spread();
        let hot = |pixel: usize| {
            let (n, mean) = (self.counts[pixel], self.means[pixel]);
            if n < LEAST_RATIO * mean { 0.0 } else { ln_tail(n, mean * (1.0 + 3.0 * spread)) }
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

    /// Count of a pixel, and what is expected.
    pub(super) fn at(&self, pixel: u32) -> (f64, f64) {
        (self.counts[pixel as usize], self.means[pixel as usize])
    }

    /// Neighbours' lower quartile of a pixel.
    pub(super) fn quartile(&self, pixel: u32) -> f64 {
        self.quartiles[pixel as usize]
    }

    /// Whether a pixel without any event is nothing special anywhere.
    pub(super) fn is_sparse(&self) -> bool {
        let pixels = self.counts.len() as f64;
        self.quartiles.iter().all(|quartile| *quartile < (pixels / FALSE_PART).ln())
    }

    /// How much pixels differ from their neighbours beyond chance, as a part of the count.
    fn spread(&self) -> f64 {
        let busy = self.counts.iter().zip(&self.means).filter(|(_, mean)| **mean >= LEAST_MEAN);
        let mut apart: Vec<(f64, f64)> =
            busy.map(|(n, mean)| ((n - mean).abs() / mean, 1.0 / mean)).collect();
        if apart.is_empty() {
            return 0.0;
        }
        apart.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median, chance) = apart[apart.len() / 2];
        ((1.4826 * median).powi(2) - chance).max(0.0).sqrt()
    }

    /// Pixels whose logarithm of the p-value passes.
    fn discoveries(&self, ln_p: impl Fn(usize) -> f64) -> Vec<u32> {
        let mut ranked: Vec<(f64, u32)> = (0..self.counts.len())
            .map(|pixel| (ln_p(pixel), pixel as u32))
            .filter(|(ln_p, _)| *ln_p < 0.0)
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let pixels = self.counts.len() as f64;
        let passes = |(rank, (ln_p, _)): (usize, &(f64, u32))| {
            *ln_p <= (FALSE_PART * (rank + 1) as f64 / pixels).ln()
        };
        let last = ranked.iter().enumerate().rposition(passes);
        let mut found: Vec<u32> =
            ranked[..last.map_or(0, |rank| rank + 1)].iter().map(|(_, pixel)| *pixel).collect();
        found.sort_unstable();
        found
    }
}

/// Logarithm of the probability that a Poisson variable of this mean is at least `n`, for `n`
/// above the mean: the first term and the ratio of the rest to it.
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
