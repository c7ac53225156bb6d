//! A textured disc that crosses the image on a straight line and comes in again.

use super::DARKEST_LN;
use super::shape::{blend, edge, edge_width_px, wave};
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

/// One disc; speeds in px/s.
#[derive(Debug, Clone)]
pub(super) struct Disc {
    start_px: [f64; 2],
    velocity_px_s: [f64; 2],
    radius_px: f64,
    width_px: f64,
    level_ln: f64,
    texture_ln: f64,
    waves_per_px: [f64; 2],
}

impl Disc {
    /// A disc of this speed; its radius, level and texture are drawn.
    pub(super) fn new(draws: &mut Sequence, speed_px_s: f64) -> Self {
        let angle = draws.between(0.0, std::f64::consts::TAU);
        let width_px = edge_width_px(speed_px_s);
        // A disc smaller than its soft edge would never reach its own level.
        let radius_px = draws.between(5.0, 13.0).max(1.2 * width_px);
        // At most 15 periods a second pass a pixel.
        let period_px = draws.between(8.0, 16.0).max(speed_px_s / 15.0);
        let tilt = draws.between(0.0, std::f64::consts::TAU);
        let level_ln = draws.between(DARKEST_LN + 0.5, -0.5);
        Self {
            start_px: [draws.between(0.0, WIDTH as f64), draws.between(0.0, HEIGHT as f64)],
            velocity_px_s: [speed_px_s * angle.cos(), speed_px_s * angle.sin()],
            radius_px,
            width_px,
            level_ln,
            texture_ln: draws.between(0.1, 0.45),
            waves_per_px: [tilt.cos() / period_px, tilt.sin() / period_px],
        }
    }

    /// Paints the disc over `ground`.
    pub(super) fn over(&self, ground: f64, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        // The soft edge lies half outside of the radius.
        let reach = self.radius_px + 0.5 * self.width_px;
        let offset = |place: f64, axis: usize, length: f64| {
            // Around a torus that is one disc larger than the image: it never jumps in sight.
            let period = length + 2.0 * reach;
            let d = place - self.start_px[axis] - self.velocity_px_s[axis] * t_s;
            d - period * (d / period + 0.5).floor()
        };
        let dx = offset(x_px, 0, WIDTH as f64);
        // Most pixels are left here: their column does not meet the disc.
        if dx.abs() >= reach {
            return ground;
        }
        let dy = offset(y_px, 1, HEIGHT as f64);
        let squared = dx * dx + dy * dy;
        if squared >= reach * reach {
            return ground;
        }
        // Soft, so that luminance is continuous in time.
        let cover = edge(self.radius_px - squared.sqrt(), self.width_px);
        let turns = dx * self.waves_per_px[0] + dy * self.waves_per_px[1];
        blend(ground, self.level_ln + self.texture_ln * wave(turns), cover)
    }
}
