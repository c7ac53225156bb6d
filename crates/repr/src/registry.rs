//! Every representation, by name.

use crate::{
    Counting, Eci, EciS, Eoi, FrameEvent, FrameWindow, Lnes, ReprError, Representation,
    StreamWindow, fill_eci, fill_eci_s, fill_eoi, fill_lnes,
};

/// A representation: what it is called and how it is made, from a stream and from frames.
#[derive(Debug, Clone, Copy)]
pub struct RepresentationSpec {
    /// Name in configurations.
    pub name: &'static str,
    /// What it shows, in a line.
    pub summary: &'static str,
    /// Planes it has.
    pub channels: usize,
    /// Starts it on a stream.
    pub start: fn(StreamWindow) -> Box<dyn Representation>,
    /// Fills `[channels][height][width]` from the events of a window, ascending in frame.
    pub fill: fn(&FrameWindow, &[FrameEvent], &mut [f32]),
}

/// All of them.
pub const REPRESENTATIONS: &[RepresentationSpec] = &[
    RepresentationSpec {
        name: "lnes",
        summary: "how recently a pixel fired, per polarity",
        channels: 2,
        start: |window| Box::new(Lnes::new(window)),
        fill: |window, events, out| fill_lnes(window, events.iter().copied(), out),
    },
    RepresentationSpec {
        name: "eoi",
        summary: "whether a pixel fired, per polarity",
        channels: 2,
        start: |window| Box::new(Eoi::new(window)),
        fill: |window, events, out| fill_eoi(window, events.iter().copied(), out),
    },
    RepresentationSpec {
        name: "eci",
        summary: "how often a pixel fired, per polarity",
        channels: 2,
        start: |window| Box::new(Eci::new(window, Counting::EveryEvent)),
        fill: |window, events, out| {
            fill_eci(window, Counting::EveryEvent, events.iter().copied(), out);
        },
    },
    RepresentationSpec {
        name: "eci-s",
        summary: "how often a pixel fired",
        channels: 1,
        start: |window| Box::new(EciS::new(window, Counting::EveryEvent)),
        fill: |window, events, out| {
            fill_eci_s(window, Counting::EveryEvent, events.iter().copied(), out);
        },
    },
    RepresentationSpec {
        name: "eci-parity",
        summary: "eci as the published program computes it: 0.01 per millisecond that fired",
        channels: 2,
        start: |window| Box::new(Eci::new(window, Counting::OncePerFrame)),
        fill: |window, events, out| {
            fill_eci(window, Counting::OncePerFrame, events.iter().copied(), out);
        },
    },
    RepresentationSpec {
        name: "eci-s-parity",
        summary: "eci-s as the published program computes it: two equal channels",
        channels: 2,
        start: |window| Box::new(EciS::new(window, Counting::OncePerFrame)),
        fill: |window, events, out| {
            fill_eci_s(window, Counting::OncePerFrame, events.iter().copied(), out);
        },
    },
];

/// The representation called `name`.
///
/// # Errors
/// If there is none; the message lists those there are.
pub fn representation_called(name: &str) -> Result<&'static RepresentationSpec, ReprError> {
    let found = REPRESENTATIONS.iter().find(|spec| spec.name == name);
    found.ok_or_else(|| ReprError::UnknownRepresentation { name: name.to_owned() })
}

#[cfg(test)]
mod tests;
