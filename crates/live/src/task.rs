//! What is done with events.

use evpose_core::{EventStream, Micros};

use crate::{Answer, LiveError};

/// Follows events, and knows where poses are between those of the network. Lives on one thread.
pub trait Eye: Send {
    /// What the network is shown.
    type Image: Send + 'static;
    /// What the network says of it.
    type Found: Send + 'static;

    /// Takes events, which are in order and later than those before.
    ///
    /// # Errors
    /// If they cannot be followed.
    fn push(&mut self, events: &EventStream) -> Result<(), LiveError>;

    /// A stride has passed: a surface is due at `t`, the time of the last event, for those who gather some.
    fn stride(&mut self, t: Micros) {
        let _ = t;
    }

    /// What the network, which is free, is to be shown at `t`, in the memory of an image that it is done with.
    /// None where there is nothing new to see: the last answer then stands.
    fn image(&mut self, t: Micros, memory: Option<Self::Image>) -> Option<Self::Image>;

    /// Takes what the network said of the image of `t`; it is `now` meanwhile. Returns the poses that the image
    /// was of, with their times.
    fn found(
        &mut self,
        t: Micros,
        image: &Self::Image,
        found: Self::Found,
        now: Micros,
    ) -> Vec<(Micros, Answer)>;

    /// The pose at `t`, which comes as often as the options say. None as long as nothing is known.
    fn between(&mut self, t: Micros) -> Option<Answer>;

    /// Forgets everything: another recording begins.
    fn reset(&mut self);
}

/// Computes poses. Lives on a thread of its own.
pub trait Network: Send {
    /// What it is shown.
    type Image;
    /// What it says.
    type Found;

    /// Looks at an image.
    ///
    /// # Errors
    /// If it cannot be computed.
    fn look(&mut self, image: &Self::Image) -> Result<Self::Found, LiveError>;
}

/// An eye and the network behind it.
pub struct Task<E, N> {
    /// Follows events.
    pub eye: E,
    /// Computes poses.
    pub network: N,
}
