//! A wall of bricks, or of square tiles.

use evpose_core::CounterRng;
use glam::Vec3A;

use crate::texture::canvas::{Canvas, Rect, random_colour};

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let mortar = Vec3A::splat(if rng.chance(0.5) { 0.8 } else { 0.12 });
    let mut canvas = Canvas::filled(width, height, mortar);
    let (w, h) = (canvas.width(), canvas.height());
    let tiles = rng.chance(0.4);
    let course = rng.uniform(0.06, 0.14) * h;
    let length = if tiles { course } else { course * rng.uniform(1.8, 3.0) };
    // At least two pixels, so that joint and shadow are both visible.
    let joint = (0.1 * course).max(2.0);
    let (first, second) =
        (random_colour(rng, (0.2, 0.8), (0.3, 0.7)), random_colour(rng, (0.2, 0.8), (0.15, 0.9)));
    // From above the image, so that the first course may be cut.
    let mut y = -rng.unit() * course;
    let mut odd = false;
    while y < h {
        let mut x = if odd && !tiles { -0.5 * length } else { 0.0 };
        let mut column = usize::from(odd);
        while x < w {
            let shade = rng.uniform(0.75, 1.2);
            let colour = match (tiles, column % 2) {
                (true, 0) => second,
                (true, _) => first,
                // Now and then a burnt brick.
                (false, _) if rng.chance(0.12) => second * 0.5,
                (false, _) => first,
            };
            let brick = Rect::new(x, y, x + length - joint, y + course - joint);
            canvas.rect(brick, colour * shade);
            // The lower edge of a brick lies in its own shadow.
            let lip = Rect { top: brick.bottom - 0.5 * joint, ..brick };
            canvas.rect(lip, colour * shade * 0.6);
            x += length;
            column += 1;
        }
        y += course;
        odd = !odd;
    }
    canvas
}
