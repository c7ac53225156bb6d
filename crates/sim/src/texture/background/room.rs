//! An interior: wall, floor, windows, framed prints, cabinets and a lamp.

use evpose_core::CounterRng;
use glam::{Vec2, Vec3A};

use crate::texture::canvas::{Canvas, Rect, random_colour};

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let mut canvas = Canvas::filled(width, height, random_colour(rng, (0.0, 0.3), (0.5, 0.9)));
    let (w, h) = (canvas.width(), canvas.height());
    let floor = h * rng.uniform(0.55, 0.8);
    let ground = random_colour(rng, (0.2, 0.6), (0.2, 0.5));
    // From back to front: later strokes cover earlier ones.
    canvas.paint(Rect::new(0.0, floor, w, h), |at, _| ground * (0.7 + 0.5 * (at.y - floor) / h));
    canvas.rect(Rect::new(0.0, floor - 0.02 * h, w, floor), Vec3A::splat(rng.uniform(0.1, 0.95)));
    let skirting = floor;
    for _ in 0..3 {
        let (left, top) = (rng.uniform(-0.1, 0.9) * w, rng.uniform(0.0, 0.35) * h);
        let frame = Rect::new(
            left,
            top,
            left + rng.uniform(0.12, 0.3) * w,
            top + rng.uniform(0.15, 0.4) * h,
        );
        framed_field(&mut canvas, frame, rng);
    }
    for _ in 0..9 {
        let (bw, bh) = (rng.uniform(0.06, 0.25) * w, rng.uniform(0.08, 0.4) * h);
        // What is nearer than the wall stands lower on the image.
        let left = rng.uniform(-0.1, 1.0) * w;
        let foot = skirting + rng.uniform(-0.05, 0.3) * h;
        cabinet(&mut canvas, Rect::new(left, foot - bh, left + bw, foot), rng);
    }
    lamp(&mut canvas, rng);
    canvas
}

/// A window or a framed print: a frame around bars over a bright or coloured field.
fn framed_field(canvas: &mut Canvas, frame: Rect, rng: &mut CounterRng) {
    canvas.rect(frame, Vec3A::splat(rng.uniform(0.05, 0.3)));
    let inner = frame.inset(0.02 * canvas.width());
    let (upper, lower) =
        (random_colour(rng, (0.0, 0.4), (0.8, 1.0)), random_colour(rng, (0.2, 0.8), (0.3, 0.9)));
    canvas.paint(inner, |at, _| upper.lerp(lower, (at.y - inner.top) / inner.height()));
    if rng.chance(0.6) {
        let (x, y) = (0.5 * (inner.left + inner.right), 0.5 * (inner.top + inner.bottom));
        let bar = 0.006 * canvas.width();
        canvas.rect(Rect::new(x - bar, inner.top, x + bar, inner.bottom), Vec3A::splat(0.2));
        canvas.rect(Rect::new(inner.left, y - bar, inner.right, y + bar), Vec3A::splat(0.2));
    }
}

/// A box with a lit top, a dark side and drawers.
fn cabinet(canvas: &mut Canvas, front: Rect, rng: &mut CounterRng) {
    let colour = random_colour(rng, (0.1, 0.9), (0.15, 0.95));
    let depth = 0.12 * front.width() + 4.0;
    canvas.rect(front, colour);
    // Light from above: the top is brighter than the front, the side darker.
    canvas.rect(Rect::new(front.left, front.top - depth, front.right, front.top), colour * 1.3);
    canvas.rect(Rect::new(front.right, front.top, front.right + depth, front.bottom), colour * 0.4);
    let drawers = 1 + rng.below(4);
    let step = front.height() / drawers as f32;
    for drawer in 0..drawers {
        let y = front.top + step * drawer as f32;
        canvas.rect(Rect::new(front.left, y, front.right, y + 2.0), colour * 0.3);
        let handle = Vec2::new(0.5 * (front.left + front.right), y + 0.5 * step);
        canvas.ellipse(handle, Vec2::splat(3.0), 0.0, |_, _| Vec3A::splat(0.9));
    }
}

/// A shining ball on a stand.
fn lamp(canvas: &mut Canvas, rng: &mut CounterRng) {
    let radius = rng.uniform(0.03, 0.08) * canvas.width();
    let centre =
        Vec2::new(rng.uniform(0.1, 0.9) * canvas.width(), rng.uniform(0.1, 0.5) * canvas.height());
    let foot = Vec2::new(centre.x, canvas.height());
    canvas.stroke(centre, foot, 0.012 * canvas.width(), Vec3A::splat(0.08));
    canvas.ellipse(centre, Vec2::splat(radius), 0.0, |inside, _| {
        Vec3A::new(1.0, 0.95, 0.8) * (1.0 - 0.4 * inside.length_squared())
    });
}
