//! Letters of dots for captions and scores on images: no font is needed, and each is five dots wide.

use image::{Rgb, RgbImage};

/// Width of a letter with the gap behind it, in dots.
pub const LETTER_WIDTH: u32 = 6;
/// Height of a letter, in dots.
pub const LETTER_HEIGHT: u32 = 7;

/// Rows of a letter from its top; the highest of five bits is the left dot.
const LETTERS: [(char, [u8; 7]); 27] = [
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
    ('N', [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001]),
    ('O', [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('F', [0b11111, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000, 0b10000]),
    ('c', [0b00000, 0b00000, 0b01110, 0b10000, 0b10000, 0b10001, 0b01110]),
    ('d', [0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10001, 0b01111]),
    ('e', [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110]),
    ('i', [0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('n', [0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001]),
    ('o', [0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('p', [0b00000, 0b00000, 0b11110, 0b10001, 0b11110, 0b10000, 0b10000]),
    ('r', [0b00000, 0b00000, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000]),
    ('s', [0b00000, 0b00000, 0b01110, 0b10000, 0b01110, 0b00001, 0b11110]),
    ('t', [0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110]),
    ('u', [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b10011, 0b01101]),
    ('v', [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100]),
    ('/', [0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000]),
];

/// Draws a text whose upper left corner is at `at_px`, in dots of `dot_px` pixels. What has no letter
/// is a space; what lies outside the image is cut off.
pub fn write(image: &mut RgbImage, text: &str, at_px: (i64, i64), dot_px: u32, colour: Rgb<u8>) {
    for (k, letter) in text.chars().enumerate() {
        let rows = LETTERS.iter().find(|(known, _)| *known == letter).map(|(_, rows)| rows);
        for (y, row) in (0..).zip(rows.into_iter().flatten()) {
            for x in (0..5).filter(|x| (row >> (4 - x)) & 1 == 1) {
                let left = at_px.0 + i64::from((k as u32 * LETTER_WIDTH + x) * dot_px);
                dot(image, (left, at_px.1 + i64::from(y * dot_px)), dot_px, colour);
            }
        }
    }
}

/// A square, or what of it lies on the image.
pub fn dot(image: &mut RgbImage, at_px: (i64, i64), side_px: u32, colour: Rgb<u8>) {
    for y in at_px.1..at_px.1 + i64::from(side_px) {
        for x in at_px.0..at_px.0 + i64::from(side_px) {
            let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { continue };
            if x < image.width() && y < image.height() {
                image.put_pixel(x, y, colour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_differ_and_what_is_outside_is_cut_off() {
        let mut rows: Vec<[u8; 7]> = LETTERS.iter().map(|(_, rows)| *rows).collect();
        rows.sort_unstable();
        rows.dedup();
        assert_eq!(rows.len(), LETTERS.len());
        let ink = Rgb([1, 2, 3]);
        let mut image = RgbImage::new(20, 9);
        write(&mut image, "1F", (-2, 1), 1, ink);
        // The stem of the 1, and the corner of the F.
        assert_eq!((*image.get_pixel(0, 1), *image.get_pixel(4, 1)), (ink, ink));
        assert_eq!(*image.get_pixel(9, 8), Rgb([0; 3]));
        write(&mut image, "8", (18, -3), 3, ink);
    }
}
