//! Properties of a stage for the search for missing effects, beside its parameters, its strength and
//! its domain.

use crate::{CommonParameter, RecordingMark};

/// Properties of a stage for the search for missing effects. [`SearchSpec::PLAIN`] is right for most:
/// an effect of the camera whose parameters are found by simulating it.
#[derive(Debug, Clone, Copy)]
pub struct SearchSpec {
    /// Role of the stage in a model.
    pub role: StageRole,
    /// Those of its parameters that every model has a value of, with their keys.
    pub common: &'static [(CommonParameter, &'static str)],
    /// The parameter of a stage of every model that is tried like an effect: it is refitted only
    /// where the search has found it.
    pub own: Option<&'static str>,
    /// Choices of the physics: key, and the words that cameras differ in. All combinations are
    /// tried. Choices that are not listed follow conventions of simulators and stay as they are.
    pub choices: &'static [(&'static str, &'static [&'static str])],
    /// The choices of most cameras, of those listed.
    pub usual: &'static [(&'static str, &'static str)],
    /// A parameter that makes the effect strong on its own.
    pub second_strength: Option<SecondStrength>,
    /// Parameters whose typical values are those of sensors of a million pixels: in a small one
    /// they serve fewer pixels and are searched far beyond.
    pub per_sensor: &'static [&'static str],
    /// Parameters that are searched over more than what is typical of cameras, with the range:
    /// programs that make recordings, and light that is known badly, have values that no camera
    /// has.
    pub reach: &'static [(&'static str, (f64, f64))],
    /// Substeps that it needs, if it is faster than the frames of a scene.
    pub substeps: Option<Substeps>,
    /// How it sets in as its strength grows.
    pub onset: Onset,
    /// Whether it builds up over seconds, so that a short part of a recording does not show it.
    pub is_slow: bool,
    /// Mark in a recording, from which parameters are read without a simulation.
    pub mark: Option<RecordingMark>,
    /// Parameters whose readings are rough, and which are therefore fitted as well.
    pub rough: &'static [&'static str],
    /// Other effects that a recording without a scene, or a short part of one, does not distinguish
    /// from it.
    pub resembles: &'static [&'static str],
    /// The common parameter that no recording distinguishes from it.
    pub same_as: Option<CommonParameter>,
    /// Why a scene that was estimated from such a source cannot test the effect.
    pub hidden_by: &'static [(SceneSource, &'static str)],
    /// Values at which it is a little noise, such as every camera has; empty for what is no noise.
    pub dither: &'static [(&'static str, f64)],
}

impl SearchSpec {
    /// An effect of the camera with nothing special about it.
    pub const PLAIN: Self = Self {
        role: StageRole::Camera,
        common: &[],
        own: None,
        choices: &[],
        usual: &[],
        second_strength: None,
        per_sensor: &[],
        reach: &[],
        substeps: None,
        onset: Onset::OfDomain,
        is_slow: false,
        mark: None,
        rough: &[],
        resembles: &[],
        same_as: None,
        hidden_by: &[],
        dither: &[],
    };

    /// Why a scene from `source` cannot test the effect; none if it can.
    pub fn hidden_by(&self, source: SceneSource) -> Option<&'static str> {
        self.hidden_by.iter().find(|(hides, _)| *hides == source).map(|(_, why)| *why)
    }
}

/// Role of a stage in a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageRole {
    /// The event camera.
    Camera,
    /// Part of every model: its parameters are refitted before effects are tried.
    EveryModel,
    /// How the frames of a scene were taken.
    Scene,
}

/// A second parameter that makes an effect strong on its own. The first then has its typical value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SecondStrength {
    /// Key of the parameter.
    pub param: &'static str,
    /// Choices without which the parameter has no meaning: keys and words.
    pub needs: &'static [(&'static str, &'static str)],
}

/// Parts into which the time between two frames is divided for a fast effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Substeps {
    /// While many effects are tried.
    pub screened: f64,
    /// In the final fit.
    pub fitted: f64,
}

/// How an effect sets in as its strength grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Onset {
    /// As others of its domain: readouts and clocks show only where they are nearly right, all else
    /// over a range of strengths.
    OfDomain,
    /// Evenly, although it is a readout or a clock.
    Even,
    /// Without any events below a strength and with many above: what is best on a short recording
    /// need not lead to the best fit.
    Sudden,
}

/// Source of an estimated scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneSource {
    /// The camera's own frames: coarse in time, through the same lens, with a response curve that
    /// may be another than the assumed one.
    Frames,
    /// Poses alone: light and texture are made up.
    Poses,
}
