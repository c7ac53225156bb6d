//! `pan`: a world of polygons (lines across a plane, one shade for each side) behind a camera
//! that shakes, and a still frame of soft grey around two sides.

use super::shape::{SOFTEST_PX, blend, edge, edge_width_px, wave};
use super::steps::Tiles;
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

/// Lines that cut the world into polygons.
const LINES: usize = 10;

#[derive(Debug, Clone)]
struct Line {
    normal: [f64; 2],
    distance_px: f64,
    half_contrast_ln: f64,
}

#[derive(Debug, Clone, Copy)]
struct Sway {
    reach_px: f64,
    turns_hz: f64,
    phase: f64,
}

/// The world, the shake and the still frame.
#[derive(Debug, Clone)]
pub(super) struct Pan {
    lines: Vec<Line>,
    middle_ln: f64,
    sways: [[Sway; 2]; 2],
    width_px: f64,
    still: Tiles<4, 4>,
    still_px: f64,
}

impl Pan {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let sway = |draws: &mut Sequence, low: f64, high: f64, hz: [f64; 2]| Sway {
            reach_px: draws.between(low, high),
            turns_hz: draws.between(hz[0], hz[1]),
            phase: draws.between(0.0, 1.0),
        };
        let sways = std::array::from_fn(|_| {
            [sway(draws, 8.0, 14.0, [1.6, 3.0]), sway(draws, 1.5, 3.0, [4.0, 7.0])]
        });
        // A wave's largest slope is 8 amplitudes per turn.
        let fastest = |axis: &[Sway; 2]| -> f64 {
            axis.iter().map(|s: &Sway| 8.0 * s.reach_px * s.turns_hz).sum()
        };
        let speed_px_s = fastest(&sways[0]).hypot(fastest(&sways[1]));
        let mut shares: Vec<f64> = (0..LINES).map(|_| draws.between(0.4, 1.0)).collect();
        let total: f64 = shares.iter().sum();
        // All lines on one side reach from .022 to .95.
        shares.iter_mut().for_each(|share| *share *= 1.88 / total);
        let lines = shares
            .into_iter()
            .map(|half_contrast_ln| {
                let angle = draws.between(0.0, std::f64::consts::TAU);
                Line {
                    normal: [angle.cos(), angle.sin()],
                    distance_px: draws.between(-34.0, 34.0),
                    half_contrast_ln: half_contrast_ln * draws.sign(),
                }
            })
            .collect();
        Self {
            lines,
            middle_ln: -1.93,
            sways,
            // Edges as wide as the fastest shake needs to be smooth in time.
            width_px: edge_width_px(speed_px_s),
            still: Tiles::new(draws, -3.8, -0.1),
            still_px: draws.between(4.0, 7.0),
        }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let inward =
            (WIDTH as f64 - 1.0 - x_px).min(x_px).min(HEIGHT as f64 - 1.0 - y_px).min(y_px);
        let seen = edge(inward - self.still_px, SOFTEST_PX);
        let world = if seen > 0.0 { self.world(x_px, y_px, t_s) } else { 0.0 };
        if seen < 1.0 { blend(self.still.at(x_px, y_px), world, seen) } else { world }
    }

    fn world(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let shift = |axis: &[Sway; 2]| -> f64 {
            axis.iter().map(|s| s.reach_px * wave(s.turns_hz * t_s + s.phase)).sum()
        };
        let x = x_px - 0.5 * WIDTH as f64 + shift(&self.sways[0]);
        let y = y_px - 0.5 * HEIGHT as f64 + shift(&self.sways[1]);
        self.lines.iter().fold(self.middle_ln, |sum, line| {
            let side = line.normal[0] * x + line.normal[1] * y - line.distance_px;
            // A line brightens one side as much as it darkens the other, so that the middle stays.
            sum + line.half_contrast_ln * (2.0 * edge(side, self.width_px) - 1.0)
        })
    }
}
