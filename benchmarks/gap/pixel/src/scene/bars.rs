//! `bars`: six bands; four carry gratings of their own period, slant and speed (10 to 500 px/s),
//! two are still steps of grey.

use super::DARKEST_LN;
use super::shape::{SOFTEST_PX, blend, edge, wave};
use super::steps::along_steps;
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

/// Bands from top to bottom.
const BANDS: usize = 6;

#[derive(Debug, Clone)]
enum Band {
    Grating { mean_ln: f64, half_range_ln: f64, waves_per_px: [f64; 2], turns_hz: f64 },
    Still([f64; 6]),
}

#[derive(Debug, Clone)]
pub(super) struct Bars {
    bands: [Band; BANDS],
}

impl Bars {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        // Each grating has a range of speeds of its own: every scene has slow and fast edges.
        let mut speeds = [draws.log_between(10.0, 25.0), draws.log_between(30.0, 80.0), 0.0, 0.0];
        speeds[2] = draws.log_between(100.0, 220.0);
        speeds[3] = draws.log_between(300.0, 500.0);
        let still = |draws: &mut Sequence| {
            Band::Still(std::array::from_fn(|_| draws.between(DARKEST_LN, 0.0)))
        };
        let mut bands = [
            grating(draws, speeds[0]),
            grating(draws, speeds[1]),
            grating(draws, speeds[2]),
            grating(draws, speeds[3]),
            still(draws),
            still(draws),
        ];
        draws.shuffle(&mut bands);
        Self { bands }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let band_px = HEIGHT as f64 / BANDS as f64;
        let position = ((y_px + 0.5) / band_px).clamp(0.0, BANDS as f64);
        let border = position.round();
        let above = (border as usize).saturating_sub(1).min(BANDS - 1);
        let below = (border as usize).min(BANDS - 1);
        let share = edge((position - border) * band_px, SOFTEST_PX);
        // Away from a border one band is enough.
        if share <= 0.0 {
            self.bands[above].at(x_px, y_px, t_s)
        } else if share >= 1.0 {
            self.bands[below].at(x_px, y_px, t_s)
        } else {
            let band = |b: usize| self.bands[b].at(x_px, y_px, t_s);
            blend(band(above), band(below), share)
        }
    }
}

/// A grating of this speed across its stripes; at most 10 periods a second.
fn grating(draws: &mut Sequence, speed_px_s: f64) -> Band {
    let period_px = draws.log_between(9.0, 26.0).max(speed_px_s / 10.0);
    let half_range_ln = draws.between(0.3, 0.65);
    // The whole wave stays within the range of light that a scene may have.
    let mean_ln = draws.between(DARKEST_LN + half_range_ln, -half_range_ln);
    let slant = draws.between(-0.5, 0.5);
    let direction = draws.sign();
    Band::Grating {
        mean_ln,
        half_range_ln,
        waves_per_px: [slant.cos() / period_px, slant.sin() / period_px],
        turns_hz: direction * speed_px_s / period_px,
    }
}

impl Band {
    fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        match self {
            Self::Grating { mean_ln, half_range_ln, waves_per_px, turns_hz } => {
                let turns = x_px * waves_per_px[0] + y_px * waves_per_px[1] - turns_hz * t_s;
                mean_ln + half_range_ln * wave(turns)
            }
            Self::Still(levels) => along_steps(levels, (x_px + 0.5) / WIDTH as f64, WIDTH as f64),
        }
    }
}
