//! Images without a hand, of the same camera and light as those with one.
//!
//! # Model
//! An image of a hand is cut into 4 x 4 tiles, which change places and are mirrored. Edges, noise and density of
//! its events stay; the hand is gone. Beside images of what lies next to a hand, which are nearly empty, these
//! teach the presence what a moving thing is that is no hand.

use evpose_core::{CounterRng, SensorSize};

/// Rows and columns of tiles.
const TILES: usize = 4;

/// Moves the tiles of an image, `[channels][rows][columns]`, both sides of `size` being multiples of four: a
/// function of `seed` and `number` alone.
pub(crate) fn scramble(image: &mut [f32], size: SensorSize, seed: u64, number: u64) {
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let (across, down) = (width / TILES, height / TILES);
    let mut rng = CounterRng::new(seed, "images without a hand", number);
    let mut from: [usize; TILES * TILES] = std::array::from_fn(|tile| tile);
    // Fisher and Yates.
    for last in (1..from.len()).rev() {
        from.swap(last, rng.below(last + 1));
    }
    let mirrors: [bool; TILES * TILES] = std::array::from_fn(|_| rng.chance(0.5));
    let before = image.to_vec();
    for (plane, before) in
        image.chunks_exact_mut(width * height).zip(before.chunks_exact(width * height))
    {
        for (tile, (&source, &is_mirrored)) in from.iter().zip(&mirrors).enumerate() {
            let corner = |tile: usize| (tile / TILES * down, tile % TILES * across);
            let ((to_row, to_column), (row, column)) = (corner(tile), corner(source));
            for y in 0..down {
                let to = (to_row + y) * width + to_column;
                let at = (row + y) * width + column;
                plane[to..to + across].copy_from_slice(&before[at..at + across]);
                // Straight on, four tiles of an arm would still be an arm.
                if is_mirrored {
                    plane[to..to + across].reverse();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_move_and_no_value_is_lost_and_both_channels_move_alike() {
        let size = SensorSize { width: 16, height: 8 };
        let plane: Vec<f32> = (0..size.pixels()).map(|k| k as f32).collect();
        let image = [plane.clone(), plane.clone()].concat();
        let scrambled = |number| {
            let mut out = image.clone();
            scramble(&mut out, size, 3, number);
            out
        };
        let out = scrambled(1);
        assert_eq!(out, scrambled(1));
        assert!(out != scrambled(2) && out != image);
        assert_eq!(out[..size.pixels()], out[size.pixels()..]);
        let mut sorted = out[..size.pixels()].to_vec();
        sorted.sort_by(f32::total_cmp);
        assert_eq!(sorted, plane);
    }
}
