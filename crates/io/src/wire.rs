//! A socket for tests.

use std::collections::VecDeque;
use std::io::{self, Read};

/// Gives bytes piece by piece, as a socket does, and panics if asked when nobody is sending.
pub(crate) struct Wire {
    pieces: VecDeque<Vec<u8>>,
    has_ended: bool,
}

impl Wire {
    pub(crate) fn new(pieces: impl IntoIterator<Item = Vec<u8>>, has_ended: bool) -> Self {
        Self { pieces: pieces.into_iter().filter(|piece| !piece.is_empty()).collect(), has_ended }
    }
}

impl Read for Wire {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let Some(mut piece) = self.pieces.pop_front() else {
            assert!(self.has_ended, "this would wait for ever");
            return Ok(0);
        };
        let count = piece.len().min(out.len());
        out[..count].copy_from_slice(&piece[..count]);
        if count < piece.len() {
            self.pieces.push_front(piece.split_off(count));
        }
        Ok(count)
    }
}
