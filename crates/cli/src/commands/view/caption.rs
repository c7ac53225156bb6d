//! Caption of a frame: its time, its event count, and which colour is what.

use image::{Rgb, RgbImage, imageops};

use super::frames::RenderedFrame;
use super::key::Key;
use evpose_report::dot_letters::{self, LETTER_HEIGHT, LETTER_WIDTH};

const PAPER: Rgb<u8> = Rgb([228, 230, 235]);
const INK: Rgb<u8> = Rgb([29, 36, 48]);

/// Height of a bar, and of the gap above its letters, in dots.
const BAR: u32 = 11;
const TOP: u32 = 2;
/// Sides of a dot in pixels, at least, and frames so wide have larger ones.
const MIN_DOT: u32 = 2;
const WIDTH_PER_DOT: u32 = 320;

/// The frame with a bar below it that says its time and its events.
pub(super) fn captioned(frame: &RenderedFrame) -> RgbImage {
    let text = format!("{:.3} s  {} events", frame.t.as_seconds(), frame.events);
    let (mut image, dot) = with_bar(&frame.image);
    let top = frame.image.height() + TOP * dot;
    dot_letters::write(&mut image, &text, (i64::from(dot), i64::from(top)), dot, INK);
    image
}

/// The image with a bar below it that says which colour is what; unchanged where no key is needed.
pub(super) fn with_keys(image: RgbImage, keys: &[Key]) -> RgbImage {
    if keys.is_empty() {
        return image;
    }
    let (mut with_keys, dot) = with_bar(&image);
    let top = i64::from(image.height() + TOP * dot);
    let mut left = i64::from(dot);
    for key in keys {
        dot_letters::dot(&mut with_keys, (left, top), LETTER_HEIGHT * dot, key.colour);
        left += i64::from((LETTER_HEIGHT + 2) * dot);
        dot_letters::write(&mut with_keys, key.name, (left, top), dot, INK);
        left += i64::from((key.name.len() as u32 + 2) * LETTER_WIDTH * dot);
    }
    with_keys
}

/// The image with an empty bar below it, and the side of a dot in pixels.
fn with_bar(image: &RgbImage) -> (RgbImage, u32) {
    let (width, height) = image.dimensions();
    let dot = (width / WIDTH_PER_DOT).clamp(MIN_DOT, MAX_DOT);
    let mut with_bar = RgbImage::from_pixel(width, height + BAR * dot, PAPER);
    imageops::replace(&mut with_bar, image, 0, 0);
    (with_bar, dot)
}

/// Sheets are wide because they hold several frames.
const MAX_DOT: u32 = 4;

#[cfg(test)]
mod tests {
    use evpose_core::Micros;
    use evpose_report::canvas::{PREDICTION, TRUTH};

    use super::*;

    #[test]
    fn the_frame_is_unchanged_and_the_caption_has_time_and_events() {
        let image = RgbImage::from_pixel(320, 10, Rgb([1, 2, 3]));
        let frame = RenderedFrame { t: Micros(1_000), events: 7, image };
        let image = captioned(&frame);
        assert_eq!(image.dimensions(), (320, 10 + 22));
        assert!(image.pixels().zip(frame.image.pixels()).all(|(a, b)| a == b));
        // `0.001 s  7 events`: the point is the second letter, the 7 the tenth.
        let dot = |letter: u32, x, y| {
            *image.get_pixel((1 + letter * LETTER_WIDTH + x) * 2, 10 + (TOP + y) * 2)
        };
        assert_eq!((dot(1, 1, 6), dot(1, 1, 4)), (INK, PAPER));
        assert_eq!((dot(9, 0, 0), dot(9, 4, 0), dot(9, 0, 1)), (INK, INK, PAPER));
    }

    #[test]
    fn captions_of_narrow_frames_are_cut() {
        let frame = RenderedFrame { t: Micros(0), events: 0, image: RgbImage::new(9, 9) };
        assert_eq!(captioned(&frame).dimensions(), (9, 9 + 22));
    }

    #[test]
    fn keys_show_their_colours_and_no_key_changes_nothing() {
        let image = RgbImage::new(400, 5);
        assert_eq!(with_keys(image.clone(), &[]), image);
        let keys =
            [Key { name: "true", colour: TRUTH }, Key { name: "predicted", colour: PREDICTION }];
        let image = with_keys(image, &keys);
        assert_eq!(image.dimensions(), (400, 5 + 22));
        assert_eq!(*image.get_pixel(4, 12), TRUTH);
        assert!(image.pixels().any(|pixel| *pixel == PREDICTION));
    }
}
