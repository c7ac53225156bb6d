//! Leaves over leaves, brighter towards the front.

use std::f32::consts::TAU;

use evpose_core::CounterRng;
use glam::{Vec2, Vec3A};

use crate::texture::canvas::Canvas;

/// Leaves, from the back to the front.
const LEAVES: usize = 420;

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let sky = Vec3A::new(0.75, 0.85, 0.95) * rng.uniform(0.2, 1.0);
    let mut canvas = Canvas::filled(width, height, sky);
    let (w, h) = (canvas.width(), canvas.height());
    let autumn = rng.unit();
    for leaf in 0..LEAVES {
        let front = leaf as f32 / LEAVES as f32;
        let centre = Vec2::new(rng.uniform(0.0, w), rng.uniform(0.0, h));
        // Later leaves are nearer: larger, and brighter.
        let long = rng.uniform(0.015, 0.05) * w * (0.6 + front);
        let radii = Vec2::new(long, long * rng.uniform(0.25, 0.6));
        let green = Vec3A::new(0.25, 0.6, 0.15);
        let red = Vec3A::new(0.8, 0.45, 0.12);
        let colour = green.lerp(red, (autumn * rng.uniform(0.0, 1.3)).min(1.0))
            * rng.uniform(0.3, 0.6 + 0.8 * front);
        let brown = Vec3A::new(0.2, 0.14, 0.1);
        canvas.ellipse(centre, radii, rng.uniform(0.0, TAU), |inside, _| {
            // A vein along the middle, and one half in the other's shade.
            if inside.y.abs() < 0.08 {
                brown
            } else {
                colour * if inside.y > 0.0 { 1.15 } else { 0.75 }
            }
        });
    }
    canvas
}
