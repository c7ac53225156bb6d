//! Events to dense planes: LNES and the representations it was compared with.
//!
//! Two forms of the same definitions:
//! * [`FrameSurface`]: from 1 ms frames, as recordings in `.evc` files come; what training uses.
//! * [`Representation`]: streaming, in continuous time; what a live pipeline uses.
//!
//! [`REPRESENTATIONS`] is the registry: adding one is a file and a line.

mod augment;
mod channel;
mod eci;
mod eoi;
mod frame;
mod lnes;
mod streaming;

pub use augment::Augmentation;
pub use channel::ChannelOrder;
pub use frame::{FrameEvent, FrameSurface, WindowSpec};
pub use streaming::{Representation, Sliding};

/// One representation under the name configs use.
#[derive(Debug, Clone, Copy)]
pub struct Spec {
    /// Name in configs.
    pub name: &'static str,
    /// What it shows, in a line.
    pub summary: &'static str,
    /// How events become pixels.
    pub surface: &'static dyn FrameSurface,
}

/// Every representation there is.
pub const REPRESENTATIONS: &[Spec] = &[
    Spec {
        name: "lnes",
        summary: "locally normalised event surface: how recent the last event of each polarity is",
        surface: &lnes::Lnes,
    },
    Spec {
        name: "eoi",
        summary: "event occurrence image: whether there was an event of each polarity",
        surface: &eoi::Eoi,
    },
    Spec {
        name: "eci",
        summary: "event count image: events of each polarity",
        surface: &eci::Eci { both: false, once_per_frame: false },
    },
    Spec {
        name: "eci-s",
        summary: "single-channel event count image: events of both polarities, in both channels",
        surface: &eci::Eci { both: true, once_per_frame: false },
    },
    Spec {
        name: "eci-parity",
        summary: "ECI as EventHands' code: at most one event a pixel, polarity and millisecond",
        surface: &eci::Eci { both: false, once_per_frame: true },
    },
    Spec {
        name: "eci-s-parity",
        summary: "ECI-S as EventHands' code: at most one event a pixel, polarity and millisecond",
        surface: &eci::Eci { both: true, once_per_frame: true },
    },
];

/// The representation called `name`.
pub fn by_name(name: &str) -> Option<&'static Spec> {
    REPRESENTATIONS.iter().find(|spec| spec.name == name)
}

/// All names, in the order of the registry.
pub fn names() -> Vec<&'static str> {
    REPRESENTATIONS.iter().map(|spec| spec.name).collect()
}
