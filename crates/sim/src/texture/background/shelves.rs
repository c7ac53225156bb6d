//! Book spines on shelves.

use evpose_core::CounterRng;
use glam::Vec3A;

use crate::texture::canvas::{Canvas, Rect, random_colour};

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let mut canvas = Canvas::filled(width, height, Vec3A::splat(0.06));
    let (w, h) = (canvas.width(), canvas.height());
    let wood = random_colour(rng, (0.3, 0.7), (0.3, 0.7));
    let shelves = 3 + rng.below(3);
    let step = h / shelves as f32;
    let board = 0.06 * step;
    for shelf in 0..shelves {
        let foot = step * (shelf + 1) as f32 - board;
        canvas.rect(Rect::new(0.0, foot, w, foot + board), wood);
        // The lower part of a board is in shadow.
        canvas.rect(Rect::new(0.0, foot + 0.6 * board, w, foot + board), wood * 0.4);
        let mut x = 0.0;
        while x < w {
            let thickness = rng.uniform(0.012, 0.05) * w;
            let tall = rng.uniform(0.55, 0.9) * step;
            // Some places stay empty, as on real shelves.
            if rng.chance(0.93) {
                spine(&mut canvas, Rect::new(x, foot - tall, x + thickness, foot), rng);
            }
            // A gap of a pixel divides spines of one colour.
            x += thickness + 1.0;
        }
    }
    canvas
}

/// One book: round-backed, with bands and a label.
fn spine(canvas: &mut Canvas, book: Rect, rng: &mut CounterRng) {
    let colour = random_colour(rng, (0.1, 1.0), (0.12, 0.95));
    canvas.paint(book, |at, _| {
        let across = 2.0 * (at.x - book.left) / book.width() - 1.0;
        colour * (1.0 - 0.5 * across * across)
    });
    let ink = if colour.max_element() > 0.5 { colour * 0.25 } else { Vec3A::splat(0.85) };
    for _ in 0..1 + rng.below(3) {
        let top = book.top + rng.uniform(0.05, 0.9) * book.height();
        let thick = rng.uniform(0.01, 0.12) * book.height();
        canvas.rect(Rect::new(book.left + 1.0, top, book.right - 1.0, top + thick), ink);
    }
}
