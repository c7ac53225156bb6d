//! Order of the polarity channels.

use evpose_core::Polarity;
use serde::{Deserialize, Serialize};

/// Order of the polarities in a plane of two channels.
///
/// EventHands' own programs differ: simulator and live demo put OFF first, the predictors of
/// recorded files ON. Its training augmentation makes the network indifferent; nothing else is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelOrder {
    /// Channel 0 is OFF, channel 1 is ON: the channel is the polarity's number.
    #[default]
    OffFirst,
    /// Channel 0 is ON, channel 1 is OFF.
    OnFirst,
}

impl ChannelOrder {
    /// The channel of a polarity, 0 or 1.
    pub fn channel(self, polarity: Polarity) -> usize {
        usize::from(polarity.is_on() == (self == Self::OffFirst))
    }

    /// The polarity of a channel.
    pub fn polarity(self, channel: usize) -> Polarity {
        Polarity::from_on((channel == 1) == (self == Self::OffFirst))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_names_the_polarity_of_channel_0() {
        assert_eq!(ChannelOrder::OffFirst.channel(Polarity::Off), 0);
        assert_eq!(ChannelOrder::OffFirst.channel(Polarity::On), 1);
        assert_eq!(ChannelOrder::OnFirst.channel(Polarity::On), 0);
        assert_eq!(ChannelOrder::OnFirst.channel(Polarity::Off), 1);
        for order in [ChannelOrder::OffFirst, ChannelOrder::OnFirst] {
            for channel in 0..2 {
                assert_eq!(order.channel(order.polarity(channel)), channel);
            }
        }
    }
}
