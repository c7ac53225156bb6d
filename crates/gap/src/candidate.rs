//! Candidates: the effects of the catalogue that are properties of a camera, their variants, and
//! the parameter values that they are tried at.

use evpose_sensor::{
    EffectConfig, NumberSpec, STAGES, Scale, SensorConfig, Stage, StageSpec, Strength, Value,
};

use crate::search_spec::Searched;
use crate::search_spec::StageRole;

/// Factor by which the search goes beyond the typical range of a parameter on either side.
const BEYOND: f64 = 8.0;
/// The same for what serves all pixels, which in a small sensor are fewer.
const BEYOND_PER_SENSOR: f64 = 400.0;
/// Strengths of the screening grid of an effect.
const STRENGTHS: usize = 14;

/// An effect that a model may lack.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Entry in the catalogue.
    pub spec: &'static StageSpec,
}

/// A variant of a candidate: its choices (keyword parameters), and the numeric parameters to fit.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Entry of the effect in the catalogue.
    pub spec: &'static StageSpec,
    /// The effect with its starting values.
    pub effect: EffectConfig,
    /// The parameters to fit; the first is the strength.
    pub params: Vec<&'static NumberSpec>,
}

impl Candidate {
    /// The effects of the catalogue that `model` lacks, without those of `left_out`.
    pub fn missing_from(model: &SensorConfig, left_out: &[String]) -> Vec<Self> {
        let mut candidates = Self::all(left_out);
        candidates.retain(|candidate| model.effect(candidate.name()).is_none());
        candidates
    }

    /// The effects of the catalogue without those of `left_out`.
    ///
    /// A candidate has a strength that is a property of cameras. That excludes conventions of
    /// simulators, the exposure of a scene's frames, and other detectors or photoreceptors in the
    /// place of the model's.
    pub fn all(left_out: &[String]) -> Vec<Self> {
        let is_tried = |spec: &&StageSpec| !left_out.iter().any(|name| name == spec.name);
        let tried = STAGES.entries().iter().copied().filter(is_tried);
        let candidates = tried.map(|spec| Self { spec });
        candidates.filter(|candidate| candidate.is_identifiable()).collect()
    }

    fn is_identifiable(self) -> bool {
        // Another law takes the place of the model's: no strength leads from one to the other.
        let is_other_law =
            matches!(self.spec.typical_stage(), Ok(Stage::Photoreceptor(_) | Stage::Detector(_)));
        let is_part = match self.spec.search().role {
            StageRole::Camera => true,
            StageRole::EveryModel => self.spec.search().own.is_some(),
            StageRole::Scene => false,
        };
        self.strength().is_some() && is_part && !is_other_law
    }

    /// Name in the catalogue.
    pub fn name(self) -> &'static str {
        self.spec.name
    }

    /// The first parameter that makes the effect stronger.
    fn strength(self) -> Option<&'static NumberSpec> {
        let spec = self.spec;
        if let Some(own) = spec.search().own {
            return spec.number_params().find(|param| param.name == own);
        }
        let names = match self.spec.signature.strength {
            Strength::Rising(names) | Strength::RisingAlone(names) | Strength::Falling(names) => {
                names
            }
            Strength::Unchanging | Strength::FromFiles => return None,
        };
        let first =
            names.first().and_then(|name| spec.number_params().find(|p| p.name == *name))?;
        // A parameter without values typical of cameras is searched only where a range is given.
        let is_searched = spec.search().reach.iter().any(|(name, _)| *name == first.name);
        (is_searched || first.typical.is_some()).then_some(first)
    }

    /// All variants, grouped by form: every combination of choices that change the physics, and
    /// each strength of effects with two. Within a form, variants differ in their optional
    /// parameters; the first has the fewest.
    pub fn trials(self) -> Vec<Vec<Trial>> {
        let Some(strength) = self.strength() else { return Vec::new() };
        let is_own = self.spec.search().own.is_some();
        let is_alone = is_own || matches!(self.spec.signature.strength, Strength::RisingAlone(_));
        // Where parameters are forms of an effect, only the one that is tried may be set.
        let typical = if is_alone { EffectConfig::new(self.name()) } else { self.spec.typical() };
        let mut heads = vec![strength];
        let second = self.spec.search().second_strength;
        let is_second = |p: &NumberSpec| second.is_some_and(|second| p.name == second.param);
        heads.extend(self.spec.number_params().filter(|p| is_second(p)));
        if is_alone && !is_own {
            let others = self.spec.number_params().filter(|p| p.name != strength.name);
            heads.extend(others.filter(|p| p.typical.is_some()));
        }
        let mut trials = Vec::new();
        for head in heads {
            let rest = self
                .spec
                .number_params()
                .filter(|p| !is_alone && p.name != head.name && p.typical.is_some());
            let params: Vec<_> = std::iter::once(head).chain(rest).collect();
            let needs = second.filter(|_| is_second(head)).map_or(&[][..], |second| second.needs);
            let is_consistent =
                |words: &Vec<(&str, &str)>| needs.iter().all(|need| words.contains(need));
            for words in words(self.spec).into_iter().filter(is_consistent) {
                let mut effect = typical.clone();
                // Headed by its second strength, the effect has the first at its weak end, not at
                // its middle.
                if head.name != strength.name
                    && let (Some((low, high)), Strength::Falling(_)) =
                        (strength.typical, self.spec.signature.strength)
                {
                    effect = effect.with(strength.name, low.min(high));
                }
                for (key, word) in words {
                    effect = effect.with(key, word);
                }
                let trial = Trial { spec: self.spec, effect, params: params.clone() };
                let mut form = trial.with_fewer_parameters();
                form.push(trial);
                trials.push(form);
            }
        }
        trials
    }
}

/// All combinations of the physical choices of an effect.
pub(crate) fn words(spec: &StageSpec) -> Vec<Vec<(&'static str, &'static str)>> {
    spec.search().choices.iter().fold(vec![Vec::new()], |all, (key, words)| {
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
    fn with_fewer_parameters(&self) -> Vec<Self> {
        let (head, rest) = (self.params[0], &self.params[1..]);
        let optional: Vec<&'static NumberSpec> =
            rest.iter().copied().filter(|param| param.default.is_some()).collect();
        let with_only = |kept: Option<&'static NumberSpec>| {
            let is_dropped = |name: &str| {
                optional.iter().any(|param| param.name == name)
                    && kept.is_none_or(|kept| kept.name != name)
            };
            let mut effect = self.effect.clone();
            effect.params.retain(|key, _| !is_dropped(key));
            let rest = rest.iter().copied().filter(|param| !is_dropped(param.name));
            Self { effect, params: std::iter::once(head).chain(rest).collect(), ..*self }
        };
        match optional.len() {
            // With one optional parameter, "with each alone" is the trial itself.
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
        let is_same = |key: &str| self.effect.params.get(key) == other.effect.params.get(key);
        self.spec.search().choices.iter().all(|(key, _)| is_same(key))
    }

    /// Strengths of the screening grid.
    pub fn strengths(&self) -> Vec<f64> {
        let head = self.params[0];
        let limits = limits(self.spec, head);
        (0..STRENGTHS)
            .map(|i| i as f64 / (STRENGTHS - 1) as f64)
            .map(|fraction| match (head.scale, limits) {
                // Denser around zero: a quantity of two signs may be small.
                (Scale::Linear, (low, high)) if low < 0.0 && high > 0.0 => {
                    let signed = 2.0 * fraction - 1.0;
                    signed * signed.abs() * if signed < 0.0 { -low } else { high }
                }
                _ => head.between(limits, fraction),
            })
            .filter(|value| Some(*value) != head.default)
            .collect()
    }

    /// Strengths of the screening grid, and whether each is stronger than the one before.
    pub(crate) fn rising(&self) -> (Vec<f64>, bool) {
        let head = self.params[0];
        let mut strengths = self.strengths();
        if let Strength::Falling(names) = self.spec.signature.strength
            && names.contains(&head.name)
        {
            strengths.reverse();
        }
        // Values on a linear scale may have either sign: strength does not rise along them.
        (strengths, head.scale == Scale::Log)
    }

    /// The same variant with one parameter set.
    #[must_use]
    pub fn with(&self, param: &NumberSpec, value: f64) -> Self {
        let effect = self.effect.clone().with(param.name, value);
        Self { effect, params: self.params.clone(), ..*self }
    }

    /// Value of a parameter of the effect.
    pub fn value(&self, param: &NumberSpec) -> Option<f64> {
        self.effect.number(param.name)
    }

    /// Whether the effect is weaker than in any camera, with a value of its strength: beyond the weak
    /// end of what is typical, or of the range that its entry asks for. A parameter that every model
    /// has may be as weak as nothing.
    pub(crate) fn is_weaker_than_in_cameras(&self, value: f64) -> bool {
        let (spec, head) = (self.spec, self.params[0]);
        let Some((low, high)) = head.typical else { return false };
        let depends_on_size = spec.search().per_sensor.contains(&head.name);
        let is_common = spec.search().common.iter().any(|(_, key)| *key == head.name);
        // On a linear scale there is no weak end but zero.
        if head.scale != Scale::Log || depends_on_size || is_common {
            return false;
        }
        let reach = spec.search().reach.iter().find(|(name, _)| *name == head.name);
        let (low, high) = reach.map_or((low, high), |(_, range)| *range);
        match spec.signature.strength {
            Strength::Rising(names) | Strength::RisingAlone(names) => {
                names.contains(&head.name) && value < low
            }
            Strength::Falling(names) => names.contains(&head.name) && value > high,
            Strength::Unchanging | Strength::FromFiles => false,
        }
    }

    /// Whether the choices are those of most cameras.
    pub(crate) fn is_usual(&self) -> bool {
        let has = |key: &str, word: &str| self.effect.params.get(key) == Some(&Value::from(word));
        self.spec.search().usual.iter().all(|(key, word)| has(key, word))
    }

    /// `model`, which has the effect, with time steps short enough for it; none if they are
    /// already.
    pub(crate) fn with_short_steps(&self, model: &SensorConfig) -> Option<SensorConfig> {
        let mut config = model.clone();
        config.divide_steps(self.spec.search().substeps?.fitted);
        (config != *model).then_some(config)
    }

    /// `model` with this effect added. A readout replaces the ideal one.
    pub fn added_to(&self, model: &SensorConfig) -> SensorConfig {
        let mut config = model.clone();
        let is_readout =
            |spec: &'static StageSpec| matches!(spec.typical_stage(), Ok(Stage::Readout(_)));
        if is_readout(self.spec) {
            let is_other = |name: &str| STAGES.find(name).is_some_and(is_readout);
            config.effects.retain(|effect| !is_other(&effect.name));
        }
        let mut effect = self.effect.clone();
        if self.spec.search().own.is_some()
            && let Some(known) = config.effect(&effect.name)
        {
            // The parameters that every model has stay as they are.
            effect.params.extend(known.params.iter().filter_map(|(key, value)| {
                let is_new = self.params.iter().all(|param| param.name != *key);
                is_new.then(|| (key.clone(), value.clone()))
            }));
        }
        config.effects.retain(|known| known.name != effect.name);
        config.insert(effect);
        // Some effects are faster than the frames of a scene.
        if let Some(substeps) = self.spec.search().substeps {
            config.divide_steps(substeps.screened);
        }
        config
    }
}

/// `model` without an effect, or with it as in the model that was given.
pub(crate) fn without_effect(
    model: &SensorConfig,
    given: &SensorConfig,
    name: &str,
) -> SensorConfig {
    let mut model = model.clone();
    model.effects.retain(|effect| effect.name != name);
    // A stronger form of an effect that the model had already goes back to that.
    model.effects.extend(given.effect(name).cloned());
    model
}

/// Search range of a parameter of an effect: the one that its entry asks for, or its typical range
/// extended on both sides, within the range that the stage accepts.
pub fn limits(spec: &StageSpec, param: &NumberSpec) -> (f64, f64) {
    if let Some((_, range)) = spec.search().reach.iter().find(|(name, _)| *name == param.name) {
        return *range;
    }
    let (low, high) = param.typical.unwrap_or(param.range);
    let (low, high) = match param.scale {
        Scale::Log => {
            match spec.search().per_sensor.contains(&param.name) {
                // Fewer pixels need no more than the rate of many.
                true if param.unit == "Hz" => (low / BEYOND_PER_SENSOR, high),
                true => (low / BEYOND_PER_SENSOR, high * BEYOND_PER_SENSOR),
                false => (low / BEYOND, high * BEYOND),
            }
        }
        Scale::Linear => (low, high),
    };
    (low.max(param.range.0), high.min(param.range.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leak_of_less_than_a_camera_has_is_too_weak_and_a_mismatch_of_none_is_not() {
        let is_too_weak = |name: &str, value: f64| {
            let candidates = Candidate::all(&[]);
            let candidate = candidates.into_iter().find(|one| one.name() == name).unwrap();
            candidate.trials()[0][0].is_weaker_than_in_cameras(value)
        };
        assert!(is_too_weak("leak_on", 0.003) && !is_too_weak("leak_on", 0.05));
        assert!(is_too_weak("adaptive_highpass", 25.0) && !is_too_weak("adaptive_highpass", 0.5));
        assert!(!is_too_weak("threshold_mismatch", 1e-4) && !is_too_weak("arbiter", 1e9));
    }
}
