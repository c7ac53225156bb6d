//! Meanings of the colours of a frame.

use image::Rgb;

use evpose_report::canvas::{PREDICTION, TRUTH};
use evpose_report::colour::{OFF, ON};

/// A colour and its meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Key {
    /// A word with letters of [`evpose_report::dot_letters`].
    pub(super) name: &'static str,
    pub(super) colour: Rgb<u8>,
}

/// Keys of what is drawn: polarities, if a frame has them, and true and predicted joints.
pub(super) fn keys(has_polarities: bool, has_truth: bool, has_predictions: bool) -> Vec<Key> {
    let rgb = |(r, g, b): (u8, u8, u8)| Rgb([r, g, b]);
    [
        (has_polarities, Key { name: "ON", colour: rgb(ON) }),
        (has_polarities, Key { name: "OFF", colour: rgb(OFF) }),
        (has_truth, Key { name: "true", colour: TRUTH }),
        (has_predictions, Key { name: "predicted", colour: PREDICTION }),
    ]
    .into_iter()
    .filter_map(|(is_drawn, key)| is_drawn.then_some(key))
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_those_of_what_is_drawn() {
        let names = |a, b, c| keys(a, b, c).iter().map(|key| key.name).collect::<Vec<_>>();
        assert_eq!(names(true, true, true), ["ON", "OFF", "true", "predicted"]);
        assert_eq!(names(false, false, true), ["predicted"]);
        assert!(names(false, false, false).is_empty());
    }
}
