//! Sheets and signs with lines of something like text.

use evpose_core::CounterRng;
use glam::Vec3A;

use crate::texture::canvas::{Canvas, Rect, random_colour};

pub(super) fn paint((width, height): (usize, usize), rng: &mut CounterRng) -> Canvas {
    let mut canvas = Canvas::filled(width, height, random_colour(rng, (0.1, 0.6), (0.2, 0.6)));
    let (w, h) = (canvas.width(), canvas.height());
    for _ in 0..11 {
        let (left, top) = (rng.uniform(-0.15, 0.9) * w, rng.uniform(-0.15, 0.9) * h);
        let sheet = Rect::new(
            left,
            top,
            left + rng.uniform(0.15, 0.5) * w,
            top + rng.uniform(0.15, 0.5) * h,
        );
        // Before the sheet, which covers all but two of its edges.
        let shadow = Rect::new(left + 4.0, top + 4.0, sheet.right + 4.0, sheet.bottom + 4.0);
        canvas.paint(shadow, |_, old| old * 0.4);
        let dark = rng.chance(0.3);
        let paper = random_colour(rng, (0.0, 0.4), if dark { (0.05, 0.25) } else { (0.8, 1.0) });
        let ink = if dark { Vec3A::splat(0.9) } else { Vec3A::splat(0.08) };
        canvas.rect(sheet, paper);
        write(&mut canvas, sheet.inset(0.015 * w), ink, rng);
    }
    canvas
}

/// Fills a sheet with lines of words of letters: small blocks with gaps.
fn write(canvas: &mut Canvas, sheet: Rect, ink: Vec3A, rng: &mut CounterRng) {
    let letter = rng.uniform(0.008, 0.03) * canvas.width();
    let mut y = sheet.top;
    while y + letter < sheet.bottom {
        let line_end = sheet.left + sheet.width() * rng.uniform(0.6, 1.0);
        let mut x = sheet.left;
        while x + letter < line_end {
            let wide = letter * rng.uniform(0.35, 0.8);
            // One letter in six is a space, as in text.
            if !rng.chance(0.17) {
                let top = y + letter * if rng.chance(0.5) { 0.0 } else { 0.3 };
                let stem = (0.3 * letter).max(1.0);
                // A stem and a bar are enough: letters only have to have edges.
                canvas.rect(Rect::new(x, top, x + stem, y + letter), ink);
                let bar = if rng.chance(0.5) { top } else { y + 0.6 * letter };
                canvas.rect(Rect::new(x, bar, x + wide, bar + stem), ink);
            }
            x += wide + 0.2 * letter;
        }
        y += letter * 1.6;
    }
}
