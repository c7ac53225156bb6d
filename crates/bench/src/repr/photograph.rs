//! A photograph, or something with its mixture of smooth parts, edges and grain.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::{CounterRng, Plane};

const SIDE: usize = 1000;

/// The user's, or ours.
pub(super) fn grey_image(file: Option<&Path>) -> Result<Plane<u8>> {
    let Some(file) = file else { return Ok(ours()) };
    let image = image::open(file).with_context(|| format!("reading {}", file.display()))?;
    let image = image.into_luma8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Plane::from_vec(width, height, image.into_raw())?)
}

/// Discs of many sizes before each other, shaded, with grain.
fn ours() -> Plane<u8> {
    let mut rng = CounterRng::new(3, "picture", 0);
    let side = SIDE as f32;
    let mut values = vec![0.0_f32; SIDE * SIDE];
    for (i, value) in values.iter_mut().enumerate() {
        *value = 60.0 + 80.0 * (i % SIDE) as f32 / side + 40.0 * (i / SIDE) as f32 / side;
    }
    for _ in 0..400 {
        let centre = [rng.uniform(0.0, side), rng.uniform(0.0, side)];
        // Sizes as in photographs: as much of the image for each octave.
        let radius = 4.0 * 2.0_f32.powf(rng.uniform(0.0, 5.5));
        let (grey, slope) = (rng.uniform(20.0, 235.0), rng.uniform(-0.5, 0.5));
        let span =
            |at: f32| (at - radius).max(0.0) as usize..(at + radius).clamp(0.0, side) as usize;
        for y in span(centre[1]) {
            for x in span(centre[0]) {
                let (dx, dy) = (x as f32 - centre[0], y as f32 - centre[1]);
                if dx * dx + dy * dy < radius * radius {
                    values[y * SIDE + x] = grey + slope * dx;
                }
            }
        }
    }
    let grained = values.into_iter().map(|value| (value + rng.uniform(-4.0, 4.0)) as u8);
    Plane::from_vec(SIDE, SIDE, grained.collect()).unwrap_or_else(|_| unreachable!("of this size"))
}
