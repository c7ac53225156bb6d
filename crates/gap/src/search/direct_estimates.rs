//! Direct estimates: parameters of effects that a recording shows without a simulation, where a fit
//! would not find them by gradient descent.

use evpose_sensor::{EffectConfig, NumberSpec, SensorConfig};

use super::decision::MAX_OF_COUNTED;
use super::recording_marks::{Estimate, Recording, all_estimates};
use crate::candidate::{Candidate, Trial, words};
use crate::parameters::ModelParameter;
use crate::recording_mark::RecordingMark;
use crate::search_spec::Searched;

/// Fraction of time stamps consistent with a readout above which the readout is proven.
const PROVEN: f64 = 0.9;

/// Lags of events behind a lamp, turns: near the threshold, pixels fire up to the turning point of
/// the light.
const LAG_TURNS: [f64; 6] = [0.0, 0.04, 0.08, 0.12, 0.16, 0.2];
/// Peak-to-peak amplitudes of a lamp, in thresholds. Event counts change most where the amplitude
/// hardly exceeds one threshold.
const AMPLITUDES: [f64; 9] = [0.85, 1.0, 1.04, 1.09, 1.14, 1.2, 1.27, 1.36, 1.5];

#[derive(Debug, Clone)]
pub(super) struct DirectEstimates {
    estimates: Vec<Estimate>,
}

impl DirectEstimates {
    pub(super) fn from_recording(recording: &Recording<'_>) -> Self {
        Self { estimates: all_estimates(recording) }
    }

    fn find(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.spec.name == name)
    }

    /// The effects that the time stamps prove and that `model` lacks, with the forms that they may
    /// have.
    pub(super) fn proven(
        &self,
        model: &SensorConfig,
        left_out: &[String],
    ) -> Vec<(&'static str, Vec<Trial>)> {
        let candidates = Candidate::missing_from(model, left_out);
        let is_proven = |estimate: &&Estimate| estimate.reading.consistent > PROVEN;
        let forms = |estimate: &Estimate| {
            let name = estimate.spec.name;
            let candidate = candidates.iter().find(|one| one.name() == name)?;
            // Only usual forms: time stamps prove the effect, not which of its forms it has.
            let plainest =
                candidate.trials().into_iter().filter_map(|form| form.into_iter().next());
            let usual = plainest.filter(Trial::is_usual);
            Some((name, usual.map(|trial| self.applied(name, &trial)).collect()))
        };
        // Readouts come before clocks: the lines of a readout also look like the grid of a clock.
        self.estimates.iter().rev().filter(is_proven).filter_map(forms).collect()
    }

    /// Whether an effect agrees with what can be counted: at most twice as many pixels are dead as
    /// silent.
    pub(super) fn allows(&self, effect: &EffectConfig) -> bool {
        let estimate = self.find(&effect.name);
        let counted = estimate.filter(|estimate| estimate.mark == RecordingMark::SilentPixels);
        counted.is_none_or(|estimate| {
            estimate.reading.params.iter().all(|(key, _)| {
                let (Some(counted), Some(value)) =
                    (estimate.reading.number(key), effect.number(key))
                else {
                    return true;
                };
                value <= MAX_OF_COUNTED * counted
            })
        })
    }

    /// The trial with its estimated parameters set. They are no longer fitted, except rough ones.
    pub(super) fn applied(&self, name: &str, trial: &Trial) -> Trial {
        let mut applied = trial.clone();
        let Some(Estimate { spec, reading, .. }) = self.find(name) else { return applied };
        let known = reading.params.iter().map(|(key, value)| ((*key).to_owned(), value.clone()));
        applied.effect.params.extend(known);
        // The strength stays free, so that there is something to fit.
        let strength = trial.params[0];
        let is_read = |p: &NumberSpec| reading.params.iter().any(|(key, _)| *key == p.name);
        applied.params.retain(|p| p.name == strength.name || !is_read(p));
        let is_rough =
            |p: &&NumberSpec| p.name != strength.name && spec.search().rough.contains(&p.name);
        applied.params.extend(spec.number_params().filter(is_rough));
        applied
    }

    /// Other interpretations of the estimate that a trial was made with; none for most effects.
    pub(super) fn interpretations(
        &self,
        name: &str,
        trial: &Trial,
        model: &SensorConfig,
    ) -> Vec<Trial> {
        let estimate = self.find(name).filter(|estimate| estimate.mark == RecordingMark::Lamp);
        let Some(turns) = estimate.and_then(|estimate| estimate.reading.number("phase_turns"))
        else {
            return Vec::new();
        };
        let threshold =
            ModelParameter::ThresholdOn.value(model).min(ModelParameter::ThresholdOff.value(model));
        let words = words(trial.spec);
        let mut all = Vec::new();
        for lag in LAG_TURNS {
            for amplitude in AMPLITUDES {
                for words in &words {
                    // Log light goes from ln(1 - depth) to ln(1 + depth).
                    let depth = (0.5 * amplitude * threshold).tanh();
                    let at = trial.with(trial.params[0], depth);
                    let effect = at.effect.with("phase_turns", (turns + lag).rem_euclid(1.0));
                    let chosen =
                        words.iter().fold(effect, |effect, (k, word)| effect.with(k, *word));
                    all.push(Trial { effect: chosen, ..at });
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, SensorSize};

    use super::*;
    use crate::Expected;
    use crate::probe::testing::on;

    #[test]
    fn no_more_pixels_are_dead_than_silent() {
        let size = SensorSize { width: 20, height: 30 };
        let events = |from: u16| {
            let all = (0..6_000_u16).filter(move |k| u32::from(*k) * 233 % 600 >= u32::from(from));
            let event = |k: u16| on(100 * i64::from(k), k % 600 % 20, k % 600 / 20);
            EventStream::from_events(size, all.map(event)).unwrap()
        };
        let expected = Expected::from_events(&events(0));
        let allows = |silent: u16, fraction: f64| {
            let events = &events(silent);
            let recording = Recording { events, expected: &expected, scene: None };
            DirectEstimates::from_recording(&recording)
                .allows(&EffectConfig::new("dead_pixels").with("fraction", fraction))
        };
        assert!(allows(60, 0.1) && allows(60, 0.15) && !allows(60, 0.3));
        assert!(!allows(0, 0.01));
    }

    #[test]
    fn a_lamp_may_lag_and_its_amplitude_just_exceed_the_threshold() {
        // ON events of a lamp of 100 Hz, for four of ten milliseconds, a sixth of a turn behind its
        // steepest rise on the whole.
        let pulse = |k: i32| (-4..=4).map(move |i| (1e4 * (f64::from(k) + 1.0 / 6.0), i));
        let events = (1..100)
            .flat_map(pulse)
            .map(|(t_us, i)| on((t_us + 500.0 * f64::from(i)) as i64, 3, 4));
        let size = SensorSize { width: 20, height: 30 };
        let recording = Recording {
            events: &EventStream::from_events(size, events).unwrap(),
            expected: &Expected::from_events(&EventStream::empty(size)),
            scene: None,
        };
        let estimates = DirectEstimates::from_recording(&recording);
        let mut model = SensorConfig::from_toml("").unwrap();
        ModelParameter::ThresholdOn.set(&mut model, 0.25);
        ModelParameter::ThresholdOff.set(&mut model, 0.3);
        let interpretations = |name: &str| {
            let candidates = Candidate::missing_from(&model, &[]);
            let candidate = candidates.into_iter().find(|one| one.name() == name).unwrap();
            estimates.interpretations(name, &candidate.trials()[0][0], &model)
        };
        let trials = interpretations("lamp_flicker");
        let is_near = |trial: &Trial| {
            let value = |name| trial.effect.number(name).unwrap();
            let turns = (value("phase_turns") + 0.5).rem_euclid(1.0) - 0.5;
            let amplitude = 2.0 * value("depth").atanh();
            turns.abs() < 0.025 && (amplitude / (1.1 * 0.25) - 1.0).abs() < 0.05
        };
        assert!(trials.iter().any(is_near), "none of {}", trials.len());
        assert!(interpretations("refractory").is_empty());
    }
}
