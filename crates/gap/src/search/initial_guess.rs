//! Initial guesses of the model's parameters, estimated from the recording: gradient descent does
//! not cross a threshold error of a third, or a clock offset of many milliseconds.

use evpose_core::EventStream;
use evpose_sensor::SensorConfig;

use crate::parameters::ModelParameter;
use crate::{GapError, Objective, View};

/// Bin length of the event rates whose cross-correlation gives the offset.
const BIN_US: i64 = 250;
/// Largest offset that is tried, in both directions.
const MAX_OFFSET_US: i64 = 40_000;
/// Secant steps for the thresholds, and the largest change of a step, as a logarithm.
const SECANT_STEPS: usize = 4;
const MAX_LOG_CHANGE: f64 = 0.9;
/// Difference of logarithms of counts that a descent of all parameters takes care of.
const AS_MANY: f64 = 0.02;
/// Exponents with which event counts fall with the threshold are limited to this range: one over
/// the threshold for large contrasts, much steeper where a contrast hardly reaches it.
const EXPONENTS: [f64; 2] = [-8.0, -0.4];

/// The model with estimated thresholds, with an estimated clock offset, and with both; if the
/// objective knows which pixels are at rest, also with their background rates.
///
/// # Errors
/// A model that cannot be shown the scene.
pub(super) fn initial_guesses(
    objective: &Objective<'_>,
    model: &SensorConfig,
) -> Result<Vec<SensorConfig>, GapError> {
    let simulated = objective.reference_scene.simulate(model, 1)?;
    let offset_us = offset_us(&objective.events, &simulated);
    let mut shifted = model.clone();
    let given_us = ModelParameter::ClockOffset.value(model);
    ModelParameter::ClockOffset.set(&mut shifted, given_us + offset_us);
    let scaled = with_thresholds(objective, model)?;
    let mut both = scaled.clone();
    ModelParameter::ClockOffset.set(&mut both, given_us + offset_us);
    let mut guesses = vec![scaled, shifted, both];
    if objective.begins_at_rest {
        // Where counts in motion are not compared, steps of one parameter at a time do not lead
        // from no background to a high rate.
        let with_rates =
            [model, &guesses[0]].map(|guess| with_rates_at_rest(objective, &simulated, guess));
        guesses.extend(with_rates);
    }
    Ok(guesses)
}

/// `model` with its background rates raised by the excess of measured over simulated events of
/// pixels at rest.
fn with_rates_at_rest(
    objective: &Objective<'_>,
    simulated: &EventStream,
    model: &SensorConfig,
) -> SensorConfig {
    let reference_scene = objective.reference_scene;
    let counts = |events: &EventStream| {
        let mut counts = [0.0; 2];
        let view = View::new(reference_scene, events, objective.window);
        for event in view.events().iter().filter(|event| event.cell.is_quiet()) {
            counts[usize::from(event.is_on)] += 1.0;
        }
        counts
    };
    // Masked pixels have no events to count, so that the time at rest is that of the others.
    let (measured, simulated) = (counts(&objective.events), counts(simulated));
    let masked = reference_scene.scene.masked();
    let compared = masked.iter().filter(|masked| !**masked).count();
    let fraction = if masked.is_empty() {
        1.0
    } else {
        compared as f64 / reference_scene.scene.size().pixels() as f64
    };
    let at_rest_s = fraction * reference_scene.classes.quiet_pixel_s().iter().sum::<f64>();
    let mut model = model.clone();
    for (i, parameter) in
        [ModelParameter::NoiseOff, ModelParameter::NoiseOn].into_iter().enumerate()
    {
        if at_rest_s > 0.0 {
            let more_hz = (measured[i] - simulated[i]) / at_rest_s;
            let rate_hz = parameter.value(&model) + more_hz;
            // A model cannot have fewer noise events than none.
            parameter.set(&mut model, rate_hz.max(0.0));
        }
    }
    model
}

/// `model` with thresholds that give as many events of each polarity as were measured, by the
/// secant method on logarithms of threshold and count.
pub(super) fn with_thresholds(
    objective: &Objective<'_>,
    model: &SensorConfig,
) -> Result<SensorConfig, GapError> {
    let mut scaled = model.clone();
    // One more event, so that no count is without a logarithm.
    let measured = objective.layout.events_in_motion(&objective.measured).map(|n| (n + 1.0).ln());
    let parameters = [ModelParameter::ThresholdOff, ModelParameter::ThresholdOn];
    // Counts are inverse to the threshold where contrasts are large: the first step of the secant.
    let mut exponents = [-1.0; 2];
    let mut previous: Option<[[f64; 2]; 2]> = None;
    for _ in 0..SECANT_STEPS {
        let run = objective.run(&scaled, 0)?;
        let counts = objective.layout.events_in_motion(&run).map(|n| (n + 1.0).ln());
        // Near enough: the fit does the rest.
        if measured.iter().zip(counts).all(|(a, b)| (a - b).abs() < AS_MANY) {
            break;
        }
        let mut current = [[0.0; 2]; 2];
        for (i, parameter) in parameters.into_iter().enumerate() {
            let value = parameter.value(&scaled);
            if value <= 0.0 {
                continue;
            }
            current[i] = [value.ln(), counts[i]];
            if let Some([value_before, count_before]) = previous.map(|previous| previous[i]) {
                let slope = (current[i][1] - count_before) / (current[i][0] - value_before);
                if slope.is_finite() {
                    exponents[i] = slope.clamp(EXPONENTS[0], EXPONENTS[1]);
                }
            }
            let change = (measured[i] - counts[i]) / exponents[i];
            // A slope from two nearly equal counts would send the threshold out of its range.
            let change = change.clamp(-MAX_LOG_CHANGE, MAX_LOG_CHANGE);
            parameter.set(&mut scaled, value * change.exp());
        }
        previous = Some(current);
    }
    Ok(scaled)
}

/// Delay of the rates of `measured` behind those of `simulated`, microseconds: the maximum of their
/// cross-correlation.
fn offset_us(measured: &EventStream, simulated: &EventStream) -> f64 {
    let last = |events: &EventStream| events.t().last().map_or(0, |t| t.0);
    let bins = (last(measured).max(last(simulated)) / BIN_US) as usize + 1;
    let rates = |events: &EventStream| -> Vec<f64> {
        // One rate per polarity, because edges of either sign differ in it.
        let mut rate = vec![0.0; 2 * bins];
        for event in events.iter().filter(|event| event.t.0 >= 0) {
            rate[(event.t.0 / BIN_US) as usize + bins * usize::from(event.polarity.is_on())] += 1.0;
        }
        // Only changes of the rate say anything of a shift.
        for half in rate.chunks_mut(bins) {
            let mean = half.iter().sum::<f64>() / bins as f64;
            half.iter_mut().for_each(|n| *n -= mean);
        }
        rate
    };
    let (a, b) = (rates(measured), rates(simulated));
    let correlation = |shift: i64| -> f64 {
        [0, bins]
            .iter()
            .map(|from| {
                (0..bins as i64)
                    .filter(|k| (0..bins as i64).contains(&(k - shift)))
                    .map(|k| a[from + k as usize] * b[from + (k - shift) as usize])
                    .sum::<f64>()
            })
            .sum()
    };
    let reach = MAX_OFFSET_US / BIN_US;
    let best =
        (-reach..=reach).max_by(|x, y| correlation(*x).total_cmp(&correlation(*y))).unwrap_or(0);
    // Vertex of the parabola through the maximum and its neighbours, for a fraction of a bin.
    let [left, top, right] = [best - 1, best, best + 1].map(correlation);
    let bend = left - 2.0 * top + right;
    let fine = if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 };
    (best as f64 + fine.clamp(-0.5, 0.5)) * BIN_US as f64
}
