//! Which polarity is which channel.

use evpose_core::Polarity;
use serde::{Deserialize, Serialize};

/// Which polarity is channel 0.
///
/// Explicit because the published programs differ: EventHands' simulator and live demo put OFF
/// first, its readers of recordings put ON first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelOrder {
    /// Channel 0 is ON.
    OnFirst,
    /// Channel 0 is OFF.
    #[default]
    OffFirst,
}

impl ChannelOrder {
    /// The channel of a polarity: 0 or 1.
    pub fn channel(self, polarity: Polarity) -> usize {
        usize::from(polarity.is_on() == (self == Self::OffFirst))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_channel_is_the_one_the_order_names() {
        assert_eq!(ChannelOrder::OnFirst.channel(Polarity::On), 0);
        assert_eq!(ChannelOrder::OnFirst.channel(Polarity::Off), 1);
        assert_eq!(ChannelOrder::OffFirst.channel(Polarity::Off), 0);
        assert_eq!(ChannelOrder::OffFirst.channel(Polarity::On), 1);
    }
}
