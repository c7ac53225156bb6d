//! What may be missing: the effects of the catalogue that are properties of a camera, and the
//! values they are tried at.

use evpose_sensor::{
    EffectConfig, ParamSpec, Prior, STAGES, SensorConfig, Settings, StageSpec, Strength,
};

/// What is typical of cameras is where the search begins; it goes on beyond, by this factor.
const BEYOND: f64 = 8.0;
/// The same for readouts, which small sensors share among fewer pixels.
const BEYOND_OF_READOUTS: f64 = 400.0;
/// Values of the strength that an effect is first tried at.
const STRENGTHS: usize = 14;

/// An effect that a recording may show and the model may lack.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Its entry in the registry.
    pub spec: &'static StageSpec,
}

/// One way in which a candidate is looked for: a choice of words, with numbers to fit.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The effect with the values to begin with.
    pub effect: EffectConfig,
    /// The numbers to fit; the first is the strength.
    pub params: Vec<&'static ParamSpec>,
}

impl Candidate {
    /// Effects that `model` does not hold yet, without those of `left_out`.
    ///
    /// A candidate has a strength that is a property of cameras, which leaves out conventions of
    /// simulators and how frames of a scene came about, and is no other detector or photoreceptor in
    /// the place of that of the model.
    pub fn beside(model: &SensorConfig, left_out: &[String]) -> Vec<Self> {
        let is_open = |spec: &&StageSpec| {
            model.effect(spec.name).is_none() && !left_out.iter().any(|name| name == spec.name)
        };
        let candidates = STAGES.iter().copied().filter(is_open).map(|spec| Self { spec });
        candidates.filter(|candidate| candidate.is_nameable()).collect()
    }

    fn is_nameable(self) -> bool {
        let has_place = match place(self.spec) {
            None => true,
            Some(place) => place == READOUT,
        };
        self.strength().is_some()
            && !is_parameter(self.name())
            && !is_of_scene(self.name())
            && has_place
    }

    /// The name in the catalogue.
    pub fn name(self) -> &'static str {
        self.spec.name
    }

    /// The first number that makes it stronger.
    fn strength(self) -> Option<&'static ParamSpec> {
        let names = match self.spec.signature.strength {
            Strength::Rising(names) | Strength::RisingAlone(names) | Strength::Falling(names) => {
                names
            }
            Strength::Unchanging | Strength::FromFiles => return None,
        };
        let spec = self.spec;
        let named = names.first().and_then(|name| spec.params.iter().find(|p| p.name == *name))?;
        matches!(named.prior, Prior::Typical(..)).then_some(named)
    }

    /// All ways to look for it, form by form: every word of every choice that changes the physics,
    /// and effects with two strengths by each of them. The first of a form is the plainest.
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
            let is_meant = |words: &Vec<(&str, &str)>| {
                // Rows that take time are what a bus serves row by row.
                head.name != "row_ns" || words.contains(&("order", "rows"))
            };
            for words in words(self.spec).into_iter().filter(is_meant) {
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

/// The place of readouts.
const READOUT: &str = "readout";

/// The place that an effect takes, of which a sensor has one.
fn place(spec: &'static StageSpec) -> Option<&'static str> {
    let settings = Settings::resolve(spec, &spec.typical()).ok()?;
    (spec.build)(&settings).ok()?.place()
}

/// What the model has anyway: numbers of these are refitted before any effect is looked for.
pub fn is_parameter(effect: &str) -> bool {
    matches!(effect, "uniform_noise" | "level_crossing" | "logarithmic" | "clock_offset_drift")
}

/// How frames of a scene came about, rather than what a camera does.
fn is_of_scene(effect: &str) -> bool {
    effect == "exposure_blur"
}

/// Effects that a second number makes strong on its own. The first is then as strong as is typical,
/// so that it shows which way to turn it.
const SECOND_STRENGTHS: &[(&str, &str)] = &[("arbiter", "row_ns")];

/// Effects that happen between the frames of a scene, the parts that steps are divided in while they
/// are looked for, and those that the best is fitted with.
const FAST: &[(&str, f64, f64)] = &[("photoreceptor_noise", 2.0, 8.0), ("lamp_flicker", 2.0, 4.0)];

/// Choices whose words are different physics rather than conventions of simulators.
const PHYSICAL_CHOICES: &[(&str, &str, &[&str])] = &[
    ("refractory", "mode", &["hold", "defer"]),
    ("scanned_readout", "waiting", &["reset", "latched", "kept"]),
    ("arbiter", "order", &["arrival", "rows"]),
    ("arbiter", "waiting", &["reset", "free"]),
    ("lamp_flicker", "memory", &["now", "trough"]),
    ("leak_on", "phase", &["random", "aligned"]),
    ("photoreceptor_lowpass", "signal", &["small", "large"]),
];

/// All combinations of words.
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
    /// The same without what the effect can do without, a spread over pixels for example: without
    /// any of it, and with one part of it each.
    fn plainer(&self) -> Vec<Self> {
        let (head, rest) = (self.params[0], &self.params[1..]);
        let spare: Vec<&'static ParamSpec> =
            rest.iter().copied().filter(|param| param.neutral.is_some()).collect();
        let with_only = |kept: Option<&'static ParamSpec>| {
            let is_dropped = |name: &str| {
                spare.iter().any(|param| param.name == name)
                    && kept.is_none_or(|kept| kept.name != name)
            };
            let mut effect = self.effect.clone();
            effect.params.retain(|key, _| !is_dropped(key));
            let rest = rest.iter().copied().filter(|param| !is_dropped(param.name));
            Self { effect, params: std::iter::once(head).chain(rest).collect() }
        };
        match spare.len() {
            0 => Vec::new(),
            1 => vec![with_only(None)],
            _ => std::iter::once(None)
                .chain(spare.iter().copied().map(Some))
                .map(with_only)
                .collect(),
        }
    }

    /// Whether both have the same words.
    pub fn is_form_of(&self, other: &Self) -> bool {
        PHYSICAL_CHOICES
            .iter()
            .filter(|(effect, ..)| *effect == self.effect.name)
            .all(|(_, key, _)| self.effect.params.get(*key) == other.effect.params.get(*key))
    }

    /// The strengths to begin with.
    pub fn strengths(&self) -> Vec<f64> {
        let head = self.params[0];
        let limits = limits(head);
        (0..STRENGTHS)
            .map(|i| head.between(limits, i as f64 / (STRENGTHS - 1) as f64))
            .filter(|value| Some(*value) != head.neutral)
            .collect()
    }

    /// The strengths to begin with, and whether each is stronger than the one before.
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
        // Linear ones have a sign.
        (strengths, head.scale == evpose_sensor::Scale::Log)
    }

    /// The same with one number set.
    #[must_use]
    pub fn with(&self, param: &ParamSpec, value: f64) -> Self {
        let effect = self.effect.clone().with(param.name, value);
        Self { effect, params: self.params.clone() }
    }

    /// The value of a number of the effect.
    pub fn value(&self, param: &ParamSpec) -> Option<f64> {
        self.effect.number(param.name)
    }

    fn fast(&self) -> Option<&'static (&'static str, f64, f64)> {
        FAST.iter().find(|(name, ..)| *name == self.effect.name)
    }

    /// `model`, which has the effect, with steps short enough for it; none if they are.
    pub(crate) fn with_short_steps(&self, model: &SensorConfig) -> Option<SensorConfig> {
        let (.., parts) = self.fast()?;
        let mut config = model.clone();
        divide(&mut config, *parts);
        (config != *model).then_some(config)
    }

    /// `model` with this effect. A readout takes the place of the ideal one.
    pub fn beside(&self, model: &SensorConfig) -> SensorConfig {
        let mut config = model.clone();
        let is_readout = |name: &str| {
            STAGES.iter().any(|spec| spec.name == name && place(spec) == Some(READOUT))
        };
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

/// Divides steps in no fewer parts.
fn divide(config: &mut SensorConfig, parts: f64) {
    let name = "adaptive_steps";
    let known = config.effect(name).and_then(|effect| effect.number("max_parts"));
    config.effects.retain(|effect| effect.name != name);
    let parts = parts.max(known.unwrap_or(1.0));
    config.effects.push(EffectConfig::new(name).with("max_parts", parts));
}

/// Where a number is looked for: what is typical and beyond, inside what the stage takes.
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
