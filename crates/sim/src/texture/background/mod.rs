//! Procedural background images: cluttered, with strong edges, of seven kinds.
//!
//! They take the place of the nine photographs of the published simulator. Their values are
//! gamma-encoded like a photograph's.

mod bricks;
mod clouds;
mod foliage;
mod room;
mod shelves;
mod stripes;
mod text;

use evpose_core::CounterRng;

use super::Texture;
use super::noise::fractal_noise;

/// Texels of a procedural image: twice the published sensor's pixels along each side.
const SIZE: (usize, usize) = (480, 360);

/// Kind of procedural image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackgroundKind {
    /// Walls, a window, furniture.
    Room,
    /// Book spines on shelves.
    Shelves,
    /// Bricks or tiles.
    Bricks,
    /// Leaves.
    Foliage,
    /// Lines of something like text on sheets.
    Text,
    /// Stripes over gradients.
    Stripes,
    /// Clouds of noise, contoured.
    Clouds,
}

impl BackgroundKind {
    /// All kinds, in the order in which a pool goes through them.
    pub const ALL: [Self; 7] = [
        Self::Room,
        Self::Shelves,
        Self::Bricks,
        Self::Foliage,
        Self::Text,
        Self::Stripes,
        Self::Clouds,
    ];
}

/// Paints image `index` of the pool of `seed`; neighbours in the pool differ in kind.
pub fn paint_background(seed: u64, index: usize) -> Texture {
    paint(
        BackgroundKind::ALL[index % BackgroundKind::ALL.len()],
        &mut CounterRng::new(seed, "background", index as u64),
    )
}

fn paint(kind: BackgroundKind, rng: &mut CounterRng) -> Texture {
    let mut canvas = match kind {
        BackgroundKind::Room => room::paint(SIZE, rng),
        BackgroundKind::Shelves => shelves::paint(SIZE, rng),
        BackgroundKind::Bricks => bricks::paint(SIZE, rng),
        BackgroundKind::Foliage => foliage::paint(SIZE, rng),
        BackgroundKind::Text => text::paint(SIZE, rng),
        BackgroundKind::Stripes => stripes::paint(SIZE, rng),
        BackgroundKind::Clouds => clouds::paint(SIZE, rng),
    };
    // Uneven light and a little grain.
    canvas.modulate(&fractal_noise(SIZE, (2, 2), 3, 0.5, rng), 0.35);
    canvas.modulate(&fractal_noise(SIZE, (120, 90), 2, 0.8, rng), 0.12);
    Texture::from_plane(&canvas.finish())
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::scene::luminance;

    #[test]
    fn every_kind_has_edges_that_a_hand_crossing_them_shows() {
        for (index, kind) in BackgroundKind::ALL.into_iter().enumerate() {
            let image = paint_background(5, index);
            let (mut strong, mut count) = (0, 0);
            let (width, height) = (image.width() as f32, image.height() as f32);
            let log = |x: usize, y: usize| {
                let uv = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
                (luminance(image.sample(uv)).powf(2.2) + 1.0 / 255.0).ln()
            };
            for y in 0..image.height() {
                for x in 0..image.width() - 8 {
                    strong += usize::from((log(x, y) - log(x + 8, y)).abs() > 0.5);
                    count += 1;
                }
            }
            let share = strong as f32 / count as f32;
            assert!(share > 0.05, "{kind:?}: {share}");
        }
    }

    #[test]
    fn seeds_and_indices_in_the_pool_change_the_image() {
        assert_eq!(paint_background(1, 2), paint_background(1, 2));
        assert_ne!(paint_background(1, 2), paint_background(2, 2));
        assert_ne!(paint_background(1, 2), paint_background(1, 2 + BackgroundKind::ALL.len()));
    }
}
