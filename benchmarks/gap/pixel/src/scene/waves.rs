//! `waves`: three travelling waves (10 to 300 px/s) inside round windows; still steps outside.

use super::DARKEST_LN;
use super::shape::{edge, wave};
use super::steps::Tiles;
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

#[derive(Debug, Clone)]
struct Travelling {
    half_range_ln: f64,
    waves_per_px: [f64; 2],
    turns_hz: f64,
}

#[derive(Debug, Clone)]
struct Window {
    centre_px: [f64; 2],
    radius_px: f64,
}

/// Ground, waves, and the windows they are seen through.
#[derive(Debug, Clone)]
pub(super) struct Waves {
    ground: Tiles<2, 3>,
    waves: Vec<Travelling>,
    windows: Vec<Window>,
}

impl Waves {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        // The waves add at most .95 either way.
        let ground = Tiles::new(draws, DARKEST_LN + 0.95, -0.95);
        let waves = [(12.0, 40.0, 0.3), (50.0, 120.0, 0.4), (150.0, 300.0, 0.25)]
            .map(|(slow, fast, half_range_ln)| {
                let speed_px_s = draws.log_between(slow, fast);
                // Fast waves are long: no pixel sees more than 18 turns a second.
                let period_px = draws.between(12.0, 26.0).max(speed_px_s / 18.0);
                let angle = draws.between(0.0, std::f64::consts::TAU);
                Travelling {
                    half_range_ln,
                    waves_per_px: [angle.cos() / period_px, angle.sin() / period_px],
                    turns_hz: speed_px_s / period_px,
                }
            })
            .to_vec();
        let windows = (0..3)
            .map(|third| Window {
                centre_px: [
                    (f64::from(third) + draws.between(0.3, 0.7)) * WIDTH as f64 / 3.0,
                    draws.between(0.3, 0.7) * HEIGHT as f64,
                ],
                radius_px: draws.between(15.0, 22.0),
            })
            .collect();
        Self { ground, waves, windows }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let ground = self.ground.at(x_px, y_px);
        let seen = self.windows.iter().fold(0.0_f64, |most, window| {
            let dx = x_px - window.centre_px[0];
            let dy = y_px - window.centre_px[1];
            most.max(edge(window.radius_px - dx.hypot(dy), 6.0))
        });
        // Most of the image is ground: sines are computed in the windows alone.
        if seen <= 0.0 {
            return ground;
        }
        let sum: f64 = self
            .waves
            .iter()
            .map(|w| {
                let turns = x_px * w.waves_per_px[0] + y_px * w.waves_per_px[1] - w.turns_hz * t_s;
                w.half_range_ln * wave(turns)
            })
            .sum();
        ground + seen * sum
    }
}
