//! ECF, Prophesee's packing of chunks of events (HDF5 filter 0x8ECF).
//!
//! A chunk, all of it little-endian, is
//!
//! 1. 32 bits: the number of events, two bits that say how pixels are packed;
//! 2. the first time, 64 bits;
//! 3. times, a byte a run: four bits of a step from the last time, four of a count of events. A count
//!    of 15 stands in the next two bytes. Bytes with a step of 15 hold four bits each of a step that
//!    is longer, the lowest first, and no event;
//! 4. pixels: either `y x p` of 11, 11 and 1 bits in 24 each, four of them in three words of 32 bits;
//!    or rows, then the rest. Rows are runs of 16 bits, the row and five bits of a count (31: it
//!    stands in the next 16). The rest is either `x p` of 11 and 1 bits, four of them in three words of
//!    16; or columns, 11 bits and five that say which of the next five pixels have an event too, then
//!    polarities, runs of a byte with seven bits of a count (127: it stands in the next two bytes).
//!
//! Source: Prophesee, `hdf5_ecf` 1.0 (Apache-2.0), read for the format.

use std::borrow::Cow;

use evpose_core::{Micros, Polarity};

use crate::{Columns, DecodeFault, DecodeResult};

/// The most events of a chunk.
const MAX_EVENTS: usize = 65_535;
/// Runs of up to so many events are written with one store of this length.
const SHORT: usize = 8;

/// Appends the events of a chunk, all or none, and returns how many those are.
pub(super) fn decode(bytes: &[u8], columns: &mut Columns) -> DecodeResult {
    let before = columns.len();
    let mut packed = Packed { bytes, at: 0 };
    let events = packed.events(columns).and_then(|events| match bytes.len() - packed.at {
        0 => Ok(events),
        rest => Err(format!("{rest} bytes behind the last event of a chunk").into()),
    });
    events.map_err(|reason| {
        // Columns are lengthened before they are filled, so that a fault has to shorten them.
        columns.truncate(before);
        DecodeFault { at: packed.at, reason }
    })
}

/// Reason in errors of damaged chunks.
type Reason = Cow<'static, str>;

const ENDS: &str = "a chunk ends before its last event";
const OVERRUN: &str = "a run of more events than the chunk has";

/// Reads a chunk from its beginning on.
struct Packed<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Packed<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Reason> {
        let rest = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk());
        let taken = rest.ok_or(Cow::Borrowed(ENDS))?;
        self.at += N;
        Ok(*taken)
    }

    fn byte(&mut self) -> Result<u8, Reason> {
        self.take::<1>().map(|[byte]| byte)
    }

    fn half(&mut self) -> Result<u16, Reason> {
        self.take().map(u16::from_le_bytes)
    }

    fn events(&mut self, columns: &mut Columns) -> Result<usize, Reason> {
        let header = u32::from_le_bytes(self.take()?);
        // Two flags below the count.
        let (events, is_packed, has_polarity) =
            ((header >> 2) as usize, header & 2 != 0, header & 1 != 0);
        // Before memory is taken for them.
        if events > MAX_EVENTS {
            return Err(format!("a chunk of {events} events, more than {MAX_EVENTS}").into());
        }
        let before = columns.len();
        columns.t.resize(before + events, Micros(0));
        self.times(&mut columns.t[before..])?;
        columns.x.resize(before + events, 0);
        columns.y.resize(before + events, 0);
        columns.polarity.resize(before + events, Polarity::Off);
        let (x, y, polarity) =
            (&mut columns.x[before..], &mut columns.y[before..], &mut columns.polarity[before..]);
        if is_packed {
            self.pixels(x, y, polarity)?;
        } else {
            self.rows(y)?;
            if has_polarity {
                self.columns_with_polarities(x, polarity)?;
            } else {
                self.columns(x)?;
                self.polarities(polarity)?;
            }
        }
        Ok(events)
    }

    fn times(&mut self, out: &mut [Micros]) -> Result<(), Reason> {
        let mut now = i64::from_le_bytes(self.take()?);
        let mut done = 0;
        while done < out.len() {
            let byte = self.byte()?;
            let (step, count) = (byte >> 4, byte & 15);
            // A step of 15 announces a long one, in nibbles of the bytes behind; a count of 15
            // likewise.
            if step < 15 {
                now = now.wrapping_add(step.into());
                let count = if count < 15 { count.into() } else { self.half()? };
                done = run(out, done, count.into(), Micros(now))?;
                continue;
            }
            let (mut long, mut shift) = (u64::from(count), 4);
            while let Some(next) = self.bytes.get(self.at).filter(|next| **next >> 4 == 15) {
                if shift >= 64 {
                    return Err("a step in time of more than 64 bits".into());
                }
                long |= u64::from(next & 15) << shift;
                shift += 4;
                self.at += 1;
            }
            now = now.wrapping_add(long as i64);
        }
        Ok(())
    }

    fn rows(&mut self, out: &mut [u16]) -> Result<(), Reason> {
        let mut done = 0;
        while done < out.len() {
            let word = self.half()?;
            let count = if word & 31 < 31 { word & 31 } else { self.half()? };
            done = run(out, done, count.into(), word >> 5)?;
        }
        Ok(())
    }

    fn columns(&mut self, out: &mut [u16]) -> Result<(), Reason> {
        let mut done = 0;
        while done < out.len() {
            let word = self.half()?;
            // Eleven bits are the first column; five say which of the next are there.
            let (x, more) = (word >> 5, word & 31);
            // Behind the last event, packers leave bits that mean nothing.
            let mut next = [x; 6];
            let mut count = 1;
            for k in 1..6 {
                next[count] = x + k;
                count += usize::from(more >> (5 - k) & 1);
            }
            // Six values fit nearly always: a fixed length is one store.
            match out.get_mut(done..).and_then(|rest| rest.first_chunk_mut()) {
                Some(rest) => *rest = next,
                None => {
                    let rest = &mut out[done..];
                    let count = count.min(rest.len());
                    rest[..count].copy_from_slice(&next[..count]);
                }
            }
            done += count;
        }
        Ok(())
    }

    fn polarities(&mut self, out: &mut [Polarity]) -> Result<(), Reason> {
        let mut done = 0;
        while done < out.len() {
            let byte = self.byte()?;
            let count = if byte & 127 < 127 { u16::from(byte & 127) } else { self.half()? };
            done = run(out, done, count.into(), Polarity::from_on(byte >> 7 == 1))?;
        }
        Ok(())
    }

    fn columns_with_polarities(
        &mut self,
        x: &mut [u16],
        polarity: &mut [Polarity],
    ) -> Result<(), Reason> {
        let groups = self.groups::<6>(x.len())?.iter();
        for ((x, polarity), group) in x.chunks_mut(4).zip(polarity.chunks_mut(4)).zip(groups) {
            let word = |k: usize| u16::from_le_bytes([group[2 * k], group[2 * k + 1]]);
            let [a, b, c] = [word(0), word(1), word(2)];
            // Three words of 16 bits hold four values of 12: 11 of x above the polarity.
            let values = [a >> 4, a & 0xf | b >> 8 << 4, b & 0xff | c >> 12 << 8, c & 0xfff];
            for ((x, polarity), value) in x.iter_mut().zip(polarity).zip(values) {
                *x = value >> 1;
                *polarity = Polarity::from_on(value & 1 == 1);
            }
        }
        Ok(())
    }

    fn pixels(
        &mut self,
        x: &mut [u16],
        y: &mut [u16],
        polarity: &mut [Polarity],
    ) -> Result<(), Reason> {
        let groups = self.groups::<12>(x.len())?.iter();
        let out = x.chunks_mut(4).zip(y.chunks_mut(4)).zip(polarity.chunks_mut(4));
        for (((x, y), polarity), group) in out.zip(groups) {
            let words = group.as_chunks::<4>().0;
            let word = |k: usize| u32::from_le_bytes(words[k]);
            let [a, b, c] = [word(0), word(1), word(2)];
            // Three words of 32 bits hold four values of 24: y and x of 11 each above the polarity.
            let values =
                [a >> 8, a & 0xff | b >> 16 << 8, b & 0xffff | c >> 24 << 16, c & 0xff_ffff];
            for (((x, y), polarity), value) in x.iter_mut().zip(y).zip(polarity).zip(values) {
                *y = (value >> 12 & 0x7ff) as u16;
                *x = (value >> 1 & 0x7ff) as u16;
                *polarity = Polarity::from_on(value & 1 == 1);
            }
        }
        Ok(())
    }

    /// The next groups of `N` bytes, one for four of `events`.
    fn groups<const N: usize>(&mut self, events: usize) -> Result<&[[u8; N]], Reason> {
        let length = events.div_ceil(4) * N;
        let taken = self.bytes.get(self.at..self.at + length).ok_or(Cow::Borrowed(ENDS))?;
        self.at += length;
        Ok(taken.as_chunks().0)
    }
}

/// Writes `count` values from `done` on and returns what is done then.
#[inline(always)]
fn run<T: Copy>(out: &mut [T], done: usize, count: usize, value: T) -> Result<usize, Reason> {
    let end = done + count;
    if let Some(short) = out.get_mut(done..).and_then(|rest| rest.first_chunk_mut::<SHORT>())
        && count <= SHORT
    {
        // What is written too far is overwritten by the runs that follow.
        *short = [value; SHORT];
    } else {
        out.get_mut(done..end).ok_or(Cow::Borrowed(OVERRUN))?.fill(value);
    }
    Ok(end)
}

#[cfg(test)]
pub(super) mod tests;
