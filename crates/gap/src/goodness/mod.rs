//! Goodness of fit of a name: whether the recording shows what the named effect does, and its
//! relatives do not.
//!
//! # Method
//! A search names what lowers the discrepancy most. An effect that is not in the catalogue, or is
//! beside another one, lowers it through its nearest relative. Each effect has signatures beside those
//! of the catalogue (`search_spec`): quantities that it moves and its relatives leave alone, or that
//! it must not move. A name passes if one of its signatures in the recording is beyond those of runs
//! of the best model without it, by Student's t, and at least half as far as in runs of the corrected
//! model; and if nothing that it must leave alone deviates from these runs by more than is its own.
//! A delay that is shorter than the period of a readout is none: pixels that wait for it show the
//! same.
//!
//! All names of a verdict are tested together, at a false discovery rate of 5 %: the p-value of a name
//! is the larger of those of its signature and of what it explains, since it needs both.

mod light;
mod pixels;
pub(crate) mod signature;
mod timing;
mod value;

use evpose_core::TimeWindow;
use evpose_core::stats::moments::mean_and_deviation;
use evpose_core::{EventStream, Micros};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig, Stage};
use rayon::prelude::*;

pub(crate) use pixels::MIN_HOT_HZ;
pub(crate) use signature::Signature;
use value::Value;

use crate::discovery_rate::discoveries;
use crate::parameters::ModelParameter;
use crate::search::student_upper_tail;
use crate::search_spec::{Searched, StrictLimit};
use crate::verdict::SignatureTest;
use crate::{GapError, Objective, StatisticBlock, View};

/// Runs of each model, with seeds of their own.
const RUNS: u64 = 6;
const FIRST_RUN: u64 = 1_000;
/// Least fraction of what a signature moves with the effect that the recording shows of it.
const MIN_SHARE: f64 = 0.5;
/// Errors that a signature must move by with the effect to be visible in a recording.
const MIN_VISIBLE: f64 = 2.0;
/// Errors by which something that an effect leaves alone may deviate.
const MAX_ERRORS: f64 = 3.0;
/// Multiple of the period of a readout below which a delay cannot be separated from it.
const MIN_PERIODS: f64 = 1.5;

/// A recording and runs of the corrected model, with which names are tested.
#[derive(Debug)]
pub(crate) struct NameTests<'a> {
    objective: &'a Objective<'a>,
    corrected: &'a SensorConfig,
    window: TimeWindow,
    measured: View<'a>,
    with: Vec<View<'a>>,
    /// Whether the light is known: an estimated one hides what depends on it.
    is_light_known: bool,
}

impl<'a> NameTests<'a> {
    /// Simulates the corrected model on the whole scene of `objective`.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn new(
        objective: &'a Objective<'a>,
        corrected: &'a SensorConfig,
    ) -> Result<Self, GapError> {
        let end = objective.reference_scene.scene.duration() + Micros(1);
        let window = TimeWindow { start: Micros(0), end };
        let entries = objective.layout.entries.iter();
        let mut of_light = entries.filter(|entry| entry.block == StatisticBlock::Crossing);
        let mut tests = Self {
            objective,
            corrected,
            window,
            measured: View::new(objective.reference_scene, &objective.events, window),
            with: Vec::new(),
            is_light_known: of_light.any(|entry| entry.is_compared()),
        };
        tests.with = tests.views(corrected)?;
        Ok(tests)
    }

    fn views(&self, model: &SensorConfig) -> Result<Vec<View<'a>>, GapError> {
        let events = (FIRST_RUN..FIRST_RUN + RUNS)
            .into_par_iter()
            .map(|run| self.objective.events_of_run(model, run))
            .collect::<Result<Vec<Option<EventStream>>, GapError>>()?;
        let known = self.objective.reference_scene;
        let view = |events: EventStream| View::new(known, &events, self.window);
        // A model with far too many events is like no recording, and has no signature.
        Ok(events.into_par_iter().flatten().map(view).collect())
    }

    /// Tests an effect of the corrected model; `without` is the best model without it. None of an
    /// effect without signatures, or whose signatures need light that is not known.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn test(
        &self,
        name: &str,
        without: &SensorConfig,
    ) -> Result<Option<SignatureTest>, GapError> {
        let (Some(effect), Some(spec)) = (self.corrected.effect(name), STAGES.find(name)) else {
            return Ok(None);
        };
        if let Some(test) = self.masked(effect) {
            return Ok(Some(test));
        }
        let search = spec.search();
        for lack in search.lacks.iter().filter(|lack| self.is_testable(lack.signature)) {
            if let Some(test) = self.violated(lack, effect) {
                return Ok(Some(test));
            }
        }
        let shows: Vec<&'static Signature> =
            search.shows.iter().copied().filter(|shown| self.is_testable(shown)).collect();
        if shows.is_empty() {
            return Ok(None);
        }
        let without = self.views(without)?;
        let tried = shows.iter().filter_map(|signature| self.shown(signature, effect, &without));
        let best = tried.min_by(|a, b| a.p.total_cmp(&b.p));
        Ok(best.map(|best| SignatureTest {
            // One of several signatures is enough: each is one chance.
            p: (best.p * shows.len() as f64).min(1.0),
            ..best
        }))
    }

    /// Tests a parameter of the model that was changed; none without a test.
    pub(crate) fn test_parameter(&self, parameter: ModelParameter) -> Option<SignatureTest> {
        let (owner, _) = parameter.common().place();
        let missing_signs = owner.search().common_lacks.iter();
        let (_, lack) = missing_signs.copied().find(|(common, _)| *common == parameter.common())?;
        let effect = self.corrected.effect(owner.name)?;
        self.is_testable(lack.signature).then(|| self.violated(&lack, effect)).flatten()
    }

    fn is_testable(&self, signature: &Signature) -> bool {
        self.is_light_known || !signature.needs_light
    }

    /// A failed test if the effect is a time shorter than a visit of the readout.
    fn masked(&self, effect: &EffectConfig) -> Option<SignatureTest> {
        let is_readout = |effect: &&EffectConfig| {
            let spec = STAGES.find(&effect.name);
            spec.is_some_and(|spec| matches!(spec.typical_stage(), Ok(Stage::Readout(_))))
        };
        let spec = STAGES.find(&effect.name).filter(|_| !is_readout(&effect))?;
        let strength = spec.search().hides_in_readout?;
        let time_us = effect.number(strength)?.abs();
        let readouts = self.corrected.effects.iter().filter(is_readout);
        let period_us =
            readouts.filter_map(|readout| readout.number("period_us")).reduce(f64::max)?;
        (time_us < MIN_PERIODS * period_us).then(|| SignatureTest {
            passes: false,
            p: 1.0,
            must: format!(
                "be longer than the {} us in which the readout visits every pixel: waiting for it \
                 does the same",
                short(period_us)
            ),
            shows: format!("it is {} us", short(time_us)),
            recording: "the same scene with the fastest readout that the camera has".to_owned(),
        })
    }

    /// A failed test if something that an effect leaves alone deviates from runs of the corrected
    /// model by more than is the effect's own.
    fn violated(&self, lack: &StrictLimit, effect: &EffectConfig) -> Option<SignatureTest> {
        let signature = lack.signature;
        let measured = (signature.measure)(&self.measured, effect)?;
        let with = of_runs(signature, effect, &self.with)?;
        let threshold = [ModelParameter::ThresholdOn, ModelParameter::ThresholdOff]
            .map(|threshold| threshold.value(self.corrected));
        let limit = (lack.limit)(effect, threshold[0].min(threshold[1]));
        let excess = measured.value - with.value;
        let excess = if lack.is_two_sided { excess.abs() } else { excess };
        let error = measured.error.max(with.error);
        (excess > limit && excess > MAX_ERRORS * error).then(|| SignatureTest {
            passes: false,
            p: 1.0,
            must: lack.must.to_owned(),
            shows: format!(
                "{}: {} measured, {} with it",
                signature.quantity,
                quantity(measured.value, signature),
                quantity(with.value, signature)
            ),
            recording: signature.recording.to_owned(),
        })
    }

    /// Whether the recording shows a signature of an effect. None where the corrected model would hardly show it
    /// itself on this scene: no name is refused by a test that nothing could pass.
    fn shown(
        &self,
        signature: &'static Signature,
        effect: &EffectConfig,
        without: &[View<'_>],
    ) -> Option<SignatureTest> {
        let failed = |shows: String| SignatureTest {
            passes: false,
            p: 1.0,
            must: signature.must.to_owned(),
            shows,
            recording: signature.recording.to_owned(),
        };
        if self.with.is_empty() {
            return Some(failed("with it there are far more events than were recorded".to_owned()));
        }
        let measured = (signature.measure)(&self.measured, effect)?;
        let runs = [&self.with[..], without].map(|runs| of_runs(signature, effect, runs));
        let [Some(with), Some(without)] = runs else { return None };
        let shows = format!(
            "{}: {} measured, {} with it, {} without",
            signature.quantity,
            quantity(measured.value, signature),
            quantity(with.value, signature),
            quantity(without.value, signature)
        );
        // If the effect were not there, the recording would scatter as runs without it do.
        let error = without.error;
        let moved = with.value - without.value;
        let found = measured.value - without.value;
        if moved.abs() < MIN_VISIBLE * error {
            return None;
        }
        if found / moved < MIN_SHARE {
            return Some(failed(shows));
        }
        let z = found.abs() / error / (1.0 + 1.0 / RUNS as f64).sqrt();
        let p = student_upper_tail(z, RUNS as usize - 1);
        Some(SignatureTest { passes: true, p, ..failed(shows) })
    }
}

/// Tests the name of one effect of a corrected model, `without` being the best model without it. None
/// of an effect without a test.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn test_name(
    objective: &Objective<'_>,
    corrected: &SensorConfig,
    without: &SensorConfig,
    name: &str,
) -> Result<Option<SignatureTest>, GapError> {
    NameTests::new(objective, corrected)?.test(name, without)
}

/// Mean of a signature over runs, with the deviation of one, or its error by sampling.
fn of_runs(signature: &Signature, effect: &EffectConfig, runs: &[View<'_>]) -> Option<Value> {
    let values: Vec<Value> =
        runs.par_iter().filter_map(|view| (signature.measure)(view, effect)).collect();
    if values.is_empty() || values.len() < runs.len() {
        return None;
    }
    let plain: Vec<f64> = values.iter().map(|value| value.value).collect();
    let (mean, deviation) = mean_and_deviation(&plain);
    // A model without noise has no deviation, but its sample is as small as the recording's.
    let sampling = values.iter().map(|value| value.error).fold(0.0, f64::max);
    Some(Value { value: mean, error: deviation.max(sampling) })
}

/// Marks names as failed whose evidence is not significant among all names of a verdict. `tests` has
/// the test of each, with the probability of what it explains.
pub(crate) fn control_false_names(tests: &mut [(&mut SignatureTest, f64)]) {
    let p: Vec<f64> = tests.iter().map(|(test, explained)| test.p.max(*explained)).collect();
    for ((test, _), is_discovery) in tests.iter_mut().zip(discoveries(&p)) {
        if test.passes && !is_discovery {
            test.passes = false;
            test.shows += "; that may be chance among as many names";
        }
    }
}

fn quantity(value: f64, signature: &Signature) -> String {
    format!("{} {}", short(value), signature.unit).trim_end().to_owned()
}

/// A number with three digits.
fn short(value: f64) -> String {
    let size = value.abs();
    match () {
        () if size == 0.0 => "0".to_owned(),
        () if size >= 99.5 => format!("{value:.0}"),
        () if size >= 9.95 => format!("{value:.1}"),
        () if size >= 0.995 => format!("{value:.2}"),
        () if size >= 0.001 => format!("{value:.3}"),
        () => format!("{value:.1e}"),
    }
}
