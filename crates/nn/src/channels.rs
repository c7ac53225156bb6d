//! Channel counts of networks of another width, and the checks of their shapes.

use crate::NnError;

/// `published` channels, `width` times as many, at least one.
pub fn scaled(published: usize, width: f32) -> usize {
    (published as f32 * width).round().max(1.0) as usize
}

/// The multiple of 8 nearest to `channels`, at least 8 and never more than a tenth below: the
/// rounding of MobileNets and of MnasNet.
pub fn multiple_of_eight(channels: f32) -> usize {
    let nearest = (((channels + 4.0) / 8.0).floor() * 8.0).max(8.0);
    if nearest < 0.9 * channels { nearest as usize + 8 } else { nearest as usize }
}

/// The largest relative width: 64 times the published work, beyond what memory holds.
const MAX_WIDTH: f32 = 8.0;

/// # Errors
/// [`NnError::Width`] outside of `narrowest` to [`MAX_WIDTH`].
pub(crate) fn check_width(width: f32, narrowest: f32) -> Result<(), NnError> {
    match (narrowest..=MAX_WIDTH).contains(&width) {
        true => Ok(()),
        false => Err(NnError::Width { width }),
    }
}

/// # Errors
/// [`NnError::TooFew`] for the first count that is zero.
pub(crate) fn check_counts(counts: &[(&'static str, usize)]) -> Result<(), NnError> {
    match counts.iter().find(|(_, count)| *count == 0) {
        Some((field, _)) => Err(NnError::TooFew { field }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_eight_are_those_published() {
        // torchvision's `_make_divisible` at multipliers 0.35, 0.5, 0.75 and 1.4.
        assert_eq!([0.35, 0.5, 0.75, 1.4].map(|w| multiple_of_eight(24.0 * w)), [8, 16, 24, 32]);
        assert_eq!([0.35, 0.5, 0.75, 1.4].map(|w| multiple_of_eight(32.0 * w)), [16, 16, 24, 48]);
        // Its `_round_to_multiple_of` for the example in its own words.
        assert_eq!([83.0, 84.0].map(multiple_of_eight), [80, 88]);
    }

    #[test]
    fn no_layer_is_scaled_away() {
        assert_eq!([0.001, 0.1, 1.0, 2.0].map(|width| scaled(64, width)), [1, 6, 64, 128]);
    }
}
