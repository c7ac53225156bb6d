//! Formats that are one run of records: bytes in blocks, and an index of places to start again.

use std::borrow::Cow;
use std::io::{Read, Seek, SeekFrom};

use evpose_core::Micros;

use super::{EventSource, Header, Input};
use crate::{Columns, IoError};

/// Bytes read at once, about what a second-level cache holds beside the columns they become.
const BLOCK: usize = 1 << 18;
/// Bytes between two places from which reading can start again.
const BETWEEN_MARKS: u64 = 1 << 22;

/// Turns bytes into events and can stop behind any record.
///
/// The state between calls is small: clones of it are the index of a file.
pub trait Decoder: Clone + Send {
    /// Appends the events of whole records at the beginning of `bytes` and returns how many bytes
    /// those records had. What is left is the beginning of a record, and comes again with more
    /// behind it, unless `is_last`: then nothing comes behind, and what is left is a fault of the
    /// file.
    ///
    /// # Errors
    /// At the first record that is none. The events before it have been appended.
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult;

    /// Says what the records so far promise and the end of the file leaves out, if there is such.
    fn missing(&self) -> Option<String> {
        None
    }

    /// As [`EventSource::duration`].
    fn duration(&self) -> Option<Micros> {
        None
    }

    /// As [`EventSource::remarks`].
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Bytes of the records that were decoded, or the first fault.
pub type DecodeResult = Result<usize, DecodeFault>;

/// A fault in some bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DecodeFault {
    /// Offset from the first of them.
    pub at: usize,
    /// The reason.
    pub reason: Cow<'static, str>,
}

/// A place at which decoding can start again.
#[derive(Debug, Clone)]
struct Mark<D> {
    byte: u64,
    events: u64,
    /// The latest time before.
    latest: Micros,
    decoder: D,
}

/// A file that is one run of records behind its header.
pub struct BlockSource<D> {
    input: Input,
    header: Header,
    /// Bytes read and not yet decoded are `buffer[taken..]`.
    buffer: Vec<u8>,
    taken: usize,
    /// Offset of the next byte to read.
    read_to: u64,
    is_at_end: bool,
    /// Position of the decoder.
    now: Mark<D>,
    /// Ascending; the first is the beginning.
    marks: Vec<Mark<D>>,
}

impl<D: Decoder> BlockSource<D> {
    /// Reads `input` from byte `start` on.
    pub fn new(input: Input, start: u64, header: Header, decoder: D) -> Self {
        let now = Mark { byte: start, events: 0, latest: Micros(i64::MIN), decoder };
        Self {
            input,
            header,
            buffer: Vec::new(),
            taken: 0,
            read_to: u64::MAX,
            is_at_end: false,
            marks: vec![now.clone()],
            now,
        }
    }

    /// Makes room at the end of the buffer and reads there; whether there was anything.
    fn fill(&mut self) -> Result<bool, IoError> {
        self.buffer.drain(..self.taken);
        self.taken = 0;
        let failed = |e| IoError::file(&self.input.path, "read", e);
        let next = self.now.byte + self.buffer.len() as u64;
        // A seek would discard what the input has buffered.
        if self.read_to != next {
            self.input.bytes.seek(SeekFrom::Start(next)).map_err(failed)?;
        }
        let want = (BLOCK - self.buffer.len().min(BLOCK)) as u64;
        let got = (&mut self.input.bytes).take(want).read_to_end(&mut self.buffer);
        let got = got.map_err(failed)?;
        self.read_to = next + got as u64;
        self.is_at_end = (got as u64) < want;
        Ok(got > 0)
    }

    /// Whether the file ends where it should.
    fn check_end(&self) -> Result<(), IoError> {
        // It was longer when it was opened: somebody has cut it since.
        if self.read_to < self.input.length {
            let (end, length) = (self.read_to, self.input.length);
            let reason = format!("the file ends here, and had {length} bytes when it was opened");
            return Err(self.damage((end - self.now.byte) as usize, reason.into()));
        }
        match self.now.decoder.missing() {
            Some(reason) => Err(self.damage(0, reason.into())),
            None => Ok(()),
        }
    }

    fn damage(&self, at: usize, reason: Cow<'static, str>) -> IoError {
        let byte = self.now.byte + at as u64;
        IoError::damaged(&self.input.path, byte, reason).behind(self.now.events)
    }
}

impl<D: Decoder> EventSource for BlockSource<D> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        while columns.len() == before {
            if !self.is_at_end {
                self.fill()?;
            }
            let bytes = &self.buffer[self.taken..];
            if bytes.is_empty() {
                return self.check_end();
            }
            let decoded = self.now.decoder.decode(bytes, self.is_at_end, columns);
            let (latest, length) = (self.now.latest, bytes.len());
            // Events are counted before a fault is returned, since they were appended before it.
            self.now.latest = columns.t[before..].iter().copied().fold(latest, Micros::max);
            self.now.events += (columns.len() - before) as u64;
            let took = decoded.map_err(|DecodeFault { at, reason }| self.damage(at, reason))?;
            // The decoder waits for more than a block holds, or than the file has.
            if took == 0 {
                let reason = match self.is_at_end {
                    true => format!("the file ends {length} bytes into a record"),
                    false => format!("a record of more than {length} bytes"),
                };
                return Err(self.damage(0, reason.into()));
            }
            self.taken += took;
            self.now.byte += took as u64;
            // A mark every so many bytes is where a search may begin.
            if self.marks.last().is_none_or(|last| self.now.byte >= last.byte + BETWEEN_MARKS) {
                self.marks.push(self.now.clone());
            }
        }
        Ok(())
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        let known = self.marks.partition_point(|mark| mark.latest < t);
        let mut from = self.marks[known.saturating_sub(1)].clone();
        // Unless the index does not reach there yet and reading has come further.
        if known == self.marks.len() && self.now.latest < t && self.now.byte > from.byte {
            from = self.now.clone();
        }
        self.go_to(from);
        // The index ends here: read and discard blocks up to the one that reaches `t`.
        let mut discarded = Columns::new();
        let mut before = self.now.clone();
        while self.now.latest < t {
            before = self.now.clone();
            discarded.clear();
            self.next(&mut discarded)?;
            if discarded.is_empty() {
                return Ok(());
            }
        }
        self.go_to(before);
        Ok(())
    }

    fn duration(&self) -> Option<Micros> {
        self.now.decoder.duration()
    }

    fn remarks(&self) -> Vec<String> {
        self.now.decoder.remarks()
    }
}

impl<D: Decoder> BlockSource<D> {
    fn go_to(&mut self, mark: Mark<D>) {
        self.buffer.clear();
        self.taken = 0;
        self.is_at_end = false;
        self.now = mark;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evt::{Evt3Decoder, Evt3Encoder, WordEncoder, synthetic};

    #[test]
    fn a_file_that_is_cut_while_it_is_read_is_damage() {
        let events = synthetic::scattered(50_000);
        let mut words = Vec::new();
        Evt3Encoder::new(events.sensor()).encode(&events, &mut words).unwrap();
        let length = words.len() as u64;
        // At the end of a word and in the middle of one.
        for cut in [(words.len() / 2) & !1, (words.len() / 2) | 1] {
            let mut input = Input::memory("cut.raw", words[..cut].to_vec());
            input.length = length;
            let decoder = Evt3Decoder::new(None);
            let mut source = BlockSource::new(input, 0, Header::default(), decoder);
            let mut columns = Columns::new();
            let error = source.read_rest(&mut columns).unwrap_err();
            assert!(error.is_damage() && columns.len() > 20_000, "{error}");
            assert_eq!(error.byte(), Some(cut as u64 & !1), "{error}");
        }
    }
}
