//! Cross-validated logistic regression.
//!
//! # Source
//! Newton steps with an upper bound of all Hessians: Böhning: *Multinomial logistic regression
//! algorithm*, Ann. Inst. Statist. Math. 44, 1992. The bound depends on the features alone, so that
//! permuted labels need no new matrix.

use evpose_core::stats::linear::solve;

use super::features::COUNT;
use super::patches::{FOLDS, Pair};

/// Features and a constant.
const COLUMNS: usize = COUNT + 1;
/// Newton steps; separable labels are separated after a few.
const STEPS: usize = 12;
/// Ridge per sample, for redundant features.
const RIDGE: f64 = 1e-3;
/// Features are clipped at this many standard deviations from their mean.
const MAX_DEVIATION: f32 = 4.0;

type Row = [f32; COLUMNS];

/// Standardised features of all patches, with what all fits share.
pub(super) struct Data {
    rows: Vec<Row>,
    folds: Vec<usize>,
    /// Inverse of the bound of the Hessian, for each held-out fold.
    inverses: Vec<Vec<[f64; COLUMNS]>>,
}

impl Data {
    /// Standardises all features to mean zero and variance one.
    pub(super) fn from_pairs(pairs: &[Pair]) -> Self {
        let all = || pairs.iter().flat_map(|pair| &pair.features);
        let n = 2.0 * pairs.len() as f64;
        let mut means = [0.0; COUNT];
        let mut sds = [0.0; COUNT];
        for i in 0..COUNT {
            means[i] = all().map(|features| features[i]).sum::<f64>() / n;
            let squares: f64 = all().map(|features| (features[i] - means[i]).powi(2)).sum();
            sds[i] = (squares / n).sqrt().max(1e-9);
        }
        let scaled = |features: &[f64; COUNT]| -> Row {
            std::array::from_fn(|i| match i {
                COUNT => 1.0,
                _ => (((features[i] - means[i]) / sds[i]) as f32)
                    // One outlier must not decide where the others are separated.
                    .clamp(-MAX_DEVIATION, MAX_DEVIATION),
            })
        };
        let rows: Vec<Row> = all().map(scaled).collect();
        let folds: Vec<usize> = pairs.iter().flat_map(|pair| [pair.fold; 2]).collect();
        // Once for all permutations: labels do not occur in the bound of the Hessian.
        let inverses = (0..FOLDS).map(|fold| inverse(&rows, &folds, fold)).collect();
        Self { rows, folds, inverses }
    }

    /// Cross-validated area under the ROC curve: each patch is scored by the fit without its fold.
    pub(super) fn auc(&self, labels: &[bool]) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for fold in 0..FOLDS {
            let weights = self.fit(labels, fold);
            let held_out = (0..self.rows.len()).filter(|i| self.folds[*i] == fold);
            let scores = held_out.map(|i| (product(&weights, &self.rows[i]), labels[i])).collect();
            let (area, pairs) = area(scores);
            // Areas are averaged, not scores pooled: those of different fits have no common scale.
            sum += area;
            weight += pairs;
        }
        if weight > 0.0 { sum / weight } else { 0.5 }
    }

    fn fit(&self, labels: &[bool], held_out: usize) -> Row {
        let mut weights = [0.0; COLUMNS];
        for _ in 0..STEPS {
            let mut gradient = [0.0; COLUMNS];
            let mut used = 0.0;
            for (i, row) in self.rows.iter().enumerate() {
                if self.folds[i] == held_out {
                    continue;
                }
                used += 1.0;
                let p = 1.0 / (1.0 + (-product(&weights, row)).exp());
                let error = f32::from(u8::from(labels[i])) - p;
                for (g, x) in gradient.iter_mut().zip(row) {
                    *g += error * x;
                }
            }
            // The ridge keeps weights finite where a feature separates all patches.
            for (g, w) in gradient.iter_mut().zip(&weights) {
                *g -= RIDGE as f32 * used * w;
            }
            // A step by the bound of the Hessian never overshoots (Boehning 1992).
            for (w, row) in weights.iter_mut().zip(&self.inverses[held_out]) {
                let step: f64 = row.iter().zip(&gradient).map(|(a, g)| a * f64::from(*g)).sum();
                *w += step as f32;
            }
        }
        weights
    }
}

fn product(a: &Row, b: &Row) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverse of a quarter of the second moments, which bounds the Hessian from above.
fn inverse(rows: &[Row], folds: &[usize], held_out: usize) -> Vec<[f64; COLUMNS]> {
    let mut matrix = vec![vec![0.0; COLUMNS]; COLUMNS];
    let mut used = 0.0;
    for (row, _) in rows.iter().zip(folds).filter(|(_, fold)| **fold != held_out) {
        used += 1.0;
        for (out, a) in matrix.iter_mut().zip(row) {
            for (out, b) in out.iter_mut().zip(row) {
                // A label's variance p (1 - p) is at most a quarter.
                *out += 0.25 * f64::from(a * b);
            }
        }
    }
    // A constant feature would make it singular.
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += RIDGE * used + 1e-6;
    }
    (0..COLUMNS)
        .map(|i| {
            let mut unit = vec![0.0; COLUMNS];
            unit[i] = 1.0;
            let column = solve(matrix.clone(), unit).unwrap_or_default();
            std::array::from_fn(|k| column.get(k).copied().unwrap_or(0.0))
        })
        .collect()
}

/// Number of pairs of a true and a false score in which the true one is larger (ties count half),
/// and the number of all pairs.
fn area(mut scores: Vec<(f32, bool)>) -> (f64, f64) {
    scores.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut below, mut area, mut positives) = (0.0, 0.0, 0.0);
    for equal in scores.chunk_by(|a, b| a.0 == b.0) {
        let own = equal.iter().filter(|(_, label)| *label).count() as f64;
        let others = equal.len() as f64 - own;
        // Ties count half, as in the statistic of Mann and Whitney.
        area += own * (below + 0.5 * others);
        below += others;
        positives += own;
    }
    (area, positives * below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_counts_pairs_in_the_right_order() {
        let scores = vec![(0.1, false), (0.4, true), (0.35, false), (0.8, true), (0.4, false)];
        // Of six pairs five are right and one is equal.
        assert_eq!(area(scores), (5.5, 6.0));
    }

    #[test]
    fn an_informative_feature_separates_and_noise_does_not() {
        let mut rng = evpose_core::CounterRng::new(1, "numbers", 0);
        let mut pairs = |shift: f64| -> Vec<Pair> {
            (0..300)
                .map(|i| Pair {
                    features: [0.0, shift].map(|shift| {
                        std::array::from_fn(|k| {
                            let shift = if k == 7 { shift } else { 0.0 };
                            f64::from(rng.normal()) + shift
                        })
                    }),
                    group: i,
                    fold: i % FOLDS,
                })
                .collect()
        };
        let labels: Vec<bool> = (0..600).map(|i| i % 2 == 0).collect();
        let informed = Data::from_pairs(&pairs(2.0)).auc(&labels);
        // Two standard deviations apart: the best possible area is Phi(2 / sqrt 2) = 0.921.
        assert!((0.87..0.94).contains(&informed), "{informed}");
        let chance = Data::from_pairs(&pairs(0.0)).auc(&labels);
        assert!((chance - 0.5).abs() < 0.08, "{chance}");
    }
}
