//! From bytes to events, packet by packet.

use evpose_core::Micros;

use super::layout::{EVENT, HEAD, Head, MARKER, decode};
use crate::{Columns, DecodeFault, DecodeResult, Decoder};

/// Turns what is behind the header of a framed stream into events.
///
/// A packet is begun only where all of it is there, or where nothing is before it: what came before
/// is given without waiting for it.
#[derive(Debug, Clone)]
pub struct FramedDecoder {
    /// Events of the packet that are still to come.
    left: u32,
    base: Micros,
    /// Packets are decoded together that begin within so much time, or all that are there.
    together: Option<Micros>,
    /// Bytes that are no packet are passed over, or a fault.
    passes_over: bool,
    /// Whether the last bytes were none.
    is_lost: bool,
    malformed: u64,
}

impl FramedDecoder {
    /// A decoder for which bytes that are no packet are a fault.
    pub fn strict() -> Self {
        Self {
            left: 0,
            base: Micros(0),
            together: None,
            passes_over: false,
            is_lost: false,
            malformed: 0,
        }
    }

    /// A decoder that passes over them to the next packet.
    pub fn lenient() -> Self {
        Self { passes_over: true, ..Self::strict() }
    }

    /// The same that decodes packets together only if they begin within so much time.
    pub(super) fn together(self, together: Micros) -> Self {
        Self { together: Some(together), ..self }
    }

    /// At how many places bytes were passed over.
    pub fn malformed(&self) -> u64 {
        self.malformed
    }

    /// Whether no packet is begun.
    pub(super) fn is_between(&self) -> bool {
        self.left == 0
    }

    /// Takes events of the packet that is begun from the beginning of `bytes`; how many bytes.
    fn events(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> usize {
        let there = bytes.as_chunks::<EVENT>().0;
        let most = usize::try_from(self.left).unwrap_or(usize::MAX);
        let mut count = there.len().min(most);
        // The last that is there waits: at the end of a stream it is seen that more should come.
        if count < most && !is_last {
            count = count.saturating_sub(1);
        }
        decode(self.base, &there[..count], columns);
        self.left -= count as u32;
        count * EVENT
    }

    /// Offset at which the next packet may begin, behind the first byte, where none does.
    fn search(&mut self, bytes: &[u8], is_last: bool) -> usize {
        self.malformed += u64::from(!std::mem::replace(&mut self.is_lost, true));
        let found = bytes.windows(MARKER.len()).skip(1).position(|four| four == MARKER);
        // A marker may be cut.
        let kept = if is_last { 0 } else { MARKER.len() - 1 };
        found.map_or(bytes.len().saturating_sub(kept).max(1), |k| k + 1)
    }

    fn lose(&mut self, bytes: &[u8], at: usize, is_last: bool) -> DecodeResult {
        match self.passes_over {
            true => Ok(self.search(bytes, is_last)),
            false => Err(DecodeFault { at, reason: "no packet begins here".into() }),
        }
    }
}

impl Decoder for FramedDecoder {
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult {
        let (mut at, before) = (0, columns.len());
        loop {
            let rest = &bytes[at..];
            // In the middle of a packet its events come first.
            if self.left > 0 {
                at += self.events(rest, is_last, columns);
                if self.left == 0 {
                    continue;
                }
                return match is_last {
                    true => {
                        let reason =
                            format!("the last {} events of a packet are missing", self.left);
                        Err(DecodeFault { at, reason: reason.into() })
                    }
                    false => Ok(at),
                };
            }
            // Without a whole head: more bytes may come, or the stream ends here.
            let Some(first) = rest.first_chunk::<HEAD>() else {
                let begun = rest.len().min(MARKER.len());
                if !is_last || rest.is_empty() {
                    return Ok(at);
                }
                // A cut packet is damage; anything else at the end is searched for markers as in
                // between.
                if rest[..begun] == MARKER[..begun] {
                    let reason = format!("the stream ends {} bytes into a packet", rest.len());
                    return Err(DecodeFault { at, reason: reason.into() });
                }
                at += self.lose(rest, at, is_last)?;
                continue;
            };
            let Some(head) = Head::parse(first) else {
                at += self.lose(rest, at, is_last)?;
                continue;
            };
            let length = HEAD + head.count as usize * EVENT;
            // A packet waits until it is whole; the first one may be longer than any buffer.
            if length > rest.len() && !is_last && (at > 0 || rest.len() < HEAD + EVENT) {
                return Ok(at);
            }
            // Packets not within `together` after the first event wait for another call.
            let is_apart = |(together, first): (Micros, &Micros)| {
                !(0..together.0).contains(&(head.base.0 - first.0))
            };
            if self.together.zip(columns.t.get(before)).is_some_and(is_apart) {
                return Ok(at);
            }
            self.is_lost = false;
            (self.left, self.base) = (head.count, head.base);
            at += HEAD;
        }
    }

    fn remarks(&self) -> Vec<String> {
        match self.malformed {
            0 => Vec::new(),
            places => vec![format!("bytes that are no packet are passed over at {places} places")],
        }
    }
}
