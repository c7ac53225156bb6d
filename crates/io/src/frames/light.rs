//! Stored values to luminance relative to white.

use super::{Encoding, FrameDepth};

/// The weights of red, green and blue in luminance, ITU-R BT.709.
const WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Values to light. Codes go through a table.
#[derive(Debug)]
pub(super) struct Light {
    encoding: Encoding,
    white: f64,
    table: Vec<f32>,
}

impl Light {
    pub(super) fn new(depth: FrameDepth, encoding: Encoding, white: Option<f64>) -> Self {
        let (codes, usual) = match depth {
            FrameDepth::Eight => (1u32 << 8, 255.0),
            FrameDepth::Sixteen => (1 << 16, 65_535.0),
            FrameDepth::Float => (0, 1.0),
        };
        let white = white.unwrap_or(usual);
        let mut light = Self { encoding, white, table: Vec::new() };
        // A table costs one power for each code, instead of one for each pixel.
        light.table = (0..codes).map(|code| light.value_to_light(f64::from(code))).collect();
        light
    }

    pub(super) fn white(&self) -> f64 {
        self.white
    }

    pub(super) fn value_to_light(&self, value: f64) -> f32 {
        let relative = value / self.white;
        let light = match self.encoding {
            Encoding::Linear => relative,
            Encoding::Srgb if relative <= 0.040_45 => relative / 12.92,
            Encoding::Srgb => ((relative + 0.055) / 1.055).powf(2.4),
        };
        light as f32
    }

    /// Light of a code that the depth has; no other ever comes.
    #[inline(always)]
    pub(super) fn code_to_light(&self, code: impl Into<usize>) -> f32 {
        self.table.get(code.into()).copied().unwrap_or(0.0)
    }

    #[inline(always)]
    pub(super) fn rgb_to_light(&self, codes: [impl Into<usize>; 3]) -> f32 {
        let [red, green, blue] = codes.map(|code| self.code_to_light(code));
        WEIGHTS[0] * red + WEIGHTS[1] * green + WEIGHTS[2] * blue
    }
}
