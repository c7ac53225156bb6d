//! The frames in which a simulated scene jumps.
//!
//! When the simulator draws a new hand, light and background, every pixel sees a change that no
//! camera would: a burst that says nothing about motion. A window that contains such a frame is
//! cleared after it has been drawn, so that only the events of later frames remain.
//!
//! # Source
//! The published loader clears at every frame number divisible by 50,000. The published
//! *simulator*, whose clock lags one step, draws in frames 0, 1, 50001, 100001, …

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Frames after which a window starts anew.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Transitions {
    /// The scene never jumps.
    #[default]
    Never,
    /// Frame 0 and every multiple of a period: our simulator, and the published loader.
    Every {
        /// Frames from one jump to the next.
        period_frames: u64,
    },
    /// Every multiple of a period and the frame after it: all the jumps of the published data.
    EveryAndNext {
        /// Frames from one jump to the next.
        period_frames: u64,
    },
    /// These frames, ascending.
    At {
        /// Frame numbers.
        frames: Vec<u64>,
    },
}

impl Transitions {
    /// The published loader's rule.
    pub const PUBLISHED_LOADER: Self = Self::Every { period_frames: 50_000 };
    /// Every frame in which the published simulator jumps.
    pub const PUBLISHED_DATA: Self = Self::EveryAndNext { period_frames: 50_000 };

    /// The last frame of `frames` in which the scene jumps.
    pub fn last_within(&self, frames: Range<u64>) -> Option<u64> {
        let newest = frames.end.checked_sub(1)?;
        let multiple = |period: u64| newest - newest.checked_rem(period).unwrap_or(0);
        let last = match self {
            Self::Never => return None,
            // A period of no frames is no period.
            Self::Every { period_frames: 0 } | Self::EveryAndNext { period_frames: 0 } => {
                return None;
            }
            Self::Every { period_frames } => multiple(*period_frames),
            Self::EveryAndNext { period_frames } => {
                newest.min(multiple(*period_frames).saturating_add(1))
            }
            Self::At { frames: at } => {
                *at.get(at.partition_point(|&frame| frame <= newest).checked_sub(1)?)?
            }
        };
        frames.contains(&last).then_some(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_loader_clears_at_multiples_of_50000() {
        let rule = Transitions::PUBLISHED_LOADER;
        assert_eq!(rule.last_within(0..100), Some(0));
        assert_eq!(rule.last_within(1..100), None);
        assert_eq!(rule.last_within(49_950..50_050), Some(50_000));
        assert_eq!(rule.last_within(49_900..50_000), None);
        assert_eq!(rule.last_within(50_001..50_101), None);
        assert_eq!(rule.last_within(10..10), None);
    }

    #[test]
    fn the_published_data_jump_in_the_frame_after_as_well() {
        let rule = Transitions::PUBLISHED_DATA;
        assert_eq!(rule.last_within(0..1), Some(0));
        assert_eq!(rule.last_within(0..100), Some(1));
        assert_eq!(rule.last_within(49_950..50_001), Some(50_000));
        assert_eq!(rule.last_within(49_950..50_050), Some(50_001));
        assert_eq!(rule.last_within(50_002..50_050), None);
    }

    #[test]
    fn listed_frames_are_found_and_no_period_is_never() {
        let rule = Transitions::At { frames: vec![3, 7] };
        assert_eq!(rule.last_within(0..3), None);
        assert_eq!(rule.last_within(0..7), Some(3));
        assert_eq!(rule.last_within(4..9), Some(7));
        assert_eq!(rule.last_within(8..9), None);
        assert_eq!(Transitions::Every { period_frames: 0 }.last_within(0..9), None);
        assert_eq!(Transitions::Never.last_within(0..9), None);
    }
}
