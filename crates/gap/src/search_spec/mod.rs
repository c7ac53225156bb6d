//! Properties of an effect that the search for missing effects needs, beside its parameters, its
//! strength and its domain.

mod effects;
mod strict_limit;

use evpose_sensor::{STAGES, StageSpec};

use crate::common_parameter::CommonParameter;
use crate::recording_mark::RecordingMark;
use effects::EFFECTS;

pub(crate) use strict_limit::StrictLimit;

use crate::goodness::Signature;

/// Properties of an effect that the search needs. [`PLAIN`] is right for most: an effect of the
/// camera whose parameters are found by simulating it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchSpec {
    /// Name of the effect; empty for all that are not listed.
    pub(crate) effect: &'static str,
    pub(crate) role: StageRole,
    /// Those of its parameters that every model has a value of, with their keys.
    pub(crate) common: &'static [(CommonParameter, &'static str)],
    /// The parameter of a stage of every model that is tried like an effect: it is refitted only
    /// where the search has found it.
    pub(crate) own: Option<&'static str>,
    /// Choices of the physics: key, and the words that cameras differ in. All combinations are
    /// tried. Choices that are not listed follow conventions of simulators and stay as they are.
    pub(crate) choices: &'static [(&'static str, &'static [&'static str])],
    /// The choices of most cameras, of those listed.
    pub(crate) usual: &'static [(&'static str, &'static str)],
    /// A parameter that makes the effect strong on its own.
    pub(crate) second_strength: Option<SecondStrength>,
    /// Parameters whose typical values are those of sensors of a million pixels: in a small one
    /// they serve fewer pixels and are searched far beyond.
    pub(crate) per_sensor: &'static [&'static str],
    /// Parameters that are searched over more than what is typical of cameras, with the range:
    /// programs that make recordings, and light that is known badly, have values that no camera
    /// has.
    pub(crate) reach: &'static [(&'static str, (f64, f64))],
    /// Substeps that it needs, if it is faster than the frames of a scene.
    pub(crate) substeps: Option<Substeps>,
    /// How it sets in as its strength grows.
    pub(crate) onset: Onset,
    /// Whether it builds up over seconds, so that a short part of a recording does not show it.
    pub(crate) is_slow: bool,
    /// Mark in a recording, from which parameters are read without a simulation.
    pub(crate) mark: Option<RecordingMark>,
    /// Parameters whose readings are rough, and which are therefore fitted as well.
    pub(crate) rough: &'static [&'static str],
    /// Other effects that a recording without a scene, or a short part of one, does not distinguish
    /// from it.
    pub(crate) resembles: &'static [&'static str],
    /// The common parameter that no recording distinguishes from it.
    pub(crate) same_as: Option<CommonParameter>,
    /// Why a scene that was estimated from such a source cannot test the effect.
    pub(crate) hidden_by: &'static [(SceneSource, &'static str)],
    /// Signatures of which the recording must show one for the name to stand.
    pub(crate) shows: &'static [&'static Signature],
    /// Signatures that it leaves alone.
    pub(crate) lacks: &'static [StrictLimit],
    /// The same of the parameters that every model has.
    pub(crate) common_lacks: &'static [(CommonParameter, StrictLimit)],
    /// Its time that a readout hides, if that is shorter than a visit of every pixel.
    pub(crate) hides_in_readout: Option<&'static str>,
    /// Values at which it is a little noise, such as every camera has; empty for what is no noise.
    pub(crate) dither: &'static [(&'static str, f64)],
}

/// An effect of the camera with nothing special about it.
pub(crate) const PLAIN: SearchSpec = SearchSpec {
    effect: "",
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
    shows: &[],
    lacks: &[],
    common_lacks: &[],
    hides_in_readout: None,
    dither: &[],
};

impl SearchSpec {
    /// Why a scene from `source` cannot test the effect; none if it can.
    pub(crate) fn hidden_by(&self, source: SceneSource) -> Option<&'static str> {
        self.hidden_by.iter().find(|(hides, _)| *hides == source).map(|(_, why)| *why)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StageRole {
    Camera,
    /// Part of every model: its parameters are refitted before effects are tried.
    EveryModel,
    /// How the frames of a scene were taken.
    Scene,
}

/// A second parameter that makes an effect strong on its own. The first then has its typical value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SecondStrength {
    pub(crate) param: &'static str,
    /// Choices without which the parameter has no meaning: keys and words.
    pub(crate) needs: &'static [(&'static str, &'static str)],
}

/// Parts into which the time between two frames is divided for a fast effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Substeps {
    /// While many effects are tried.
    pub(crate) screened: f64,
    /// In the final fit.
    pub(crate) fitted: f64,
}

/// How an effect sets in as its strength grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Onset {
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

/// An effect with a part in the search.
pub(crate) trait Searched {
    fn search(&self) -> &'static SearchSpec;
}

impl Searched for StageSpec {
    fn search(&self) -> &'static SearchSpec {
        EFFECTS.iter().find(|search| search.effect == self.name).unwrap_or(&PLAIN)
    }
}

/// The effects that leave `mark` in a recording, in the order of the catalogue.
pub(crate) fn with_mark(mark: RecordingMark) -> impl Iterator<Item = &'static StageSpec> {
    STAGES.entries().iter().filter(move |spec| spec.search().mark == Some(mark)).copied()
}

impl CommonParameter {
    /// The stage of [`STAGES`] that owns the parameter, and its key there.
    pub(crate) fn place(self) -> (&'static StageSpec, &'static str) {
        let key = |spec: &StageSpec| {
            spec.search().common.iter().find(|(common, _)| *common == self).map(|(_, key)| *key)
        };
        let place = STAGES.iter().find_map(|spec| Some((*spec, key(spec)?)));
        place.expect("a test checks that a stage owns each of them")
    }
}

impl RecordingMark {
    /// The effect of [`STAGES`] that leaves the mark.
    pub(crate) fn effect(self) -> &'static StageSpec {
        let effect = with_mark(self).next();
        effect.expect("a test checks that an effect leaves each of them")
    }
}

#[cfg(test)]
mod tests {
    use evpose_sensor::Parameter;

    use super::*;

    /// An effect is one file and one line of the registry: the search takes it from there, and what
    /// this crate says besides is in names of its own parameters and choices.
    #[test]
    fn every_effect_is_searched_by_what_the_registry_says_of_it() {
        for (k, search) in EFFECTS.iter().enumerate() {
            assert!(STAGES.iter().any(|spec| spec.name == search.effect), "{}", search.effect);
            assert!(EFFECTS[..k].iter().all(|other| other.effect != search.effect));
        }
        for spec in &STAGES {
            let (name, search) = (spec.name, spec.search());
            let is_param = |key: &&str| spec.number_params().any(|param| param.name == *key);
            let second = search.second_strength;
            let keys = search.common.iter().map(|(_, key)| key);
            let keys = keys.chain(search.per_sensor).chain(search.rough).chain(&search.own);
            let keys = keys.chain(search.reach.iter().map(|(key, _)| key));
            let keys = keys.chain(&search.hides_in_readout);
            for key in keys.chain(second.iter().map(|second| &second.param)) {
                assert!(is_param(key), "{name}: {key}");
            }
            let words =
                search.choices.iter().flat_map(|(key, words)| words.iter().map(move |w| (key, w)));
            let settled = search.usual.iter().chain(second.iter().flat_map(|second| second.needs));
            for (key, word) in words.chain(settled.map(|(key, word)| (key, word))) {
                let choice = spec
                    .params
                    .iter()
                    .filter_map(Parameter::as_word)
                    .find(|choice| choice.name == *key);
                assert!(
                    choice.is_some_and(|choice| choice.allowed.contains(word)),
                    "{name}: {key}"
                );
            }
            for key in search.mark.map_or(&[][..], RecordingMark::parameters) {
                assert!(spec.keys().contains(key), "{name} is read off, but has no {key}");
            }
            for other in search.resembles {
                assert!(STAGES.iter().any(|spec| spec.name == *other), "{name}: {other}");
            }
            for (key, value) in search.dither {
                let param = spec.number_params().find(|param| param.name == *key);
                assert!(param.is_some_and(|param| param.allows(*value)), "{name}: {key}");
            }
        }
    }

    #[test]
    fn every_common_parameter_has_one_owner_and_every_mark_one_effect() {
        for common in CommonParameter::ALL {
            let owns =
                |spec: &&&StageSpec| spec.search().common.iter().any(|(own, _)| *own == common);
            assert_eq!(STAGES.iter().filter(owns).count(), 1, "{common:?}");
            let (owner, key) = common.place();
            assert!(owner.number_params().any(|param| param.name == key), "{common:?}");
        }
        for mark in RecordingMark::ALL {
            assert_eq!(with_mark(mark).count(), 1, "{mark:?}");
        }
    }
}
