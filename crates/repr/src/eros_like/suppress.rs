//! Thinning of edges: only pixels whose gradient is the strongest along its direction remain.
//!
//! # Model
//! A pixel stays if its strength is above the low threshold, above that of the neighbour before it
//! and not below that of the neighbour behind it; across a diagonal it must be above both. Outside
//! the image, gradients are zero.

use super::gradient::{Strength, sector};

/// Rows of strengths above, at and below a row of pixels; each begins one pixel before the row and
/// ends one behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows<'a, S> {
    pub(super) above: &'a [S],
    pub(super) here: &'a [S],
    pub(super) below: &'a [S],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds<S> {
    pub(super) low: S,
    pub(super) high: S,
}

/// Bit of a pixel that stays.
const CANDIDATE: u8 = 1;
/// Bit of a pixel that stays and is above the high threshold.
const STRONG: u8 = 2;

/// Bits of what becomes of each pixel.
#[inline(always)]
pub(super) fn classify<S: Strength>(
    rows: Rows<'_, S>,
    sectors: &[u8],
    thresholds: Thresholds<S>,
    classes: &mut [u8],
) {
    let width = classes.len();
    let sectors = &sectors[..width];
    let (above_left, above, above_right) = shifted(rows.above, width);
    let (left, here, right) = shifted(rows.here, width);
    let (below_left, below, below_right) = shifted(rows.below, width);
    for x in 0..width {
        let (sector, strength) = (sectors[x], here[x]);
        // All eight are read in any case: a choice among places would read them one by one.
        let (rising, falling) = ((above_right[x], below_left[x]), (above_left[x], below_right[x]));
        let (upright, level) = ((above[x], below[x]), (left[x], right[x]));
        let (before, behind) = if sector == sector::FALLING { falling } else { rising };
        let slanted = (before, behind.next());
        let steep = if sector == sector::UPRIGHT { upright } else { slanted };
        let (before, behind) = if sector == sector::LEVEL { level } else { steep };
        let stays = (strength > before) & (strength >= behind) & (strength > thresholds.low);
        let strong = stays & (strength > thresholds.high);
        classes[x] = (u8::from(stays) * CANDIDATE) | (u8::from(strong) * STRONG);
    }
}

/// Left neighbour, pixel and right neighbour of each pixel.
#[inline(always)]
fn shifted<S>(row: &[S], width: usize) -> (&[S], &[S], &[S]) {
    (&row[..width], &row[1..][..width], &row[2..][..width])
}

/// One bit a pixel, 64 a word, of those that stay and of those that are strong.
#[inline(always)]
pub(super) fn pack(classes: &[u8], candidates: &mut [u64], strong: &mut [u64]) {
    let (words, _) = classes.as_chunks::<64>();
    for ((word, candidates), strong) in words.iter().zip(candidates).zip(strong) {
        *candidates = u64::from_le_bytes(gather::<CANDIDATE>(word));
        *strong = u64::from_le_bytes(gather::<STRONG>(word));
    }
}

/// One bit of each byte.
#[inline(always)]
fn gather<const BIT: u8>(bytes: &[u8; 64]) -> [u8; 8] {
    let (eights, _) = bytes.as_chunks::<8>();
    let mut out = [0; 8];
    for (out, eight) in out.iter_mut().zip(eights) {
        let mut bits = (u64::from_le_bytes(*eight) / u64::from(BIT)) & 0x0101_0101_0101_0101;
        // Each step halves the distance between bits: eight bytes become the bits of one.
        bits |= bits >> 7;
        bits |= bits >> 14;
        bits |= bits >> 28;
        *out = bits as u8;
    }
    out
}
