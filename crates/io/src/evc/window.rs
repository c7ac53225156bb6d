//! Consecutive frames of an `.evc` file, in memory.

use std::ops::Range;

use evpose_core::Polarity;

use super::{NEW_FRAME, RECORD};

/// An event and the frame it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EvcEvent {
    /// Frame, counted from the first of the window.
    pub frame: u32,
    /// Column, 0 at the left.
    pub x: u16,
    /// Row, 0 at the top.
    pub y: u16,
    /// Direction of the change.
    pub polarity: Polarity,
}

/// Some consecutive frames, read by [`EvcReader::read_frames`](super::EvcReader::read_frames).
///
/// Keeps its memory from one read to the next. Its records are valid: they were checked.
#[derive(Debug, Clone, Default)]
pub struct EvcWindow {
    /// The bytes read, which may begin and end with frames outside the window.
    pub(super) bytes: Vec<u8>,
    /// The frames that were asked for, as bytes; begins with a marker.
    pub(super) inside: Range<usize>,
    pub(super) frames: Range<u64>,
}

impl EvcWindow {
    /// A window without frames.
    pub fn new() -> Self {
        Self::default()
    }

    /// Range of the frames in the file.
    pub fn frames(&self) -> Range<u64> {
        self.frames.clone()
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.inside.len() / RECORD - (self.frames.end - self.frames.start) as usize
    }

    /// Whether no frame of the window has an event.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The records of four bytes, frame markers among them, the first record being one.
    pub fn records(&self) -> &[[u8; RECORD]] {
        self.bytes[self.inside.clone()].as_chunks().0
    }

    /// The events in file order, frame by frame.
    pub fn events(&self) -> impl Iterator<Item = EvcEvent> + '_ {
        // The first record is a marker, which takes the counter to 0.
        let mut frame = u32::MAX;
        self.records().iter().filter_map(move |&[low, high, y, polarity]| {
            if polarity == NEW_FRAME {
                frame = frame.wrapping_add(1);
                return None;
            }
            Some(EvcEvent {
                frame,
                x: u16::from_le_bytes([low, high]),
                y: y.into(),
                polarity: Polarity::from_on(polarity == 1),
            })
        })
    }
}
