//! Stripes of two directions over a gradient, as of blinds, rugs and cloth.

use std::f32::consts::{FRAC_PI_2, PI};

use evpose_core::CounterRng;
use glam::Vec2;

use crate::texture::canvas::{Canvas, Rect, random_colour};

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let (from, to) =
        (random_colour(rng, (0.0, 0.8), (0.6, 1.0)), random_colour(rng, (0.0, 0.8), (0.15, 0.5)));
    let mut canvas = Canvas::filled(width, height, from);
    let (w, h) = (canvas.width(), canvas.height());
    let whole = canvas.whole();
    canvas.paint(whole, |at, _| from.lerp(to, at.y / h));
    let base_rad = rng.uniform(0.0, PI);
    for layer in 0..3 {
        // More or less at right angles, as threads of a cloth are.
        let angle_rad = base_rad + FRAC_PI_2 * layer as f32 + rng.uniform(-0.3, 0.3);
        let direction = Vec2::from_angle(angle_rad);
        let period = rng.uniform(0.03, 0.12) * w;
        let duty = rng.uniform(0.2, 0.6);
        let colour = random_colour(rng, (0.0, 0.9), (0.05, 1.0));
        let cover = rng.uniform(0.6, 1.0);
        let (cx, cy) = (rng.uniform(0.2, 0.8) * w, rng.uniform(0.2, 0.8) * h);
        // The first layer is everywhere, the others are cloths upon it.
        let area = if layer == 0 {
            whole
        } else {
            Rect::new(cx - 0.3 * w, cy - 0.3 * h, cx + 0.3 * w, cy + 0.3 * h)
        };
        canvas.paint(area, |at, old| {
            let phase = (at.dot(direction) / period).rem_euclid(1.0);
            if phase < duty { old.lerp(colour, cover) } else { old }
        });
    }
    canvas
}
