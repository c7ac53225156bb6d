//! Response of the frame buffer: from radiance to the luminance that events are made from.

use evpose_cpu::Lanes8;
use glam::Vec3A;
use serde::{Deserialize, Serialize};

/// Weights of red, green and blue in the luminance of the published event generator.
const LUMINANCE_WEIGHTS: Vec3A = Vec3A::new(0.2, 0.7, 0.1);

/// Luminance of a linear colour.
///
/// # Source
/// EventHands simulator: `0.2 R + 0.7 G + 0.1 B`.
#[inline]
pub fn luminance(rgb: Vec3A) -> f32 {
    rgb.dot(LUMINANCE_WEIGHTS)
}

/// Clipping and quantisation of a colour before its luminance is taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameResponse {
    /// Neither: radiance above reference white stays.
    Linear,
    /// Each channel clipped at reference white, as the published frame buffer does; its eight bits
    /// are left to the sensor's quantisation.
    #[default]
    Clipped,
    /// Each channel clipped and rounded to eight bits, as the published frame buffer.
    Rgb8,
}

impl FrameResponse {
    /// Clips and quantises a colour.
    #[inline]
    pub fn apply(self, rgb: Vec3A) -> Vec3A {
        match self {
            Self::Linear => rgb,
            Self::Clipped => rgb.min(Vec3A::ONE),
            Self::Rgb8 => (rgb.min(Vec3A::ONE) * 255.0 + 0.5).trunc() * (1.0 / 255.0),
        }
    }

    /// Luminance of eight colours after clipping and quantisation.
    #[inline(always)]
    pub(super) fn luminance_of<L: Lanes8>(self, l: L, rgb: [L::F; 3]) -> L::F {
        let [r, g, b] =
            [self.apply_lanes(l, rgb[0]), self.apply_lanes(l, rgb[1]), self.apply_lanes(l, rgb[2])];
        let [of_r, of_g, of_b] = LUMINANCE_WEIGHTS.to_array();
        let rg = l.add(l.mul(r, l.splat(of_r)), l.mul(g, l.splat(of_g)));
        l.add(rg, l.mul(b, l.splat(of_b)))
    }

    /// Clips and quantises one channel of eight colours.
    #[inline(always)]
    fn apply_lanes<L: Lanes8>(self, l: L, channel: L::F) -> L::F {
        let clipped = l.min(channel, l.splat(1.0));
        match self {
            Self::Linear => channel,
            Self::Clipped => clipped,
            Self::Rgb8 => {
                // Half up, as graphics hardware converts to 8 bits.
                let code = l.floor(l.add(l.mul(clipped, l.splat(255.0)), l.splat(0.5)));
                l.mul(code, l.splat(1.0 / 255.0))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_has_luminance_one_and_channels_their_weights() {
        assert!((luminance(Vec3A::ONE) - 1.0).abs() < 1e-6);
        assert!((luminance(Vec3A::new(0.0, 0.5, 0.0)) - 0.35).abs() < 1e-6);
    }

    #[test]
    fn eight_bits_keep_256_values_and_clip() {
        let kept = FrameResponse::Rgb8.apply(Vec3A::new(1.3, 0.5, 0.001));
        let want = Vec3A::new(1.0, 128.0 / 255.0, 0.0);
        assert!((kept - want).length() < 1e-6);
        assert_eq!(FrameResponse::Linear.apply(Vec3A::splat(1.3)), Vec3A::splat(1.3));
        assert_eq!(FrameResponse::Clipped.apply(Vec3A::splat(1.3)), Vec3A::ONE);
    }
}
