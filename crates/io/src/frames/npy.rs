//! An `.npy` array of frames, read frame by frame.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use evpose_core::{AtomicFile, SensorSize};
use npyz::{Order, WriterBuilder};

use super::fault::sensor_size;
use super::light::Light;
use super::{About, Encoding, FrameDepth, FrameFault, Frames};
use crate::{IoError, npz};

/// The frames of an array that are still to come.
pub(super) struct NpyFrames {
    reader: BufReader<File>,
    values: Values,
    is_big_endian: bool,
    frames: u64,
    next: u64,
    /// Byte at which the first frame begins.
    begin: u64,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy)]
enum Values {
    U8,
    U16,
    F16,
    F32,
    F64,
}

impl Values {
    fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn depth(self) -> FrameDepth {
        match self {
            Self::U8 => FrameDepth::Eight,
            Self::U16 => FrameDepth::Sixteen,
            Self::F16 | Self::F32 | Self::F64 => FrameDepth::Float,
        }
    }
}

impl NpyFrames {
    pub(super) fn open(path: &Path) -> Result<(Self, About), IoError> {
        let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
        let length = file.metadata().map_err(|e| IoError::file(path, "read", e))?.len();
        Self::read_header(file, length).map_err(|fault| IoError::frames(path, fault))
    }

    fn read_header(file: File, length: u64) -> Result<(Self, About), FrameFault> {
        let not_an_array = |e: io::Error| FrameFault::NotAnArray(e.to_string());
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let header = npz::header(&mut reader);
        let header = header.map_err(|fault| FrameFault::NotAnArray(fault.to_string()))?;
        let begin = reader.stream_position().map_err(not_an_array)?;
        let descr = header.dtype().descr();
        // Byte order and type, as in '<u2'.
        let (order, kind) = descr.trim_matches('\'').split_at_checked(1).unwrap_or_default();
        let values = match kind {
            "u1" => Values::U8,
            "u2" => Values::U16,
            "f2" => Values::F16,
            "f4" => Values::F32,
            "f8" => Values::F64,
            _ => return Err(FrameFault::Type(descr)),
        };
        let (frames, height, width) = match *header.shape() {
            // Grey images that kept a dimension for their one channel.
            [frames, height, width] | [frames, height, width, 1]
                if frames > 0 && height > 0 && width > 0 =>
            {
                (frames, height, width)
            }
            _ => return Err(FrameFault::Shape(header.shape().to_vec())),
        };
        if header.order() != Order::C {
            return Err(FrameFault::Columns);
        }
        let size = sensor_size(width, height)?;
        let frame = (size.pixels() * values.bytes()) as u64;
        let there = length.saturating_sub(begin);
        if there / frame < frames {
            let whole = there / frame;
            return Err(FrameFault::Truncated { whole, of: frames, byte: begin + whole * frame });
        }
        if there > frame * frames {
            return Err(FrameFault::Trailing(there - frame * frames));
        }
        // Only now: a header may claim any size.
        let bytes = vec![0; frame as usize];
        let is_big_endian = order == ">";
        let about = About::new(size, values.depth(), frames);
        Ok((Self { reader, values, is_big_endian, frames, next: 0, begin, bytes }, about))
    }

    /// The largest value of all frames; the next frame is the first again.
    pub(super) fn brightest(&mut self, path: &Path, about: &About) -> Result<f64, IoError> {
        let values = Light::new(about.depth, Encoding::Linear, Some(1.0));
        let (mut frame, mut brightest) = (vec![0.0; about.size.pixels()], 0f32);
        while self.next_into(path, &values, &mut frame)? {
            let finite = frame.iter().copied().filter(|value| value.is_finite());
            brightest = finite.fold(brightest, f32::max);
        }
        let rewound = self.reader.seek(SeekFrom::Start(self.begin));
        rewound.map_err(|e| IoError::file(path, "read", e))?;
        self.next = 0;
        Ok(brightest.into())
    }
}

impl Frames for NpyFrames {
    fn next_into(&mut self, path: &Path, light: &Light, out: &mut [f32]) -> Result<bool, IoError> {
        if self.next == self.frames {
            return Ok(false);
        }
        let read = self.reader.read_exact(&mut self.bytes);
        read.map_err(|e| IoError::file(path, "read", e))?;
        self.next += 1;
        if self.is_big_endian {
            // Turned around in place: all types below are then little-endian.
            self.bytes.chunks_exact_mut(self.values.bytes()).for_each(<[u8]>::reverse);
        }
        let pairs = || self.bytes.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b));
        match self.values {
            Values::U8 => fill(out, self.bytes.iter().map(|code| light.code_to_light(*code))),
            Values::U16 => fill(out, pairs().map(|code| light.code_to_light(code))),
            Values::F16 => fill(out, pairs().map(|bits| light.value_to_light(half(bits)))),
            Values::F32 => {
                let values = self.bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
                fill(out, values.map(|value| light.value_to_light(value.into())));
            }
            Values::F64 => {
                let values = self.bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
                fill(out, values.map(|value| light.value_to_light(value)));
            }
        }
        Ok(true)
    }
}

/// Writes frames of 8-bit codes as an array that [`FrameSource`](super::FrameSource) reads.
///
/// # Errors
/// If a frame is not of this size, or the file cannot be written.
pub fn write_codes(path: &Path, size: SensorSize, frames: &[Vec<u8>]) -> Result<(), IoError> {
    // Before the file exists, so that a wrong frame replaces no array.
    if let Some(frame) = frames.iter().position(|frame| frame.len() != size.pixels()) {
        return Err(IoError::unwritable(path, format!("frame {frame} has not {size} pixels")));
    }
    let failed = |e| IoError::file(path, "write", e);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    let shape = [frames.len() as u64, size.height.into(), size.width.into()];
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let written = options.writer(&mut file).begin_nd().and_then(|mut npy| {
        npy.extend(frames.iter().flatten().copied())?;
        npy.finish()
    });
    written.and_then(|()| file.flush()).map_err(failed)?;
    file.commit().map_err(failed)
}

fn fill(out: &mut [f32], light: impl Iterator<Item = f32>) {
    out.iter_mut().zip(light).for_each(|(y, light)| *y = light);
}

/// The value of an IEEE 754 half-precision number.
fn half(bits: u16) -> f64 {
    // IEEE 754 binary16: 5 bits of exponent, biased by 15, and 10 of fraction.
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction > 0.0 => f64::NAN,
        31 => f64::INFINITY,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn halves_have_their_value() {
        for (bits, value) in [
            (0x0000u16, 0.0),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x3555, 0.333_251_953_125),
            (0x7bff, 65_504.0),
            (0x0400, 6.103_515_625e-5),
            (0x0001, 5.960_464_477_539_063e-8),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }
}
