//! How chunks are packed, undone.
//!
//! Deflate, Fletcher's sum and HDF5's other own filters are `hdf5-reader`'s; Blosc, Blosc2, ECF, LZF,
//! LZ4 and zstd are here.

use std::borrow::Cow;

use hdf5_reader::FilterRegistry;
use hdf5_reader::filters::deflate;
use hdf5_reader::messages::filter_pipeline::FilterDescription;

use super::{blosc, blosc2, lzf, shuffle};

/// Prophesee's packing of events; it takes whole tables of them, so nothing can come before it.
const ECF: u16 = 0x8ecf;
const SHUFFLE: u16 = 2;
const LZF: u16 = 32000;
const BLOSC: u16 = 32001;
const LZ4: u16 = 32004;
const BITSHUFFLE: u16 = 32008;
const ZSTD: u16 = 32015;
const BLOSC2: u16 = 32026;

/// Filters of other libraries that are known and not undone.
const UNREAD: &[(u16, &str)] = &[(307, "bzip2"), (32013, "ZFP"), (32017, "SZ"), (32024, "SZ3")];

/// No codec makes more bytes of one: zstd writes 128 KiB of one value in four bytes.
pub(super) const TIGHTEST: usize = 32_768;

/// Reason in errors of damaged chunks.
type Reason = Cow<'static, str>;

/// The filters of a dataset in the order in which they were applied.
pub(super) struct Filters {
    list: Vec<FilterDescription>,
    others: FilterRegistry,
    /// Bytes of an element.
    element: usize,
    between: Vec<u8>,
}

impl Filters {
    pub(super) fn new(list: Vec<FilterDescription>, element: usize) -> Self {
        Self { list, others: FilterRegistry::new(), element, between: Vec::new() }
    }

    /// Whether chunks stand in the file as they are.
    pub(super) fn is_none(&self) -> bool {
        self.list.is_empty()
    }

    /// Names of the filters, for whoever asks what the file is.
    pub(super) fn names(&self) -> String {
        self.list.iter().map(name).collect::<Vec<_>>().join(", ")
    }

    /// Whether a chunk that skips the filters of the set bits of `skipped` is packed by ECF.
    pub(super) fn is_ecf(&self, skipped: u32) -> bool {
        self.list.first().is_some_and(|filter| filter.id == ECF) && skipped & 1 == 0
    }

    /// Unpacks a chunk in place, except for a first ECF; `whole` are the bytes that it should have.
    pub(super) fn undo(
        &mut self,
        bytes: &mut Vec<u8>,
        skipped: u32,
        whole: usize,
    ) -> Result<(), Reason> {
        // The last filter of writing is the first of reading.
        for (k, filter) in self.list.iter().enumerate().rev() {
            if skipped.checked_shr(k as u32).is_some_and(|bits| bits & 1 == 1)
                || k == 0 && filter.id == ECF
            {
                continue;
            }
            self.between.clear();
            let out = &mut self.between;
            match filter.id {
                SHUFFLE => {
                    out.resize(bytes.len(), 0);
                    shuffle::bytes(bytes, self.element.max(1), out);
                }
                BLOSC => blosc::decode(bytes, whole, out)?,
                BLOSC2 => blosc2::decode(bytes, whole, out)?,
                LZ4 => lz4_blocks(bytes, whole, out)?,
                BITSHUFFLE => bitshuffled(bytes, &filter.client_data, whole, out)?,
                LZF | ZSTD => {
                    // Before memory is taken: nothing packs tighter.
                    if whole / TIGHTEST > bytes.len() {
                        return Err("a packed chunk ends before its last byte".into());
                    }
                    out.resize(whole, 0);
                    match filter.id {
                        LZF => lzf::decode(bytes, out).ok_or("a damaged LZF stream")?,
                        _ => zstd(bytes, out)?,
                    }
                }
                ECF => return Err("ECF behind another filter, which is not read".into()),
                // A message with the name of the filter: users can repack the file.
                id if UNREAD.iter().any(|(unread, _)| *unread == id) => {
                    let what =
                        format!("packed by {} (filter {id}), which is not read", name(filter));
                    let how = "repack it: h5repack -f SHUF -f GZIP=4 OLD.h5 NEW.h5";
                    return Err(format!("{what}: {how}").into());
                }
                _ => {
                    // One byte more than fits, so that it is seen; Fletcher's sum has four.
                    let limit = Some(whole + 5);
                    *out = self
                        .others
                        .apply_with_limit(filter, bytes, self.element, limit)
                        .map_err(|fault| fault.to_string())?;
                }
            }
            std::mem::swap(bytes, &mut self.between);
        }
        Ok(())
    }
}

fn name(filter: &FilterDescription) -> String {
    let known = match filter.id {
        1 => "deflate",
        SHUFFLE => "shuffle",
        3 => "fletcher32",
        LZF => "LZF",
        BLOSC => "Blosc",
        BLOSC2 => "Blosc2",
        LZ4 => "LZ4",
        BITSHUFFLE => "bitshuffle",
        ZSTD => "zstd",
        ECF => "ECF",
        id => match UNREAD.iter().find(|(unread, _)| *unread == id) {
            Some((_, name)) => name,
            None => return format!("filter {id}"),
        },
    };
    known.to_owned()
}

/// Unpacks a block of LZ4 to the last byte of `out`.
pub(super) fn lz4(packed: &[u8], out: &mut [u8]) -> Result<(), Reason> {
    let unpacked = lz4_flex::block::decompress_into(packed, out);
    fills(unpacked.map_err(|fault| format!("a damaged LZ4 stream: {fault}"))?, out)
}

/// Unpacks a zlib stream to the last byte of `out`.
pub(super) fn zlib(packed: &[u8], out: &mut [u8]) -> Result<(), Reason> {
    let unpacked = deflate::decompress_with_limit(packed, out.len() + 1);
    let unpacked = unpacked.map_err(|fault| fault.to_string())?;
    fills(unpacked.len(), out)?;
    out.copy_from_slice(&unpacked);
    Ok(())
}

/// Unpacks a frame of zstd to the last byte of `out`.
pub(super) fn zstd(packed: &[u8], out: &mut [u8]) -> Result<(), Reason> {
    let unpacked = zrip::decompress_with_limit(packed, out.len());
    let unpacked = unpacked.map_err(|fault| format!("a damaged zstd stream: {fault}"))?;
    fills(unpacked.len(), out)?;
    out.copy_from_slice(&unpacked);
    Ok(())
}

fn fills(unpacked: usize, out: &[u8]) -> Result<(), Reason> {
    if unpacked == out.len() {
        return Ok(());
    }
    Err(format!("a packed stream of {unpacked} bytes instead of {}", out.len()).into())
}

/// HDF5's filter of LZ4: the bytes unpacked (64 bits), bytes of a block (32), and blocks behind
/// their packed lengths (32), all of it big-endian. A block that did not shrink stands there as it
/// is.
fn lz4_blocks(mut packed: &[u8], most: usize, out: &mut Vec<u8>) -> Result<(), Reason> {
    const ENDS: Reason = Cow::Borrowed("an LZ4 chunk ends before its last byte");
    let (whole, rest) = packed.split_first_chunk().ok_or(ENDS)?;
    let (block, rest) = rest.split_first_chunk().ok_or(ENDS)?;
    packed = rest;
    let (whole, block) = (u64::from_be_bytes(*whole), u32::from_be_bytes(*block) as usize);
    if whole > most as u64 || block == 0 {
        return Err(format!("an LZ4 chunk of {whole} bytes, more than {most}").into());
    }
    while out.len() < whole as usize {
        // The last block may be shorter.
        let bytes = block.min(whole as usize - out.len());
        let (length, rest) = packed.split_first_chunk().ok_or(ENDS)?;
        let length = u32::from_be_bytes(*length) as usize;
        let (stream, rest) = rest.split_at_checked(length).ok_or(ENDS)?;
        packed = rest;
        let before = out.len();
        if stream.len() == bytes {
            out.extend_from_slice(stream);
        // LZ4 cannot pack tighter: a block that claims to would only take memory.
        } else if bytes / TIGHTEST > stream.len() {
            return Err(ENDS);
        } else {
            out.resize(before + bytes, 0);
            lz4(stream, &mut out[before..])?;
        }
    }
    Ok(())
}

/// HDF5's filter of bitshuffle: blocks of values whose bits are put side by side, plain, or packed by
/// LZ4 or zstd behind the bytes unpacked (64 bits) and those of a block (32), each behind its packed
/// length (32 bits), all big-endian. Up to seven last values stand as they are.
///
/// Source: `bshuf_h5filter.c` and `bitshuffle.c` of <https://github.com/kiyo-masui/bitshuffle> (MIT),
/// read for the format.
fn bitshuffled(
    mut packed: &[u8],
    parameters: &[u32],
    most: usize,
    out: &mut Vec<u8>,
) -> Result<(), Reason> {
    const ENDS: Reason = Cow::Borrowed("a bitshuffle chunk ends before its last byte");
    // Major and minor version, the bytes of a value, the values of a block, the packing.
    let parameter = |k: usize| parameters.get(k).copied().unwrap_or(0) as usize;
    let (size, packing) = (parameter(2), parameter(4));
    if size == 0 || packing > 3 || packing == 1 {
        return Err(format!("bitshuffle of values of {size} bytes, packing {packing}").into());
    }
    let (mut whole, mut block) = (packed.len(), parameter(3) * size);
    if packing > 0 {
        let (length, rest) = packed.split_first_chunk().ok_or(ENDS)?;
        let (bytes, rest) = rest.split_first_chunk().ok_or(ENDS)?;
        packed = rest;
        whole = usize::try_from(u64::from_be_bytes(*length)).unwrap_or(usize::MAX);
        block = u32::from_be_bytes(*bytes) as usize;
    }
    // As the library chooses it: what fits 8 KiB, in eights of values.
    if block == 0 {
        block = (8192 / size / 8 * 8).max(128) * size;
    }
    if whole > most || !block.is_multiple_of(8 * size) {
        return Err(format!("a bitshuffle chunk of {whole} bytes in blocks of {block}").into());
    }
    // A last block is shorter, but in eights of values.
    let last = whole % (8 * size);
    let mut shuffled = Vec::new();
    while out.len() < whole - last {
        let bytes = block.min(whole - last - out.len());
        let before = out.len();
        let stream = if packing > 0 {
            let (length, rest) = packed.split_first_chunk().ok_or(ENDS)?;
            let (stream, rest) =
                rest.split_at_checked(u32::from_be_bytes(*length) as usize).ok_or(ENDS)?;
            packed = rest;
            if bytes / TIGHTEST > stream.len() {
                return Err(ENDS);
            }
            shuffled.clear();
            shuffled.resize(bytes, 0);
            if packing == 2 {
                lz4(stream, &mut shuffled)?;
            } else {
                zstd(stream, &mut shuffled)?;
            }
            &shuffled
        } else {
            let (stream, rest) = packed.split_at_checked(bytes).ok_or(ENDS)?;
            packed = rest;
            stream
        };
        out.resize(before + bytes, 0);
        shuffle::bits(stream, size, &mut out[before..]);
    }
    out.extend_from_slice(packed.get(..last).ok_or(ENDS)?);
    Ok(())
}
