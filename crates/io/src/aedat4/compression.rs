//! How packets are compressed, and back.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};

use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};
use zrip::{DecompressContext, DecompressError};

#[cfg(feature = "zstd")]
use super::libzstd::LibZstd;
use super::lz4;

/// Bytes that a packet may become: a file of a few bytes must not fill the memory.
pub(super) const MAX_BYTES: usize = 1 << 28;
/// Bytes that a byte of Zstandard can become: blocks of 128 KiB out of four.
const MAX_RATIO: usize = 1 << 15;
/// Of Zstandard, as dv-processing takes it.
const LEVEL: i32 = 3;

/// How the packets of a file are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Not at all.
    None,
    /// LZ4 frames.
    #[default]
    Lz4,
    /// LZ4 frames for which matches were searched longer. Only read.
    Lz4High,
    /// Zstandard frames.
    Zstd,
    /// Zstandard frames for which matches were searched longer. Only read.
    ZstdHigh,
}

impl Compression {
    /// All algorithms, in the order of their codes in a header.
    pub const ALL: [Self; 5] = [Self::None, Self::Lz4, Self::Lz4High, Self::Zstd, Self::ZstdHigh];

    /// Whether there is a compressor for it here.
    pub fn is_writable(self) -> bool {
        matches!(self, Self::None | Self::Lz4 | Self::Zstd)
    }

    /// As headers name it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::None => "NONE",
            Self::Lz4 => "LZ4",
            Self::Lz4High => "LZ4_HIGH",
            Self::Zstd => "ZSTD",
            Self::ZstdHigh => "ZSTD_HIGH",
        }
    }
}

impl fmt::Display for Compression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Compresses a packet as a frame of its own.
pub(super) fn deflate(compression: Compression, bytes: &[u8], out: &mut Vec<u8>) -> io::Result<()> {
    out.clear();
    match compression {
        Compression::None => out.extend_from_slice(bytes),
        Compression::Lz4 | Compression::Lz4High => {
            let info = FrameInfo::new()
                .block_size(BlockSize::Max256KB)
                .block_mode(BlockMode::Independent)
                .content_checksum(true);
            let mut encoder = FrameEncoder::with_frame_info(info, out);
            encoder.write_all(bytes)?;
            encoder.finish().map_err(io::Error::other)?;
        }
        Compression::Zstd | Compression::ZstdHigh => {
            // With the size of its content, without which dv-processing reads no frame, and with its
            // checksum.
            *out = zrip::compress(bytes, LEVEL).map_err(io::Error::other)?;
        }
    }
    Ok(())
}

/// Memory that is kept from packet to packet. What was decompressed is `bytes[..filled]`.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    bytes: Vec<u8>,
    filled: usize,
}

impl Scratch {
    pub(super) fn clear(&mut self) {
        self.filled = 0;
    }

    pub(crate) fn filled(&self) -> &[u8] {
        &self.bytes[..self.filled]
    }

    /// Appends room for `length` further bytes, if a packet may have that many.
    pub(super) fn room(&mut self, length: usize) -> Option<(&[u8], &mut [u8])> {
        let need = self.filled + length;
        if need > MAX_BYTES {
            return None;
        }
        if self.bytes.len() < need {
            self.bytes.resize(need, 0);
        }
        let (before, rest) = self.bytes.split_at_mut(self.filled);
        Some((before, &mut rest[..length]))
    }

    /// Counts bytes that were written into the room.
    pub(super) fn add(&mut self, length: usize) {
        self.filled += length;
    }
}

impl Write for Scratch {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let (_, room) = self.room(bytes.len()).ok_or_else(|| io::Error::other(TOO_LONG))?;
        room.copy_from_slice(bytes);
        self.add(bytes.len());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

pub(super) const TOO_LONG: &str = "a packet of more than 256 MiB";

/// Decompresses packets.
pub(crate) struct Inflater {
    zstd: DecompressContext,
    #[cfg(feature = "zstd")]
    libzstd: Option<LibZstd>,
    pub(crate) out: Scratch,
}

impl Inflater {
    pub(crate) fn new() -> Self {
        Self {
            zstd: DecompressContext::new(),
            #[cfg(feature = "zstd")]
            libzstd: LibZstd::new(),
            out: Scratch::default(),
        }
    }

    /// Replaces what is in `out` by what `bytes` were compressed from; after a fault it is the part
    /// before it.
    pub(crate) fn inflate(
        &mut self,
        compression: Compression,
        bytes: &[u8],
    ) -> Result<(), Cow<'static, str>> {
        self.out.clear();
        match compression {
            Compression::None => self.out.write_all(bytes).map_err(|e| e.to_string().into()),
            Compression::Lz4 | Compression::Lz4High => lz4::inflate(bytes, &mut self.out),
            Compression::Zstd | Compression::ZstdHigh => self.zstd(bytes),
        }
    }

    fn zstd(&mut self, bytes: &[u8]) -> Result<(), Cow<'static, str>> {
        // A few bytes must not fill the memory.
        let limit = bytes.len().saturating_mul(MAX_RATIO).min(MAX_BYTES);
        let out = &mut self.out;
        #[cfg(feature = "zstd")]
        // What the library refuses, the other decoder explains.
        if let Some(library) = &mut self.libzstd
            && library.decompress(bytes, limit, &mut out.bytes)
        {
            out.filled = out.bytes.len();
            return Ok(());
        }
        out.bytes.clear();
        let whole = self.zstd.decompress_into_with_limit(bytes, &mut out.bytes, limit);
        out.filled = out.bytes.len();
        match whole {
            Ok(_) => Ok(()),
            // At the limit of all packets it is the packet that is too long.
            Err(DecompressError::OutputTooSmall) if limit == MAX_BYTES => Err(TOO_LONG.into()),
            Err(DecompressError::OutputTooSmall) => {
                Err("Zstandard: a frame claims more than its bytes can hold".into())
            }
            Err(fault) => Err(format!("Zstandard: {fault}").into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_zstandard_state_what_they_hold() {
        let bytes: Vec<u8> = (0..400_000_u32).map(|i| (i / 7) as u8).collect();
        for size in [0, 1, 255, 256, 65_791, bytes.len()] {
            let mut frame = Vec::new();
            deflate(Compression::Zstd, &bytes[..size], &mut frame).unwrap();
            // Single segment or not, some of the two highest bits or the third are set.
            assert!(frame[4] & 0b1110_0000 != 0, "{size}");
            let mut inflater = Inflater::new();
            inflater.inflate(Compression::Zstd, &frame).unwrap();
            assert!(inflater.out.filled() == &bytes[..size]);
        }
    }

    /// The library as `zrip`, whole frames and frames with a fault.
    #[cfg(feature = "zstd")]
    mod library {
        use proptest::prelude::*;

        use super::*;

        /// Whether a frame is read, and its bytes.
        type Read = (Result<(), Cow<'static, str>>, Vec<u8>);

        /// A frame read without the library, and with it.
        fn both(frame: &[u8]) -> [Read; 2] {
            let rust = Inflater { libzstd: None, ..Inflater::new() };
            [rust, Inflater::new()].map(|mut inflater| {
                let result = inflater.inflate(Compression::Zstd, frame);
                (result, inflater.out.filled().to_vec())
            })
        }

        proptest! {
            #[test]
            fn reads_the_same(
                runs in prop::collection::vec((any::<u8>(), 1..300_usize), 0..200),
                cut in any::<prop::sample::Index>(),
                changed in any::<prop::sample::Index>(),
                by in 1..=255_u8,
                frames in 1..3_usize,
            ) {
                let bytes: Vec<u8> = runs
                    .iter()
                    .flat_map(|&(value, count)| (0..count).map(move |k| value ^ (k / 9) as u8))
                    .collect();
                let mut frame = Vec::new();
                deflate(Compression::Zstd, &bytes, &mut frame).unwrap();
                let whole = frame.repeat(frames);
                let [rust, library] = both(&whole);
                prop_assert_eq!(&rust.1, &bytes.repeat(frames));
                prop_assert_eq!(rust, library);
                let [rust, library] = both(&whole[..cut.index(whole.len())]);
                prop_assert_eq!(rust, library);
                let mut damaged = whole;
                let at = changed.index(damaged.len());
                damaged[at] ^= by;
                let [rust, library] = both(&damaged);
                prop_assert_eq!(rust, library);
            }
        }
    }
}
