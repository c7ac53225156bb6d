//! Shortest path through a sequence of gates (the taut-string algorithm).
//!
//! Frames bound luminance between two values. The shortest path between the bounds has no steps
//! that they do not force: luminance at rest stays constant although its codes flicker by one, and
//! drifts are uniform.

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gate {
    /// Time, in any unit.
    pub(super) t: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Computes the shortest path from the middle of the first gate to that of the last: its value at
/// each.
pub(super) fn shortest(gates: &[Gate], path: &mut Vec<f64>) {
    path.clear();
    let (Some(first), Some(last)) = (gates.first(), gates.last()) else { return };
    path.push(middle(*first));
    let (mut at, mut value) = (0, middle(*first));
    while at + 1 < gates.len() {
        // Range of slopes that pass all gates so far, and the gates that bound it.
        let (mut min_slope, mut max_slope) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut bend_up, mut bend_down) = (at + 1, at + 1);
        let mut bend = None;
        for (k, gate) in gates.iter().enumerate().skip(at + 1) {
            let end = if k + 1 == gates.len() { Some(middle(*last)) } else { None };
            let lasts = gate.t - gates[at].t;
            let low = (end.unwrap_or(gate.low) - value) / lasts;
            let high = (end.unwrap_or(gate.high) - value) / lasts;
            if low > max_slope {
                bend = Some((bend_down, gates[bend_down].high));
                break;
            }
            if high < min_slope {
                bend = Some((bend_up, gates[bend_up].low));
                break;
            }
            if low >= min_slope {
                (min_slope, bend_up) = (low, k);
            }
            if high <= max_slope {
                (max_slope, bend_down) = (high, k);
            }
        }
        // Without a bend it goes straight to the end.
        let (to, reached) = bend.unwrap_or((gates.len() - 1, middle(*last)));
        let slope = (reached - value) / (gates[to].t - gates[at].t);
        path.extend(gates[at + 1..=to].iter().map(|gate| value + slope * (gate.t - gates[at].t)));
        (at, value) = (to, reached);
    }
}

fn middle(gate: Gate) -> f64 {
    0.5 * (gate.low + gate.high)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn path(middles: &[f64], half: f64) -> Vec<f64> {
        let gate = |(k, m): (usize, &f64)| Gate { t: k as f64, low: m - half, high: m + half };
        let gates: Vec<Gate> = middles.iter().enumerate().map(gate).collect();
        let mut path = Vec::new();
        shortest(&gates, &mut path);
        path
    }

    #[test]
    fn codes_that_flicker_by_one_are_light_at_rest() {
        assert_eq!(path(&[7.0, 8.0, 7.0, 7.0, 8.0, 7.0], 0.5), [7.0, 7.5, 7.5, 7.5, 7.5, 7.0]);
        assert_eq!(path(&[7.0, 8.0, 7.0, 7.0, 8.0, 7.0], 1.0), [7.0; 6]);
    }

    #[test]
    fn stairs_are_a_drift_and_an_edge_stays_one() {
        let drift = path(&[3.0, 3.0, 4.0, 4.0, 5.0, 5.0, 6.0, 6.0], 0.5);
        let steps: Vec<f64> = drift.windows(2).map(|two| two[1] - two[0]).collect();
        assert!(steps.iter().all(|step| (0.3..0.6).contains(step)), "{drift:?}");
        assert_eq!(path(&[1.0, 1.0, 90.0, 90.0], 0.5), [1.0, 1.5, 89.5, 90.0]);
        assert_eq!(path(&[4.0], 0.5), [4.0]);
    }

    proptest! {
        #[test]
        fn the_path_passes_every_gate_and_is_no_longer_than_the_middles(
            middles in prop::collection::vec(-9.0..9.0_f64, 2..30), half in 0.01..3.0_f64,
        ) {
            let path = path(&middles, half);
            prop_assert_eq!(path.len(), middles.len());
            for (value, middle) in path.iter().zip(&middles) {
                prop_assert!((value - middle).abs() <= half + 1e-9);
            }
            let length = |values: &[f64]| -> f64 {
                values.windows(2).map(|two| (two[1] - two[0]).hypot(1.0)).sum()
            };
            prop_assert!(length(&path) <= length(&middles) + 1e-9);
        }
    }
}
