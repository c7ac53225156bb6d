//! LZ4 frames, decompressed block by block behind each other, so that a block finds what it refers
//! to in the blocks before.
//!
//! # Source
//! <https://github.com/lz4/lz4/blob/dev/doc/lz4_Frame_format.md>

use std::borrow::Cow;

use lz4_flex::block::{decompress_into, decompress_into_with_dict};
use twox_hash::XxHash32;

use super::compression::{Scratch, TOO_LONG};

/// Magic number of a frame.
const MAGIC: u32 = 0x184D_2204;
/// Magic number of skippable frames, but for the last four bits.
const SKIPPED: u32 = 0x184D_2A50;
/// How far back a match may be.
const WINDOW: usize = 1 << 16;
/// A block that was not compressed has this bit in its size.
const PLAIN: u32 = 1 << 31;

type Fault = Cow<'static, str>;

/// Appends what the frames in `bytes` were compressed from. Before a fault, whole blocks are
/// appended.
pub(super) fn inflate(mut bytes: &[u8], out: &mut Scratch) -> Result<(), Fault> {
    if bytes.is_empty() {
        return Err(cut());
    }
    while !bytes.is_empty() {
        match number(&mut bytes)? {
            MAGIC => frame(&mut bytes, out)?,
            // The format lets other programs put data of theirs between frames.
            magic if magic & !15 == SKIPPED => {
                let length = number(&mut bytes)? as usize;
                take(&mut bytes, length)?;
            }
            _ => return Err("LZ4: no frame begins here".into()),
        }
    }
    Ok(())
}

fn frame(bytes: &mut &[u8], out: &mut Scratch) -> Result<(), Fault> {
    // The checksum of the header covers these bytes as they are.
    let descriptor = *bytes;
    let [flags, sizes] = *take(bytes, 2)?.as_array().ok_or_else(cut)?;
    let has = |bit: u8| flags & (1 << bit) != 0;
    // The upper two bits are the version, which is 1.
    if flags >> 6 != 1 {
        return Err(format!("LZ4: frames of version {} are not known", flags >> 6).into());
    }
    if has(0) {
        return Err("LZ4: the dictionary of the frame is not there".into());
    }
    let longest = match (sizes >> 4) & 7 {
        // Codes 4 to 7: 64 KiB, 256 KiB, 1 MiB, 4 MiB.
        code @ 4..=7 => 1_usize << (8 + 2 * code),
        code => return Err(format!("LZ4: blocks of size code {code} are not known").into()),
    };
    // With the content's size, which is not needed.
    let length = if has(3) { 10 } else { 2 };
    take(bytes, length - 2)?;
    let [check] = *take(bytes, 1)?.as_array().ok_or_else(cut)?;
    if check != (XxHash32::oneshot(0, &descriptor[..length]) >> 8) as u8 {
        return Err("LZ4: the checksum of a frame's header does not fit".into());
    }
    let begin = out.filled().len();
    loop {
        let size = number(bytes)?;
        // A size of zero is the end mark, not a block.
        if size == 0 {
            break;
        }
        let block = take(bytes, (size & !PLAIN) as usize)?;
        if has(4) && number(bytes)? != XxHash32::oneshot(0, block) {
            return Err("LZ4: the checksum of a block does not fit".into());
        }
        // A packed block does not state its length: room for the longest is given back afterwards.
        let length = if size & PLAIN != 0 { block.len() } else { longest };
        if length > longest {
            return Err("LZ4: a block is longer than its frame allows".into());
        }
        let (before, room) = out.room(length).ok_or(TOO_LONG)?;
        // A block refers back by a window at most, and never into the frame before.
        let before = &before[begin.max(before.len().saturating_sub(WINDOW))..];
        let got = if size & PLAIN != 0 {
            room.copy_from_slice(block);
            length
        } else if has(5) || before.is_empty() {
            // Independent blocks, and a first one, have nothing before them.
            decompress_into(block, room).map_err(|e| format!("LZ4: {e}"))?
        } else {
            decompress_into_with_dict(block, room, before).map_err(|e| format!("LZ4: {e}"))?
        };
        out.add(got);
    }
    if has(2) && number(bytes)? != XxHash32::oneshot(0, &out.filled()[begin..]) {
        return Err("LZ4: the checksum of a frame does not fit".into());
    }
    Ok(())
}

fn cut() -> Fault {
    "LZ4: a frame is cut".into()
}

fn take<'a>(bytes: &mut &'a [u8], length: usize) -> Result<&'a [u8], Fault> {
    bytes.split_off(..length).ok_or_else(cut)
}

fn number(bytes: &mut &[u8]) -> Result<u32, Fault> {
    let four = take(bytes, 4)?.as_array().ok_or_else(cut)?;
    Ok(u32::from_le_bytes(*four))
}
