//! Soft edges and waves all scenes are made of: piecewise parabolas and cubics, smooth and cheap.

/// Smallest width of any edge in pixels.
pub(crate) const SOFTEST_PX: f64 = 1.5;

/// Fastest an edge may pass, in edge widths per second: at 100 an edge takes 10 frames of 1 ms.
const PASSES_PER_S: f64 = 100.0;

/// Width in pixels of an edge that moves with `speed_px_s`.
pub(crate) fn edge_width_px(speed_px_s: f64) -> f64 {
    (speed_px_s / PASSES_PER_S).max(SOFTEST_PX)
}

/// 0 below `-width/2`, 1 above `width/2`, a cubic in between (slope `1.5 / width` at 0).
#[inline]
pub(crate) fn edge(distance: f64, width: f64) -> f64 {
    let s = (distance / width + 0.5).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Parabolic arcs in place of a sine: period 1, amplitude 1, largest slope 8, curvature 32.
#[inline]
pub(crate) fn wave(turns: f64) -> f64 {
    let phase = 2.0 * (turns - turns.floor()) - 1.0;
    4.0 * phase * (phase.abs() - 1.0)
}

/// A bump of height 1 that ends smoothly at radius 1: `(1 - r^2)^2`.
#[inline]
pub(crate) fn bump(radius_squared: f64) -> f64 {
    let left = (1.0 - radius_squared).max(0.0);
    left * left
}

#[inline]
pub(crate) fn blend(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_rises_through_zero_and_peaks_after_a_quarter_turn() {
        assert!(wave(0.0).abs() < 1e-12);
        assert!((wave(0.25) - 1.0).abs() < 1e-12);
        assert!((wave(0.75) + 1.0).abs() < 1e-12);
        assert!((wave(0.1) + wave(0.6)).abs() < 1e-12);
    }

    #[test]
    fn an_edge_is_half_way_at_its_middle_and_done_at_its_ends() {
        for (distance, share) in [(-2.0, 0.0), (-1.0, 0.0), (0.0, 0.5), (1.0, 1.0), (5.0, 1.0)] {
            assert!((edge(distance, 2.0) - share).abs() < 1e-12);
        }
    }
}
