//! Chunks packed by Blosc2 (HDF5 filter 32026): a frame around chunks of Blosc2, mostly one.
//!
//! A frame is a header of MessagePack, the chunks, an index and a trailer. Of the header, `b2frame` and
//! lengths at fixed places are read, these big-endian: its own, the bytes unpacked, those of the
//! packed chunks, those of a value, and those of a chunk unpacked; and the shapes of arrays of several
//! dimensions (`b2nd.rs`). The index is a chunk, too, of the place of each chunk behind the header in
//! 64 bits; if the highest bit is set, all values are one, and no chunk is there.
//!
//! A chunk, little-endian, is that of Blosc (`blosc.rs`) with 16 bytes more of header: six filters, in
//! the order in which they were applied, the codec of plugins in two bytes, a parameter of each filter,
//! and two bytes of flags, whose bits 4 to 6 mark chunks of one value. Streams of length 0 are zeros,
//! and those of a negative length, behind one byte more, that many times one byte.
//!
//! Source: `README_CFRAME_FORMAT.rst`, `README_CHUNK_FORMAT.rst` and `blosc2.c` of c-blosc2 3.3
//! (BSD-3-Clause), read for the format.

use std::borrow::Cow;

use super::b2nd::Shapes;
use super::blosc::Codec;
use super::shuffle;

/// Places in the header of a frame.
const MAGIC: (usize, &[u8]) = (2, b"b2frame\0");
const HEADER_LENGTH: usize = 0x0b;
const UNPACKED: usize = 0x1e;
const PACKED: usize = 0x27;
const VALUE_SIZE: usize = 0x30;
const CHUNK: usize = 0x3a;
/// Versions of the format of chunks.
const VERSIONS: std::ops::RangeInclusive<u8> = 5..=6;
/// Bytes of the header of a chunk.
const HEADER: usize = 32;
/// Flags that together stand for the long header, and those that are as in Blosc.
const LONG: u8 = 5;
const STORED: u8 = 2;
const NOT_SPLIT: u8 = 16;
/// Further flags: a dictionary, a still longer header, blocks that are elsewhere.
const UNREAD: u8 = 0b1011;
/// Chunks of one value: zeros, the value behind the header, or whatever was in memory.
const ZEROS: u8 = 1;
const VALUE: u8 = 3;
const UNSET: u8 = 4;

/// Reason in errors of damaged chunks.
type Reason = Cow<'static, str>;

const ENDS: Reason = Cow::Borrowed("a Blosc2 frame ends before its last byte");

/// Appends what is packed in `frame` to `out`, of at most `most` bytes.
pub(super) fn decode(frame: &[u8], most: usize, out: &mut Vec<u8>) -> Result<(), Reason> {
    if !frame.get(MAGIC.0..).is_some_and(|rest| rest.starts_with(MAGIC.1)) {
        return Err("no Blosc2 frame".into());
    }
    let header = number::<4>(frame, HEADER_LENGTH)?;
    let (unpacked, packed) = (number::<8>(frame, UNPACKED)?, number::<8>(frame, PACKED)?);
    let chunk = number::<4>(frame, CHUNK)?;
    let (metadata, rest) = frame.split_at_checked(header).ok_or(ENDS)?;
    let shapes = Shapes::of(metadata, number::<4>(frame, VALUE_SIZE)?, most)?;
    // A damaged header must not decide how much memory is taken.
    let expected = shapes.as_ref().map(|shapes| shapes.chunks().checked_mul(shapes.chunk_bytes()));
    if expected.map_or(unpacked > most, |bytes| bytes != Some(unpacked)) {
        return Err(format!("a Blosc2 frame of {unpacked} bytes, more than {most}").into());
    }
    if unpacked == 0 {
        return Ok(());
    }
    if chunk == 0 || shapes.as_ref().is_some_and(|shapes| shapes.chunk_bytes() != chunk) {
        return Err(format!("Blosc2 chunks of {chunk} bytes").into());
    }
    let (chunks, index) = rest.split_at_checked(packed).ok_or(ENDS)?;
    let (mut places, mut values) = (Vec::new(), Vec::new());
    unpack(index, unpacked.div_ceil(chunk) * size_of::<u64>(), &mut places)?;
    let begin = out.len();
    out.resize(begin + shapes.as_ref().map_or(0, Shapes::bytes), 0);
    for (k, place) in places.as_chunks().0.iter().enumerate() {
        let place = u64::from_le_bytes(*place);
        let bytes = chunk.min(unpacked - k * chunk);
        match &shapes {
            None => unpack_at(place, chunks, bytes, out)?,
            Some(shapes) => {
                values.clear();
                unpack_at(place, chunks, bytes, &mut values)?;
                shapes.place(k, &values, &mut out[begin..]);
            }
        }
    }
    Ok(())
}

/// Appends the `unpacked` bytes of the chunk at a place of the index to `out`.
fn unpack_at(place: u64, chunks: &[u8], unpacked: usize, out: &mut Vec<u8>) -> Result<(), Reason> {
    match (place >> 63, (place >> 56) as u8 & 7) {
        (0, _) => {
            let chunk = usize::try_from(place).ok().and_then(|place| chunks.get(place..));
            unpack(chunk.ok_or(ENDS)?, unpacked, out)
        }
        (_, ZEROS | UNSET) => {
            out.resize(out.len() + unpacked, 0);
            Ok(())
        }
        (_, other) => Err(format!("a Blosc2 chunk of values of kind {other}").into()),
    }
}

/// A number of the header of a frame.
fn number<const BYTES: usize>(frame: &[u8], at: usize) -> Result<usize, Reason> {
    let bytes = frame.get(at..at + BYTES).ok_or(ENDS)?;
    let number = bytes.iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
    Ok(usize::try_from(number).unwrap_or(usize::MAX))
}

/// Appends the `unpacked` bytes of a chunk to `out`.
fn unpack(chunk: &[u8], unpacked: usize, out: &mut Vec<u8>) -> Result<(), Reason> {
    let header: &[u8; HEADER] = chunk.first_chunk().ok_or(ENDS)?;
    let [version, _, flags, size, ..] = *header;
    // Three lengths: of the bytes, of a block, and of the chunk with its header.
    let length = |at: usize| u32::from_le_bytes(header[4..16].as_chunks().0[at]) as usize;
    let (block, more) = (length(1), header[31]);
    if !VERSIONS.contains(&version) || flags & LONG != LONG || more & UNREAD != 0 || header[30] != 0
    {
        return Err(format!("a Blosc2 chunk of version {version}, flags {flags:x} {more:x}").into());
    }
    if length(0) != unpacked {
        return Err(format!("a Blosc2 chunk of {} bytes, not {unpacked}", length(0)).into());
    }
    let chunk = chunk.get(..length(2)).ok_or(ENDS)?;
    let content = chunk.get(HEADER..).ok_or(ENDS)?;
    match more >> 4 & 7 {
        0 => {}
        ZEROS | UNSET => {
            out.resize(out.len() + unpacked, 0);
            return Ok(());
        }
        VALUE if !content.is_empty() => {
            out.extend(content.iter().cycle().take(unpacked));
            return Ok(());
        }
        other => return Err(format!("a Blosc2 chunk of values of kind {other}").into()),
    }
    if flags & STORED != 0 {
        out.extend_from_slice(content.get(..unpacked).ok_or(ENDS)?);
        return Ok(());
    }
    if block == 0 || size == 0 {
        return Err(format!("Blosc2 blocks of {block} bytes, values of {size}").into());
    }
    let codec = Codec::from_code(flags >> 5)?;
    let starts = content.get(..unpacked.div_ceil(block) * 4).ok_or(ENDS)?;
    let (mut values, mut filtered) = (Vec::new(), Vec::new());
    for (k, start) in starts.as_chunks().0.iter().enumerate() {
        let streams = chunk.get(u32::from_le_bytes(*start) as usize..).ok_or(ENDS)?;
        let bytes = block.min(unpacked - k * block);
        // A last block that is shorter is packed as one stream.
        let count = if flags & NOT_SPLIT == 0 && bytes == block { size.into() } else { 1 };
        values.clear();
        values.resize(bytes, 0);
        unpack_streams(streams, count, codec, &mut values)?;
        // The last filter of writing is the first of reading.
        for (filter, parameter) in header[16..22].iter().zip(&header[24..30]).rev() {
            filtered.clear();
            filtered.resize(bytes, 0);
            match filter {
                // None, and one that cut bits off.
                0 | 4 => continue,
                1 => {
                    let size = if *parameter == 0 { size } else { *parameter };
                    shuffle::bytes(&values, size.into(), &mut filtered);
                }
                2 => {
                    // Values behind the last eight stand as they are.
                    let eight = 8 * usize::from(size);
                    let eights = bytes / eight * eight;
                    shuffle::bits(&values[..eights], size.into(), &mut filtered[..eights]);
                    filtered[eights..].copy_from_slice(&values[eights..]);
                }
                _ => return Err(format!("Blosc2's filter {filter}, which is not read").into()),
            }
            std::mem::swap(&mut values, &mut filtered);
        }
        out.extend_from_slice(&values);
    }
    Ok(())
}

/// Unpacks the `count` streams of a block.
fn unpack_streams(
    mut packed: &[u8],
    count: usize,
    codec: Codec,
    out: &mut [u8],
) -> Result<(), Reason> {
    if out.len() < count || !out.len().is_multiple_of(count) {
        return Err(format!("a Blosc2 block of {} bytes in {count}", out.len()).into());
    }
    for out in out.chunks_exact_mut(out.len() / count) {
        let (length, rest) = packed.split_first_chunk().ok_or(ENDS)?;
        let length = i32::from_le_bytes(*length);
        packed = rest;
        if let (Ok(value), true) = (u8::try_from(length.unsigned_abs()), length <= 0) {
            out.fill(value);
            // A byte of flags follows, except for zeros.
            packed = if value == 0 { packed } else { packed.get(1..).ok_or(ENDS)? };
            continue;
        }
        let length = usize::try_from(length).map_err(|_| ENDS)?;
        let (stream, rest) = packed.split_at_checked(length).ok_or(ENDS)?;
        packed = rest;
        // What does not get smaller by packing is stored as it is.
        if stream.len() == out.len() {
            out.copy_from_slice(stream);
        } else {
            codec.decode(stream, out)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of `unpacked` bytes by the format's description, around a chunk with `flags`.
    fn frame(unpacked: u32, flags: u8, content: &[u8], metadata: &[u8]) -> Vec<u8> {
        let chunk = |unpacked: u32, flags: u8, more: u8, content: &[u8]| {
            let mut chunk = vec![5, 1, LONG | flags, 2];
            let packed = (HEADER + content.len()) as u32;
            chunk.extend([unpacked, unpacked, packed].map(u32::to_le_bytes).concat());
            chunk.resize(HEADER - 1, 0);
            chunk.push(more);
            [&chunk, content].concat()
        };
        let packed = chunk(unpacked, flags & STORED, flags & !STORED, content);
        let mut frame = vec![0; 0x57];
        frame[MAGIC.0..][..8].copy_from_slice(MAGIC.1);
        let header = (frame.len() + metadata.len()) as u32;
        frame[HEADER_LENGTH..][..4].copy_from_slice(&header.to_be_bytes());
        frame[UNPACKED + 4..][..4].copy_from_slice(&unpacked.to_be_bytes());
        frame[PACKED + 4..][..4].copy_from_slice(&(packed.len() as u32).to_be_bytes());
        frame[CHUNK..][..4].copy_from_slice(&unpacked.to_be_bytes());
        [&frame, metadata, &packed, &chunk(8, STORED, 0, &[0; 8])].concat()
    }

    #[test]
    fn chunks_are_stored_or_one_value_many_times() {
        let read = |frame: &[u8]| {
            let mut out = vec![9];
            decode(frame, 6, &mut out).map(|()| out)
        };
        assert_eq!(read(&frame(4, STORED, &[1, 2, 3, 4], &[])).unwrap(), [9, 1, 2, 3, 4]);
        assert_eq!(read(&frame(4, VALUE << 4, &[1, 2], &[])).unwrap(), [9, 1, 2, 1, 2]);
        assert_eq!(read(&frame(4, ZEROS << 4, &[], &[])).unwrap(), [9, 0, 0, 0, 0]);
        for (frame, reason) in [
            (frame(8, STORED, &[0; 8], &[]), "8 bytes, more than 6"),
            (frame(4, STORED, &[0; 4], b"\xa4b2nd\xd2"), "several dimensions"),
            (frame(4, 2 << 4, &[], &[]), "values of kind 2"),
            (frame(4, 1, &[0; 4], &[]), "flags 5 1"),
            (frame(4, STORED, &[0; 3], &[]), "ends before"),
        ] {
            let refused = read(&frame).unwrap_err();
            assert!(refused.contains(reason), "{refused}");
        }
    }
}
