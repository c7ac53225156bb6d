//! `blobs`: eleven soft bright or dark blobs on closed orbits over still tiles, up to 300 px/s.

use super::DARKEST_LN;
use super::shape::{blend, bump, wave};
use super::steps::Tiles;
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

#[derive(Debug, Clone)]
struct Blob {
    centre_px: [f64; 2],
    reach_px: [f64; 2],
    turns_hz: f64,
    phase: [f64; 2],
    radius_px: f64,
    level_ln: f64,
}

#[derive(Debug, Clone)]
pub(super) struct Blobs {
    ground: Tiles<2, 3>,
    blobs: Vec<Blob>,
}

impl Blobs {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let ground = Tiles::new(draws, DARKEST_LN, -0.1);
        let blobs = (0..11)
            .map(|i| {
                // From 14 to 300 px/s in equal ratios: slow and fast blobs are as frequent.
                let speed_px_s = 14.0 * (300.0_f64 / 14.0).powf(f64::from(i) / 10.0);
                let reach = draws.between(8.0, 24.0);
                Blob {
                    centre_px: [
                        draws.between(0.15, 0.85) * WIDTH as f64,
                        draws.between(0.15, 0.85) * HEIGHT as f64,
                    ],
                    reach_px: [reach, reach * draws.between(0.4, 1.0)],
                    // A wave's largest slope is 8 amplitudes per turn.
                    turns_hz: speed_px_s / (8.0 * reach),
                    phase: [draws.between(0.0, 1.0), draws.between(0.0, 1.0)],
                    // Fast blobs are large: none passes a pixel in less than a fixed time.
                    radius_px: draws.between(6.0, 14.0).max(speed_px_s / 35.0),
                    level_ln: if i % 2 == 0 {
                        draws.between(-1.0, -0.05)
                    } else {
                        draws.between(DARKEST_LN, -2.6)
                    },
                }
            })
            .collect();
        Self { ground, blobs }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let ground = self.ground.at(x_px, y_px);
        self.blobs.iter().fold(ground, |under, blob| {
            let turns = blob.turns_hz * t_s;
            let dx = x_px - blob.centre_px[0] - blob.reach_px[0] * wave(turns + blob.phase[0]);
            let dy = y_px - blob.centre_px[1] - blob.reach_px[1] * wave(turns + blob.phase[1]);
            let r2 = (dx * dx + dy * dy) / (blob.radius_px * blob.radius_px);
            if r2 < 1.0 { blend(under, blob.level_ln, bump(r2)) } else { under }
        })
    }
}
