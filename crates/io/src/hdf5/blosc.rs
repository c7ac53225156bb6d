//! Chunks packed by Blosc (HDF5 filter 32001), the usual packing of DSEC and other data sets.
//!
//! A chunk, all of it little-endian, is 16 bytes of header (version of the format, version of the
//! codec, flags, bytes a value; then, each in 32 bits, the bytes unpacked, the bytes of a block
//! unpacked, and the bytes of all of it) and either the bytes as they are (flag 2), or 32 bits for
//! where each block begins, and the blocks. A block is one stream or, unless flag 16 is set, one
//! for each byte of a value: 32 bits of length, and the stream, unpacked already where it has the
//! length of what it stands for. Unpacked blocks are shuffled by bytes (flag 1) or by bits (flag
//! 4). Bits 5 to 7 of the flags are the codec.
//!
//! Source: `README_CHUNK_FORMAT.rst` and `blosc.c` of c-blosc 1.21 (BSD-3-Clause), read for the
//! format.

use std::borrow::Cow;

use super::{blosclz, filters, shuffle};

/// The version of the format that this is.
const VERSION: u8 = 2;
const HEADER: usize = 16;
/// Flags.
const BYTES_SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;
/// Blocks are split for values of up to so many bytes, if there are at least so many values.
const MAX_SPLITS: usize = 16;
const MIN_VALUES: usize = 128;

/// Reason in errors of damaged chunks.
type Reason = Cow<'static, str>;

const ENDS: Reason = Cow::Borrowed("a Blosc chunk ends before its last byte");

/// Appends what is packed in `chunk` to `out`, of at most `most` bytes.
pub(super) fn decode(chunk: &[u8], most: usize, out: &mut Vec<u8>) -> Result<(), Reason> {
    let [version, _, flags, size, lengths @ ..] = *chunk.first_chunk::<HEADER>().ok_or(ENDS)?;
    // Three lengths: of the bytes, of a block, and of the chunk with its header.
    let length = |k: usize| u32::from_le_bytes(lengths.as_chunks().0[k]) as usize;
    let (unpacked, block, packed) = (length(0), length(1), length(2));
    if version != VERSION {
        return Err(format!("a Blosc chunk of version {version}, not {VERSION}").into());
    }
    // A damaged header must not decide how much memory is taken.
    if unpacked > most {
        return Err(format!("a Blosc chunk of {unpacked} bytes, more than {most}").into());
    }
    let chunk = chunk.get(..packed).ok_or(ENDS)?;
    // Stored as it is where packing would have made it longer.
    if flags & STORED != 0 {
        out.extend_from_slice(chunk.get(HEADER..HEADER + unpacked).ok_or(ENDS)?);
        return Ok(());
    }
    if block == 0 || block > unpacked.max(1) || size == 0 {
        let reason = format!("Blosc blocks of {block} bytes, values of {size}, in {unpacked}");
        return Err(reason.into());
    }
    let codec = Codec::from_code(flags >> 5)?;
    // Each block's place in the chunk comes before all blocks.
    let starts = chunk.get(HEADER..).unwrap_or_default();
    let starts = starts.get(..unpacked.div_ceil(block) * 4).ok_or(ENDS)?;
    let mut unshuffled = Vec::new();
    for (k, start) in starts.as_chunks().0.iter().enumerate() {
        let start = u32::from_le_bytes(*start) as usize;
        let streams = chunk.get(start..).ok_or(ENDS)?;
        let bytes = block.min(unpacked - k * block);
        // No codec packs tighter, so that the memory asked for is within what the file is worth.
        if bytes / filters::TIGHTEST > streams.len() {
            return Err(ENDS);
        }
        // A last block that is shorter is packed as one stream.
        let shape = Block { size: size.into(), bytes, is_last: bytes < block, flags };
        let before = out.len();
        out.resize(before + bytes, 0);
        let out = &mut out[before..];
        // Unpacked first, shuffled back then: the reverse of writing.
        if shape.is_shuffled() {
            unshuffled.resize(bytes, 0);
            shape.streams(streams, codec, &mut unshuffled)?;
            match flags & BYTES_SHUFFLED {
                0 => shuffle::bits(&unshuffled, shape.size, out),
                _ => shuffle::bytes(&unshuffled, shape.size, out),
            }
        } else {
            shape.streams(streams, codec, out)?;
        }
    }
    Ok(())
}

/// Layout of a block.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// Bytes a value.
    size: usize,
    /// Bytes unpacked.
    bytes: usize,
    /// Whether it is shorter than the others.
    is_last: bool,
    flags: u8,
}

impl Block {
    fn is_shuffled(self) -> bool {
        self.flags & BYTES_SHUFFLED != 0 && self.size > 1
            || self.flags & BITS_SHUFFLED != 0 && self.bytes >= self.size
    }

    fn is_split(self) -> bool {
        self.flags & NOT_SPLIT == 0
            && self.size <= MAX_SPLITS
            && self.bytes / self.size >= MIN_VALUES
            && !self.is_last
    }

    /// Unpacks the streams of the block.
    fn streams(self, mut packed: &[u8], codec: Codec, out: &mut [u8]) -> Result<(), Reason> {
        // Split blocks hold the bytes of each place apart, which shuffled values pack better in.
        let streams = if self.is_split() { self.size } else { 1 };
        if !out.len().is_multiple_of(streams) {
            return Err(format!("a Blosc block of {} bytes in {streams}", out.len()).into());
        }
        for out in out.chunks_exact_mut(self.bytes / streams) {
            let (length, rest) = packed.split_first_chunk().ok_or(ENDS)?;
            let length = u32::from_le_bytes(*length) as usize;
            let (stream, rest) = rest.split_at_checked(length).ok_or(ENDS)?;
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
}

/// How streams are packed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Codec {
    BloscLz,
    Lz4,
    Zlib,
    Zstd,
}

impl Codec {
    pub(super) fn from_code(code: u8) -> Result<Self, Reason> {
        match code {
            0 => Ok(Self::BloscLz),
            1 => Ok(Self::Lz4),
            2 => Err("packed by Blosc with Snappy, which is not read".into()),
            3 => Ok(Self::Zlib),
            4 => Ok(Self::Zstd),
            _ => Err(format!("packed by Blosc with codec {code}, which is not known").into()),
        }
    }

    /// Unpacks a stream to the last byte of `out`.
    pub(super) fn decode(self, stream: &[u8], out: &mut [u8]) -> Result<(), Reason> {
        match self {
            Self::BloscLz => blosclz::decode(stream, out).ok_or("a damaged BloscLZ stream".into()),
            Self::Lz4 => filters::lz4(stream, out),
            Self::Zlib => filters::zlib(stream, out),
            Self::Zstd => filters::zstd(stream, out),
        }
    }
}
