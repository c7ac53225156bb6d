//! Displacement of parts of the image between the model and the recording.

use serde::{Deserialize, Serialize};

use crate::View;
use crate::probe::{TILES, displacements};

/// Tolerance of a displacement, pixels, beyond this many standard deviations of runs of the model.
const TOLERANCE_PX: f64 = 0.1;
const SPREADS: f64 = 3.0;

/// Displacement of a part of the image, from the model to the recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Arrow {
    /// Column of its centre, as a fraction of the width.
    pub x: f64,
    /// Row of its centre, as a fraction of the height.
    pub y: f64,
    /// Displacement to the right, pixels.
    pub dx_px: f64,
    /// Displacement downwards, pixels.
    pub dy_px: f64,
    /// Whether it is significant and beyond tolerance.
    pub is_significant: bool,
}

/// Arrows of all parts of the image with enough motion to determine a displacement.
pub(super) fn arrows(measured: &View<'_>, runs: &[View<'_>]) -> Vec<Arrow> {
    let of_measured = displacements(measured);
    let of_runs: Vec<_> = runs.iter().map(displacements).collect();
    let arrow = |(tile, displacement): (usize, &Option<(f64, f64)>)| {
        let (x, y) = (*displacement)?;
        let others: Vec<(f64, f64)> = of_runs.iter().filter_map(|run| run[tile]).collect();
        let n = others.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| others.iter().map(of).sum::<f64>() / n;
        let (mean_x, mean_y) = (mean(|d| d.0), mean(|d| d.1));
        let squares = others.iter().map(|d| (d.0 - mean_x).powi(2) + (d.1 - mean_y).powi(2));
        let spread = (squares.sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
        // Less that of runs of the model: the estimate has a bias of its own where edges curve.
        let (dx_px, dy_px) = (x - mean_x, y - mean_y);
        let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        // Without a run there is nothing to compare with.
        (n > 0.0).then(|| Arrow {
            x: centre(tile % TILES.0, TILES.0),
            y: centre(tile / TILES.0, TILES.1),
            dx_px,
            dy_px,
            is_significant: dx_px.hypot(dy_px) > TOLERANCE_PX + SPREADS * spread,
        })
    };
    of_measured.iter().enumerate().filter_map(arrow).collect()
}

#[cfg(test)]
mod tests {
    use evpose_core::Event;

    use super::*;
    use crate::probe::testing;

    #[test]
    fn a_shift_shows_as_arrows_that_agree() {
        let shifted =
            testing::changed(|event| (event.x < 94).then(|| Event { x: event.x + 2, ..event }));
        let view = |events| View::new(testing::reference_scene(), events, testing::whole());
        let own = view(testing::events());
        let shift = arrows(&view(&shifted), &[view(testing::events())]);
        assert!(shift.len() > 4, "{}", shift.len());
        for arrow in &shift {
            let Arrow { dx_px, dy_px, is_significant, .. } = *arrow;
            assert!(is_significant && (dx_px - 2.0).abs() < 1.0 && dy_px.abs() < 0.6, "{arrow:?}");
        }
        let none = arrows(&own, &[view(testing::events())]);
        assert!(none.iter().all(|arrow| !arrow.is_significant));
    }
}
