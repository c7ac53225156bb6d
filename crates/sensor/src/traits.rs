//! Properties of stages, from which the chain chooses the path of a step.

use evpose_core::SensorSize;

use crate::Recovery;

/// Properties of a stage that do not change while it runs. The default claims nothing: it is right
/// for any stage, and the path that follows from it is the slow one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Traits {
    /// The quantity that the stage acts on. The chain sets it, from the stage's kind and domain.
    pub acts_on: ActsOn,
    /// While the light of a pixel stays as it is, the stage does nothing new: it has no memory of
    /// its own, noise or time. A static pixel term is a fixed pattern and nothing else; a static
    /// readout serves every request when it is made.
    pub is_static: bool,
    /// The quantity that a change detector compares.
    pub compares: Compares,
    /// The memory starts at the voltage of darkness rather than at the first exposure.
    pub starts_cold: bool,
    /// The events of one answer are spread over the step, at as many even times as the busiest
    /// pixel has events.
    pub spreads: bool,
    /// The detector rounds as the published emulator does: refractory periods between those even
    /// times are measured in seconds of single precision, and where nothing acts on the voltage
    /// behind the photoreceptor, [memories and leaks](crate::PixelStep::is_single) are kept in it
    /// as well.
    pub rounds_as_published: bool,
    /// A term has [`PixelTerm::renew`](crate::PixelTerm::renew).
    pub renews: bool,
    /// A formula gives thresholds or refractory periods, which differ from event to event.
    pub varies: bool,
    /// A term has [`PixelTerm::redraw`](crate::PixelTerm::redraw), and changes thresholds by this
    /// much at most, ln. A pixel then has an event only where its voltage comes through the level
    /// of that exposure: a level that is behind it already is missed.
    pub redraws: Option<f32>,
    /// A term has [`PixelTerm::add_leak`](crate::PixelTerm::add_leak).
    pub adds_leak: bool,
    /// Recovery of a pixel after an event, on top of the level that was crossed.
    pub recovery: Recovery,
    /// The memory goes on stepping in a refractory period, so that events in it are lost.
    pub steps_while_refractory: bool,
    /// The signal behind a plane stage is linear in that in front of it and follows from it alone,
    /// without memory, noise or time.
    pub is_linear: bool,
    /// A clock must see events in order of time; they come in any order otherwise.
    pub needs_order: bool,
    /// The sensor that the stage is made for, if it fits one size only.
    pub made_for: Option<SensorSize>,
}

/// The signal that a stage acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ActsOn {
    /// Light of each pixel by itself, in front of the photoreceptor law.
    #[default]
    Light,
    /// Light of all pixels together.
    LightPlane,
    /// Light, which becomes log voltage: the photoreceptor law.
    Law,
    /// Log voltage of each pixel by itself.
    Voltage,
    /// Log voltage of all pixels together.
    VoltagePlane,
    /// Memory and events of each pixel: the change detector and the pixel terms.
    Pixels,
    /// Requests of all pixels: background, readout and clock.
    Requests,
}

impl ActsOn {
    /// Whether the signal is light rather than voltage.
    pub(crate) fn is_light(self) -> bool {
        matches!(self, Self::Light | Self::LightPlane)
    }
}

/// The quantity that a change detector compares with the memory of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Compares {
    /// Log voltage: the detector is asked for the next event until the step has no more.
    #[default]
    Voltage,
    /// Log voltage, with events exactly where it is a threshold away from the memory, so that the
    /// array need not ask. A pixel that waits for a slow readout is blind until it is served;
    /// behind other detectors the readout only delays events.
    Levels,
    /// Log voltage of frames: it is asked once a step, and answers for the end of it.
    Frames,
    /// Light, in code values of 0 to 255, with a random answer: every pixel is asked at every step.
    Light,
}
