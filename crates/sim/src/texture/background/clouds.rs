//! Noise in colours, cut by contour lines, as of marble and camouflage.

use evpose_core::CounterRng;

use crate::texture::canvas::{Canvas, random_colour};
use crate::texture::noise::fractal_noise;

pub(super) fn paint(size: (usize, usize), rng: &mut CounterRng) -> Canvas {
    let (low, high, line) = (
        random_colour(rng, (0.2, 0.8), (0.05, 0.35)),
        random_colour(rng, (0.0, 0.6), (0.7, 1.0)),
        random_colour(rng, (0.0, 0.9), (0.1, 0.9)),
    );
    let cells = 3 + rng.below(4);
    let field = fractal_noise(size, (cells, cells), 5, 0.6, rng);
    let levels = rng.uniform(2.0, 4.0);
    let mut canvas = Canvas::filled(size.0, size.1, low);
    let whole = canvas.whole();
    canvas.paint(whole, |at, _| {
        let value = 0.5 + 2.0 * field.at(at.x as usize, at.y as usize);
        let level = (value * levels).floor() / levels;
        if (value - level) * levels < 0.1 { line } else { low.lerp(high, level.clamp(0.0, 1.0)) }
    });
    canvas
}
