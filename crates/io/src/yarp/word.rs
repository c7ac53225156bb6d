//! Words of 32 bits that are events.

use evpose_core::{Micros, Polarity};

use crate::{Columns, OpenOptions};

/// Use of the upper bits of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    /// All are 0 in an event.
    Bits24,
    /// All but the bit of corners are 0 in an event.
    Packed,
}

/// The bit of a corner, counted from bit 23.
const CORNER: u32 = 1 << 2;

impl Codec {
    /// Whether a word is an event.
    #[inline]
    pub(super) fn is_event(self, word: u32) -> bool {
        let corner = if self == Self::Packed { CORNER } else { 0 };
        (word >> 23) & !corner == 0
    }
}

/// The camera of an event.
pub(super) fn channel(word: u32) -> u8 {
    (word >> 22 & 1) as u8
}

/// Takes the events of one camera out of words, and counts the others.
#[derive(Debug, Clone)]
pub(super) struct Words {
    camera: u8,
    /// Events of the other camera.
    others: u64,
    /// Words that are no events.
    skipped: u64,
}

impl Words {
    /// Takes events of the camera asked for, or of `first`.
    pub(super) fn new(options: &OpenOptions, first: u8) -> Self {
        Self { camera: options.camera.unwrap_or(first), others: 0, skipped: 0 }
    }

    /// Appends the event of `word`, or counts a word that is none.
    #[inline]
    pub(super) fn take(&mut self, codec: Codec, t: Micros, word: u32, columns: &mut Columns) {
        if !codec.is_event(word) {
            self.skipped += 1;
        } else if channel(word) != self.camera {
            self.others += 1;
        } else {
            columns.t.push(t);
            columns.x.push((word >> 1 & 0x7ff) as u16);
            columns.y.push((word >> 12 & 0x3ff) as u16);
            // In these words a set bit stands for a darker pixel.
            columns.polarity.push(Polarity::from_on(word & 1 == 0));
        }
    }

    pub(super) fn fact(&self) -> (&'static str, String) {
        ("camera", self.camera.to_string())
    }

    pub(super) fn remarks(&self) -> Vec<String> {
        let read = self.camera;
        let others = match read {
            0 | 1 => format!("of camera {}", 1 - read),
            _ => "of cameras 0 and 1".to_owned(),
        };
        [
            (self.others, format!("events {others}")),
            (self.skipped, "words that are no events".into()),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what} are passed over"))
        .collect()
    }
}
