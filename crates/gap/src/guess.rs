//! Numbers of the model read off the recording, for a fit to begin with: going downhill does not
//! lead across a threshold that is a third off, or an offset of many milliseconds.

use evpose_core::EventStream;
use evpose_sensor::SensorConfig;

use crate::parameters::Parameter;
use crate::{GapError, Lab, View};

/// Rates are compared in bins of this length.
const BIN_US: i64 = 250;
/// Offsets are looked for up to this, both ways.
const FURTHEST_US: i64 = 40_000;
/// Rounds in which thresholds are found, and how far each goes at most, as a logarithm.
const SECANTS: usize = 4;
const FURTHEST: f64 = 0.9;
/// Powers with which counts fall with the threshold.
const STEEPEST: f64 = -8.0;
const FLATTEST: f64 = -0.4;

/// The model with thresholds, with the clock, and with both set from the recording; where pixels
/// at rest are known, also with the background.
///
/// # Errors
/// A model that cannot be shown the scene.
pub(crate) fn starts(lab: &Lab<'_>, model: &SensorConfig) -> Result<Vec<SensorConfig>, GapError> {
    let simulated = lab.stage.simulate(model, 1)?;
    let offset_us = offset_us(&lab.events, &simulated);
    let mut late = model.clone();
    let was_us = Parameter::ClockOffset.value(model);
    Parameter::ClockOffset.set(&mut late, was_us + offset_us);
    let scaled = scaled(lab, model)?;
    let mut both = scaled.clone();
    Parameter::ClockOffset.set(&mut both, was_us + offset_us);
    let mut starts = vec![scaled, late, both];
    if lab.begins_at_rest {
        // Where counts in motion say nothing, one number at a time does not lead from no background
        // to what is far away.
        let given = [model, &starts[0]].map(|start| with_rates_at_rest(lab, &simulated, start));
        starts.extend(given);
    }
    Ok(starts)
}

/// `model` with as much more background as pixels at rest have more events than in `simulated`.
fn with_rates_at_rest(
    lab: &Lab<'_>,
    simulated: &EventStream,
    model: &SensorConfig,
) -> SensorConfig {
    let stage = lab.stage;
    let counts = |events: &EventStream| {
        let mut counts = [0.0; 2];
        let view = View::new(stage, events, lab.window);
        for sight in view.events().iter().filter(|sight| sight.cell.is_quiet()) {
            counts[usize::from(sight.is_on)] += 1.0;
        }
        counts
    };
    let (measured, simulated) = (counts(&lab.events), counts(simulated));
    let seen = stage.scene.blind().iter().filter(|blind| !**blind).count();
    let share = if stage.scene.blind().is_empty() {
        1.0
    } else {
        seen as f64 / stage.scene.size().pixels() as f64
    };
    let at_rest_s = share * stage.classes.quiet_pixel_s().iter().sum::<f64>();
    let mut model = model.clone();
    for (i, parameter) in [Parameter::NoiseOff, Parameter::NoiseOn].into_iter().enumerate() {
        if at_rest_s > 0.0 {
            let more_hz = (measured[i] - simulated[i]) / at_rest_s;
            let rate_hz = parameter.value(&model) + more_hz;
            parameter.set(&mut model, rate_hz.max(0.0));
        }
    }
    model
}

/// Thresholds so that there are as many events of each polarity, by secants: counts go with one over
/// the threshold where a change of light holds many, and fall much faster where it hardly holds one.
fn scaled(lab: &Lab<'_>, model: &SensorConfig) -> Result<SensorConfig, GapError> {
    let mut scaled = model.clone();
    let measured = lab.layout.events_in_motion(&lab.measured).map(|n| (n + 1.0).ln());
    let parameters = [Parameter::ThresholdOff, Parameter::ThresholdOn];
    let mut slopes = [-1.0; 2];
    let mut known: Option<[[f64; 2]; 2]> = None;
    for _ in 0..SECANTS {
        let run = lab.run(&scaled, 0)?;
        let counts = lab.layout.events_in_motion(&run).map(|n| (n + 1.0).ln());
        let mut here = [[0.0; 2]; 2];
        for (i, parameter) in parameters.into_iter().enumerate() {
            let value = parameter.value(&scaled);
            if value <= 0.0 {
                continue;
            }
            here[i] = [value.ln(), counts[i]];
            if let Some([value_before, count_before]) = known.map(|known| known[i]) {
                let slope = (here[i][1] - count_before) / (here[i][0] - value_before);
                if slope.is_finite() {
                    slopes[i] = slope.clamp(STEEPEST, FLATTEST);
                }
            }
            let change = (measured[i] - counts[i]) / slopes[i];
            parameter.set(&mut scaled, value * change.clamp(-FURTHEST, FURTHEST).exp());
        }
        known = Some(here);
    }
    Ok(scaled)
}

/// How much later the rates of `measured` are than those of `simulated`, microseconds.
fn offset_us(measured: &EventStream, simulated: &EventStream) -> f64 {
    let last = |events: &EventStream| events.t().last().map_or(0, |t| t.0);
    let bins = (last(measured).max(last(simulated)) / BIN_US) as usize + 1;
    let rates = |events: &EventStream| -> Vec<f64> {
        // The two polarities tell edges of both signs apart.
        let mut rate = vec![0.0; 2 * bins];
        for event in events.iter().filter(|event| event.t.0 >= 0) {
            rate[(event.t.0 / BIN_US) as usize + bins * usize::from(event.polarity.is_on())] += 1.0;
        }
        for half in rate.chunks_mut(bins) {
            let mean = half.iter().sum::<f64>() / bins as f64;
            half.iter_mut().for_each(|n| *n -= mean);
        }
        rate
    };
    let (a, b) = (rates(measured), rates(simulated));
    let match_at = |shift: i64| -> f64 {
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
    let reach = FURTHEST_US / BIN_US;
    let best = (-reach..=reach).max_by(|x, y| match_at(*x).total_cmp(&match_at(*y))).unwrap_or(0);
    // The top of a parabola through the best and its neighbours.
    let [left, top, right] = [best - 1, best, best + 1].map(match_at);
    let bend = left - 2.0 * top + right;
    let fine = if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 };
    (best as f64 + fine.clamp(-0.5, 0.5)) * BIN_US as f64
}
