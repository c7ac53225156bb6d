//! How much the numbers of a comparison depend on what is not known of its scene.

use crate::{Kind, Layout};

/// Standard deviations between looks that do not count.
const TOLERATED: f64 = 3.0;
/// Numbers that looks move by more than this, as a share of all events or as a multiple of what
/// does not matter anyway, say nothing here and are not compared.
const LARGEST_SHARE: f64 = 0.05;
const LARGEST_MULTIPLE: f64 = 20.0;

/// How much looks differ, number by number, on the scale of its tolerance.
pub(super) struct Spread {
    /// Sums of squares of the three parts; infinite where a look has no such number.
    squares: [Vec<f64>; 3],
    /// How many looks there are.
    looks: u64,
}

impl Spread {
    /// Nothing yet of so many looks.
    pub(super) fn of(layout: &Layout, looks: u64) -> Self {
        Self { squares: [0, 1, 2].map(|_| vec![0.0; layout.entries.len()]), looks }
    }

    /// Adds the numbers of a look to those of part number `part` of the data, whose own are `own`.
    pub(super) fn add(&mut self, part: usize, layout: &Layout, own: &[f64], look: &[f64]) {
        let events = layout.events(own).max(1.0);
        let number_of = |value: f64| 0.25 * value * value;
        for (i, sum) in self.squares[part].iter_mut().enumerate() {
            let (a, b) = (own[i], look[i]);
            if a.is_nan() && b.is_nan() {
                continue;
            }
            let apart = match layout.entries[i].kind {
                Kind::Count(_) => (number_of(b) - number_of(a)) / events,
                Kind::Number(_) => b - a,
            };
            *sum += if apart.is_finite() { apart * apart } else { f64::INFINITY };
        }
    }

    /// Widens the tolerances of `layout` by as much as looks differ.
    pub(super) fn widen(&self, layout: &mut Layout) {
        for (i, entry) in layout.entries.iter_mut().enumerate() {
            let most = self.squares.iter().map(|part| part[i]).fold(0.0, f64::max);
            let apart = TOLERATED * (most / self.looks as f64).sqrt();
            let (tolerance, largest) = match &mut entry.kind {
                Kind::Count(share) => (share, LARGEST_SHARE),
                Kind::Number(own) => {
                    let largest = LARGEST_MULTIPLE * *own;
                    (own, largest)
                }
            };
            *tolerance = if apart > largest { f64::INFINITY } else { tolerance.max(apart) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, Entry};

    const LOOKS: u64 = 8;

    /// A number that looks move far is not compared; one that they move a little is tolerated.
    #[test]
    fn what_looks_differ_by_does_not_count() {
        let mut layout = Layout::of_all_probes();
        let kinds = [Kind::Number(0.1), Kind::Number(0.1), Kind::Count(0.0)];
        let number = |kind| Entry { block: Block::Timing, name: String::new(), kind };
        let first = layout.entries.len();
        layout.entries.extend(kinds.map(number));
        let own = vec![20.0; layout.entries.len()];
        let mut look = own.clone();
        (look[first], look[first + 1]) = (20.2, 30.0);
        let mut spread = Spread::of(&layout, LOOKS);
        (0..LOOKS).for_each(|_| spread.add(1, &layout, &own, &look));
        spread.widen(&mut layout);
        let tolerance = |i: usize| match layout.entries[first + i].kind {
            Kind::Number(tolerance) | Kind::Count(tolerance) => tolerance,
        };
        assert!((tolerance(0) - 0.6).abs() < 1e-9, "{}", tolerance(0));
        assert!(tolerance(1).is_infinite() && tolerance(2) == 0.0);
    }
}
