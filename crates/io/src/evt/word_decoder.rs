//! Decoders of the words of Prophesee's cameras.

use super::ExtTrigger;
use crate::{Columns, Decoder};

/// A decoder of words that also reads edges at trigger inputs.
pub trait WordDecoder: Decoder {
    /// Appends the events and the edges of all whole words of `bytes`; returns the bytes of these
    /// words.
    fn decode_all(
        &mut self,
        bytes: &[u8],
        columns: &mut Columns,
        triggers: &mut Vec<ExtTrigger>,
    ) -> usize;
}
