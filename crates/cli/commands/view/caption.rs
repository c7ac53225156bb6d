//! Caption of a frame: its time and event rate.

use image::{Rgb, RgbImage, imageops};

use super::frames::RenderedFrame;

const PAPER: Rgb<u8> = Rgb([228, 230, 235]);
const INK: Rgb<u8> = Rgb([29, 36, 48]);

/// A letter in its cell, and the line in the bar, in dots.
const CELL: u32 = 6;
const BAR: u32 = 11;
const TOP: u32 = 2;
/// Sides of a dot in pixels, at least, and frames so wide have larger ones.
const MIN_DOT: u32 = 2;
const WIDTH_PER_DOT: u32 = 320;

/// All that is ever said, five dots wide, from the left (the highest bit) to the right.
const LETTERS: [(char, [u8; 7]); 16] = [
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00010, 0b00100, 0b01000, 0b11111]),
    ('3', [0b11111, 0b00010, 0b00100, 0b00010, 0b00001, 0b10001, 0b01110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000]),
    ('8', [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100]),
    ('.', [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100]),
    ('s', [0b00000, 0b00000, 0b01110, 0b10000, 0b01110, 0b00001, 0b11110]),
    ('e', [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110]),
    ('v', [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100]),
    ('n', [0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001]),
    ('t', [0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110]),
];

/// The frame with a bar below it that says its time and its events.
pub(super) fn captioned(frame: &RenderedFrame) -> RgbImage {
    let text = format!("{:.3} s  {} events", frame.t.as_seconds(), frame.events);
    let (width, height) = frame.image.dimensions();
    let dot = (width / WIDTH_PER_DOT).max(MIN_DOT);
    let mut image = RgbImage::from_pixel(width, height + BAR * dot, PAPER);
    imageops::replace(&mut image, &frame.image, 0, 0);
    for (k, letter) in text.chars().enumerate() {
        // What has no letter is a space.
        let rows = LETTERS.iter().find(|(known, _)| *known == letter).map(|(_, rows)| rows);
        for (y, row) in (0..).zip(rows.into_iter().flatten()) {
            for x in (0..5).filter(|x| (row >> (4 - x)) & 1 == 1) {
                let left = (1 + k as u32 * CELL + x) * dot;
                fill(&mut image, left, height + (TOP + y) * dot, dot);
            }
        }
    }
    image
}

/// A dot, or what of it lies on the image.
fn fill(image: &mut RgbImage, left: u32, top: u32, side: u32) {
    for y in top..(top + side).min(image.height()) {
        for x in left..(left + side).min(image.width()) {
            image.put_pixel(x, y, INK);
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Micros;

    use super::*;

    #[test]
    fn the_frame_is_unchanged_and_the_caption_has_time_and_events() {
        let image = RgbImage::from_pixel(320, 10, Rgb([1, 2, 3]));
        let frame = RenderedFrame { t: Micros(1_000), events: 7, image };
        let image = captioned(&frame);
        assert_eq!(image.dimensions(), (320, 10 + 22));
        assert!(image.pixels().zip(frame.image.pixels()).all(|(a, b)| a == b));
        // `0.001 s  7 events`: the point is the second letter, the 7 the tenth.
        let dot =
            |letter: u32, x, y| *image.get_pixel((1 + letter * CELL + x) * 2, 10 + (TOP + y) * 2);
        assert_eq!((dot(1, 1, 6), dot(1, 1, 4)), (INK, PAPER));
        assert_eq!((dot(9, 0, 0), dot(9, 4, 0), dot(9, 0, 1)), (INK, INK, PAPER));
    }

    #[test]
    fn captions_of_narrow_frames_are_cut() {
        let frame = RenderedFrame { t: Micros(0), events: 0, image: RgbImage::new(9, 9) };
        assert_eq!(captioned(&frame).dimensions(), (9, 9 + 22));
    }
}
