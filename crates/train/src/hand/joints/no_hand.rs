//! Images without a hand.
//!
//! # Model
//! *Scrambled*: an image of a hand is cut into 4 x 4 tiles, which change places and are mirrored. Edges, noise and
//! density of its events stay; the hand is gone. Networks are trained with these.
//!
//! *Drawn*: closed and open lines and strokes that move and turn over an LNES, from one to as many as fill the image:
//! outlines of something else, as of a digit or a room, on pixels of all sizes. The presence is fitted with these too.

use std::f32::consts::TAU;

use evpose_core::{CounterRng, SensorSize};
use glam::Vec2;

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

/// Most lines of a drawing.
const MAX_LINES: f32 = 40.0;
/// Waves that a line is the sum of, after its first, which is an ellipse or a bow.
const WAVES: usize = 4;
/// Largest pixel of a camera, in pixels of the image: 34 of them across it, as of N-MNIST.
const MAX_BLOCK_PX: usize = 4;
/// Points of a line, and instants of its movement.
const POINTS: usize = 240;
const INSTANTS: usize = 24;
/// Displacement across a line, in pixels, from which it makes an event.
const MIN_STEP_PX: f32 = 0.08;

/// Draws lines that move over an empty LNES, `[2][rows][columns]` of `size`: a function of `seed` and `number` alone.
pub(super) fn draw_lines(image: &mut [f32], size: SensorSize, seed: u64, number: u64) {
    image.fill(0.0);
    let mut rng = CounterRng::new(seed, "lines that are no hand", number);
    let sides = Vec2::new(size.width.into(), size.height.into());
    // One movement of all: parts of one thing; the camera may move as well.
    let angle = rng.uniform(0.0, TAU);
    let travel_px = rng.uniform(2.0, 0.25 * sides.y) * Vec2::from_angle(angle);
    let turn = rng.uniform(-0.5f32, 0.5);
    // Log-uniform: as often one thing as a whole scene.
    let lines = MAX_LINES.powf(rng.uniform(0.0, 1.0)).round() as usize;
    let block_px = if rng.chance(0.5) { 1 } else { 1 + rng.below(MAX_BLOCK_PX) };
    for _ in 0..lines {
        let line = Line::draw(&mut rng, sides);
        for instant in 0..INSTANTS {
            let part = (instant as f32 + 1.0) / INSTANTS as f32;
            let at = |u: f32, part: f32| {
                let turned = Vec2::from_angle(turn * (part - 0.5)).rotate(line.at(u));
                line.middle_px + turned + (part - 0.5) * travel_px
            };
            for point in 0..POINTS {
                let u = (point as f32 + rng.uniform(0.0f32, 1.0)) / POINTS as f32;
                let (now, before) = (at(u, part), at(u, part - 1.0 / INSTANTS as f32));
                let normal = (at(u + 0.01, part) - now).perp().normalize_or_zero();
                let step_px = normal.dot(now - before);
                // What moves along itself changes nothing, and few events are missed.
                if step_px.abs() < MIN_STEP_PX || rng.chance(line.lost) {
                    continue;
                }
                // The second edge of a stroke is as dark behind as the first is before.
                let edges = [(0.0, line.is_bright), (line.stroke_px, !line.is_bright)];
                for (away_px, is_bright) in &edges[..1 + usize::from(line.stroke_px > 0.0)] {
                    let edge = now + *away_px * normal;
                    let is_inside = edge.cmpge(Vec2::ZERO).all() && edge.cmplt(sides).all();
                    let channel = usize::from((step_px > 0.0) != *is_bright);
                    let corner = [edge.x, edge.y].map(|at| at as usize / block_px * block_px);
                    for pixel in block(corner, block_px, size).filter(|_| is_inside) {
                        image[channel * size.pixels() + pixel] = part;
                    }
                }
            }
        }
    }
}

/// The pixels of a square of `side` pixels, as far as they lie in the image.
fn block([x, y]: [usize; 2], side: usize, size: SensorSize) -> impl Iterator<Item = usize> {
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let columns = x..(x + side).min(width);
    (y..(y + side).min(height)).flat_map(move |y| columns.clone().map(move |x| y * width + x))
}

/// A line about a middle, as a sum of waves.
struct Line {
    middle_px: Vec2,
    waves_px: [Vec2; WAVES],
    phases: [Vec2; WAVES],
    /// Part of the whole turn that it takes: all of a closed line.
    part: f32,
    is_bright: bool,
    /// How far away the other edge of a stroke is; 0 of an outline, which has one edge.
    stroke_px: f32,
    /// Share of its events that are lost.
    lost: f32,
}

impl Line {
    fn draw(rng: &mut CounterRng, sides: Vec2) -> Self {
        let radius_px = rng.uniform(0.06, 0.45) * sides.y;
        let wave = |k: usize, rng: &mut CounterRng| {
            let size = radius_px / (1.0 + 2.5 * k as f32);
            Vec2::new(rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0)) * size
        };
        Self {
            middle_px: Vec2::new(rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8)) * sides,
            waves_px: std::array::from_fn(|k| wave(k, rng)),
            phases: std::array::from_fn(|_| {
                Vec2::new(rng.uniform(0.0, TAU), rng.uniform(0.0, TAU))
            }),
            part: if rng.chance(0.5) { 1.0 } else { rng.uniform(0.1, 0.8) },
            is_bright: rng.chance(0.5),
            stroke_px: if rng.chance(0.5) { rng.uniform(0.03, 0.15) * sides.y } else { 0.0 },
            lost: rng.uniform(0.0, 0.7),
        }
    }

    /// The point at `u` of 0..1, from the middle.
    fn at(&self, u: f32) -> Vec2 {
        let waves = self.waves_px.iter().zip(&self.phases).zip(1..);
        let point = |((size, phase), k): ((&Vec2, &Vec2), u8)| {
            let angle = TAU * f32::from(k) * self.part * u;
            *size * Vec2::new((angle + phase.x).cos(), (angle + phase.y).sin())
        };
        waves.map(point).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_drawn_on_both_channels_and_no_two_images_are_the_same() {
        let size = SensorSize { width: 128, height: 96 };
        let drawn = |number| {
            let mut image = vec![0.5; 2 * size.pixels()];
            draw_lines(&mut image, size, 3, number);
            image
        };
        assert_eq!(drawn(1), drawn(1));
        let images: Vec<Vec<f32>> = (0..50).map(drawn).collect();
        assert_ne!(images[0], images[1]);
        let active = |channel: &[f32]| channel.iter().filter(|value| **value > 0.0).count();
        let is_drawn = |image: &&Vec<f32>| {
            let (off, on) = image.split_at(size.pixels());
            [off, on].map(active).iter().all(|count| (20..size.pixels()).contains(count))
        };
        assert!(images.iter().filter(is_drawn).count() > 35);
        assert!(images.iter().flatten().all(|value| (0.0..=1.0).contains(value)));
    }

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
