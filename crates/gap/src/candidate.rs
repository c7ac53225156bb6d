//! Candidates: the effects of the catalogue that are properties of a camera, their variants, and
//! the parameter values that they are tried at.

use evpose_sensor::{
    EffectConfig, ParamSpec, Prior, STAGES, SensorConfig, Settings, StageSpec, Strength,
};

/// Factor by which the search goes beyond the typical range of a parameter on either side.
const BEYOND: f64 = 8.0;
/// The same for rates of readouts, which in a small sensor serve fewer pixels.
const BEYOND_OF_READOUTS: f64 = 400.0;
/// Strengths of the screening grid of an effect.
const STRENGTHS: usize = 14;

/// An effect that a model may lack.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Entry in the registry.
    pub spec: &'static StageSpec,
}

/// A variant of a candidate: its choices (keyword parameters), and the numeric parameters to fit.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The effect with its starting values.
    pub effect: EffectConfig,
    /// The parameters to fit; the first is the strength.
    pub params: Vec<&'static ParamSpec>,
}

impl Candidate {
    /// The effects of the catalogue that `model` lacks, without those of `left_out`.
    ///
    /// A candidate has a strength that is a property of cameras. That excludes conventions of
    /// simulators, the exposure of a scene's frames, and other detectors or photoreceptors in the
    /// place of the model's.
    pub fn missing_from(model: &SensorConfig, left_out: &[String]) -> Vec<Self> {
        let is_missing = |spec: &&StageSpec| {
            model.effect(spec.name).is_none() && !left_out.iter().any(|name| name == spec.name)
        };
        let candidates = STAGES.iter().copied().filter(is_missing).map(|spec| Self { spec });
        candidates.filter(|candidate| candidate.is_identifiable()).collect()
    }

    fn is_identifiable(self) -> bool {
        let has_slot = match slot(self.spec) {
            None => true,
            Some(slot) => slot == READOUT,
        };
        self.strength().is_some()
            && !is_parameter(self.name())
            && !is_of_scene(self.name())
            && has_slot
    }

    /// Name in the catalogue.
    pub fn name(self) -> &'static str {
        self.spec.name
    }

    /// The first parameter that makes the effect stronger.
    fn strength(self) -> Option<&'static ParamSpec> {
        let names = match self.spec.signature.strength {
            Strength::Rising(names) | Strength::RisingAlone(names) | Strength::Falling(names) => {
                names
            }
            Strength::Unchanging | Strength::FromFiles => return None,
        };
        let spec = self.spec;
        let first = names.first().and_then(|name| spec.params.iter().find(|p| p.name == *name))?;
        matches!(first.prior, Prior::Typical(..)).then_some(first)
    }

    /// All variants, grouped by form: every combination of choices that change the physics, and
    /// each strength of effects with two. Within a form, variants differ in their optional
    /// parameters; the first has the fewest.
    pub fn trials(self) -> Vec<Vec<Trial>> {
        let Some(strength) = self.strength() else { return Vec::new() };
        let is_alone = matches!(self.spec.signature.strength, Strength::RisingAlone(_));
        let typical = if is_alone { EffectConfig::new(self.name()) } else { self.spec.typical() };
        let mut heads = vec![strength];
        let second = SECOND_STRENGTHS.iter().find(|(effect, _)| *effect == self.name());
        heads.extend(
            self.spec.params.iter().filter(|p| second.is_some_and(|(_, key)| p.name == *key)),
        );
        if is_alone {
            let others = self.spec.params.iter().filter(|p| p.name != strength.name);
            heads.extend(others.filter(|p| matches!(p.prior, Prior::Typical(..))));
        }
        let mut trials = Vec::new();
        for head in heads {
            let rest = self.spec.params.iter().filter(|p| {
                !is_alone && p.name != head.name && matches!(p.prior, Prior::Typical(..))
            });
            let params: Vec<_> = std::iter::once(head).chain(rest).collect();
            let is_consistent = |words: &Vec<(&str, &str)>| {
                // A time per row makes sense only if the bus serves row by row.
                head.name != "row_ns" || words.contains(&("order", "rows"))
            };
            for words in words(self.spec).into_iter().filter(is_consistent) {
                let mut effect = typical.clone();
                if head.name != strength.name
                    && let (Prior::Typical(low, high), Strength::Falling(_)) =
                        (strength.prior, self.spec.signature.strength)
                {
                    effect = effect.with(strength.name, low.min(high));
                }
                for (key, word) in words {
                    effect = effect.with(key, word);
                }
                let trial = Trial { effect, params: params.clone() };
                let mut form = trial.plainer();
                form.push(trial);
                trials.push(form);
            }
        }
        trials
    }
}

/// Exclusive slot of readouts in a sensor.
const READOUT: &str = "readout";

/// The exclusive slot that an effect occupies, if it has one.
fn slot(spec: &'static StageSpec) -> Option<&'static str> {
    let settings = Settings::resolve(spec, &spec.typical()).ok()?;
    (spec.build)(&settings).ok()?.place()
}

/// Whether an effect belongs to every model: its parameters are refitted before effects are tried.
pub fn is_parameter(effect: &str) -> bool {
    matches!(effect, "uniform_noise" | "level_crossing" | "logarithmic" | "clock_offset_drift")
}

/// Whether an effect describes how frames of a scene were taken, rather than the event camera.
fn is_of_scene(effect: &str) -> bool {
    effect == "exposure_blur"
}

/// Effects with a second parameter that makes them strong on its own. The first one then has its
/// typical value, so that its derivative is not zero.
const SECOND_STRENGTHS: &[(&str, &str)] = &[("arbiter", "row_ns")];

/// Effects faster than the frames of a scene: name, substeps per frame while they are screened, and
/// substeps of the final fit.
const FAST: &[(&str, f64, f64)] = &[("photoreceptor_noise", 2.0, 8.0), ("lamp_flicker", 2.0, 4.0)];

/// Choices that change the physics rather than follow conventions of simulators: effect, key,
/// words.
const PHYSICAL_CHOICES: &[(&str, &str, &[&str])] = &[
    ("refractory", "mode", &["hold", "defer"]),
    ("scanned_readout", "waiting", &["reset", "latched", "kept"]),
    ("arbiter", "order", &["arrival", "rows"]),
    ("arbiter", "waiting", &["reset", "free"]),
    ("lamp_flicker", "memory", &["now", "trough"]),
    ("leak_on", "phase", &["random", "aligned"]),
    ("photoreceptor_lowpass", "signal", &["small", "large"]),
];

/// All combinations of the physical choices of an effect.
fn words(spec: &StageSpec) -> Vec<Vec<(&'static str, &'static str)>> {
    let choices = PHYSICAL_CHOICES.iter().filter(|(effect, ..)| *effect == spec.name);
    choices.fold(vec![Vec::new()], |all, (_, key, words)| {
        let with = |word: &&'static str| {
            let word = *word;
            all.iter().map(move |chosen: &Vec<_>| {
                let mut chosen = chosen.clone();
                chosen.push((*key, word));
                chosen
            })
        };
        words.iter().flat_map(with).collect()
    })
}

impl Trial {
    /// Variants with fewer optional parameters, a spread over pixels for example: with none of
    /// them, and with each of them alone.
    fn plainer(&self) -> Vec<Self> {
        let (head, rest) = (self.params[0], &self.params[1..]);
        let optional: Vec<&'static ParamSpec> =
            rest.iter().copied().filter(|param| param.neutral.is_some()).collect();
        let with_only = |kept: Option<&'static ParamSpec>| {
            let is_dropped = |name: &str| {
                optional.iter().any(|param| param.name == name)
                    && kept.is_none_or(|kept| kept.name != name)
            };
            let mut effect = self.effect.clone();
            effect.params.retain(|key, _| !is_dropped(key));
            let rest = rest.iter().copied().filter(|param| !is_dropped(param.name));
            Self { effect, params: std::iter::once(head).chain(rest).collect() }
        };
        match optional.len() {
            0 => Vec::new(),
            1 => vec![with_only(None)],
            _ => std::iter::once(None)
                .chain(optional.iter().copied().map(Some))
                .map(with_only)
                .collect(),
        }
    }

    /// Whether both have the same choices.
    pub fn is_form_of(&self, other: &Self) -> bool {
        PHYSICAL_CHOICES
            .iter()
            .filter(|(effect, ..)| *effect == self.effect.name)
            .all(|(_, key, _)| self.effect.params.get(*key) == other.effect.params.get(*key))
    }

    /// Strengths of the screening grid.
    pub fn strengths(&self) -> Vec<f64> {
        let head = self.params[0];
        let limits = limits(head);
        (0..STRENGTHS)
            .map(|i| head.between(limits, i as f64 / (STRENGTHS - 1) as f64))
            .filter(|value| Some(*value) != head.neutral)
            .collect()
    }

    /// Strengths of the screening grid, and whether each is stronger than the one before.
    pub(crate) fn rising(&self) -> (Vec<f64>, bool) {
        let head = self.params[0];
        let mut strengths = self.strengths();
        let spec = STAGES.iter().find(|spec| spec.name == self.effect.name);
        let strength = spec.map(|spec| &spec.signature.strength);
        if let Some(Strength::Falling(names)) = strength
            && names.contains(&head.name)
        {
            strengths.reverse();
        }
        // Values on a linear scale may have either sign: strength does not rise along them.
        (strengths, head.scale == evpose_sensor::Scale::Log)
    }

    /// The same variant with one parameter set.
    #[must_use]
    pub fn with(&self, param: &ParamSpec, value: f64) -> Self {
        let effect = self.effect.clone().with(param.name, value);
        Self { effect, params: self.params.clone() }
    }

    /// Value of a parameter of the effect.
    pub fn value(&self, param: &ParamSpec) -> Option<f64> {
        self.effect.number(param.name)
    }

    fn fast(&self) -> Option<&'static (&'static str, f64, f64)> {
        FAST.iter().find(|(name, ..)| *name == self.effect.name)
    }

    /// `model`, which has the effect, with time steps short enough for it; none if they are
    /// already.
    pub(crate) fn with_short_steps(&self, model: &SensorConfig) -> Option<SensorConfig> {
        let (.., parts) = self.fast()?;
        let mut config = model.clone();
        divide(&mut config, *parts);
        (config != *model).then_some(config)
    }

    /// `model` with this effect added. A readout replaces the ideal one.
    pub fn added_to(&self, model: &SensorConfig) -> SensorConfig {
        let mut config = model.clone();
        let is_readout =
            |name: &str| STAGES.iter().any(|spec| spec.name == name && slot(spec) == Some(READOUT));
        if is_readout(&self.effect.name) {
            config.effects.retain(|effect| !is_readout(&effect.name));
        }
        config.effects.push(self.effect.clone());
        if let Some((_, parts, _)) = self.fast() {
            divide(&mut config, *parts);
        }
        config
    }
}

/// Makes the model divide its time steps into at least this many parts.
fn divide(config: &mut SensorConfig, parts: f64) {
    let name = "adaptive_steps";
    let known = config.effect(name).and_then(|effect| effect.number("max_parts"));
    config.effects.retain(|effect| effect.name != name);
    let parts = parts.max(known.unwrap_or(1.0));
    config.effects.push(EffectConfig::new(name).with("max_parts", parts));
}

/// `model` without an effect.
pub(crate) fn without_effect(model: &SensorConfig, name: &str) -> SensorConfig {
    let mut model = model.clone();
    model.effects.retain(|effect| effect.name != name);
    model
}

/// Search range of a parameter: its typical range extended on both sides, within the range that the
/// stage accepts.
pub fn limits(param: &ParamSpec) -> (f64, f64) {
    let (low, high) = match param.prior {
        Prior::Typical(low, high) => (low, high),
        Prior::Fixed => param.range,
    };
    let (low, high) = match param.scale {
        evpose_sensor::Scale::Log => {
            let is_readout = matches!(param.name, "row_ns" | "rate_hz") && param.range.1 > 1e4;
            let beyond = if is_readout { BEYOND_OF_READOUTS } else { BEYOND };
            (low / beyond, high * beyond)
        }
        evpose_sensor::Scale::Linear => (low, high),
    };
    (low.max(param.range.0), high.min(param.range.1))
}
