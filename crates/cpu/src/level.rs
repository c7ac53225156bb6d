//! Levels of vector instructions, and their detection.

use std::fmt;

#[cfg(target_arch = "x86_64")]
use crate::tiles::AmxFeatures;

/// Instructions that kernels are compiled for.
///
/// ```
/// use evpose_cpu::Level;
///
/// let levels = Level::available();
/// assert_eq!(levels.first(), Some(&Level::best()));
/// assert_eq!(levels.last(), Some(&Level::Portable));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Level {
    /// The baseline that the program is compiled for.
    Portable,
    /// AVX2 and FMA: eight `f32` in a register.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512F and BW: sixteen `f32` in a register.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// All levels of this processor, the best first.
    pub fn available() -> Vec<Self> {
        let mut levels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            // x86-64-v3: the standard library keeps the result of the first detection.
            let has_avx2 = pulp::x86::V3::try_new().is_some();
            if has_avx2
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
            {
                levels.push(Self::Avx512);
            }
            if has_avx2 {
                levels.push(Self::Avx2);
            }
        }
        levels.push(Self::Portable);
        levels
    }

    /// The best level of this processor.
    pub fn best() -> Self {
        Self::available()[0]
    }

    /// Whether registers hold the accumulators of two nChw16c blocks for many pixels: AVX-512 has
    /// 32 registers.
    #[inline]
    pub fn has_room_for_two_blocks(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512;
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Whether four products of bytes are added at once (AVX512-VNNI).
    #[inline]
    pub(crate) fn has_vnni(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512 && is_x86_feature_detected!("avx512vnni");
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Whether tiles multiply bytes (AMX-INT8) beside this level's instructions.
    #[inline]
    pub(crate) fn has_amx_int8(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512 && AmxFeatures::of_this_process().int8;
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Whether tiles multiply bfloat16 values (AMX-BF16) beside this level's instructions.
    #[inline]
    pub(crate) fn has_amx_bf16(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512 && AmxFeatures::of_this_process().bf16;
        #[cfg(not(target_arch = "x86_64"))]
        false
    }

    /// Whether two products of bfloat16 values are added at once (AVX512-BF16).
    #[inline]
    pub(crate) fn has_bf16(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self == Self::Avx512 && is_x86_feature_detected!("avx512bf16");
        #[cfg(not(target_arch = "x86_64"))]
        false
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        })
    }
}
