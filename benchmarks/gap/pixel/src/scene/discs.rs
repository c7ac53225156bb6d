//! `discs`: eight textured discs, 10 to 500 px/s, over a ground that shades from dark to bright.

use super::disc::Disc;
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

#[derive(Debug, Clone)]
pub(super) struct Discs {
    middle_ln: f64,
    slope_ln: [f64; 2],
    discs: Vec<Disc>,
}

impl Discs {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let slope_ln = [draws.sign() * draws.between(0.8, 1.6), draws.sign() * 0.3];
        let middle_ln = draws.between(-2.0, -1.6);
        let speeds = [12.0, 25.0, 45.0, 80.0, 130.0, 200.0, 320.0, 480.0];
        let mut discs = Vec::with_capacity(speeds.len());
        for speed_px_s in speeds {
            let speed_px_s = speed_px_s * draws.between(0.85, 1.04);
            discs.push(Disc::new(draws, speed_px_s));
        }
        Self { middle_ln, slope_ln, discs }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let across = 2.0 * x_px / WIDTH as f64 - 1.0;
        let down = 2.0 * y_px / HEIGHT as f64 - 1.0;
        let ground = self.middle_ln + self.slope_ln[0] * across + self.slope_ln[1] * down;
        self.discs.iter().fold(ground, |under, disc| disc.over(under, x_px, y_px, t_s))
    }
}
