//! Terms of formulas that are tried where no effect of the catalogue explains what is left.
//!
//! Each is a variant of the effect `formula` at one stage, with its amplitude and one more constant at
//! most. A term has an entry of its own in the manner of the catalogue, since ranges depend on the stage.

use evpose_sensor::{Citation, Probe};
use evpose_sensor::{
    Domain, EffectConfig, NumberSpec, Parameter, STAGES, Scale, Signature, StageSpec, Strength,
    Value,
};

use crate::candidate::Trial;

/// Name of the effect that terms are variants of.
pub(crate) const FORMULA: &str = "formula";

/// A formula with free constants, and what it may come from.
#[derive(Debug)]
pub(crate) struct Term {
    pub(crate) stage: &'static str,
    pub(crate) expression: &'static str,
    /// Place of echoes; empty elsewhere.
    pub(crate) place: &'static str,
    /// Variable along which it is drawn; empty for a constant.
    pub(crate) variable: &'static str,
    /// A possible cause.
    pub(crate) reading: &'static str,
    spec: StageSpec,
}

const fn a(low: f64, high: f64, scale: Scale) -> Parameter {
    let typical = Some((low, high));
    Parameter::Number(NumberSpec {
        name: "a",
        range: (low, high),
        typical,
        scale,
        ..NumberSpec::LOG
    })
}

const fn b(low: f64, high: f64) -> Parameter {
    let typical = Some((low, high));
    Parameter::Number(NumberSpec { name: "b", range: (low, high), typical, ..NumberSpec::LOG })
}

const fn after(low: f64, high: f64) -> Parameter {
    let (range, typical) = ((low, high), Some((low, high)));
    Parameter::Number(NumberSpec {
        name: "after_us",
        unit: "us",
        range,
        typical,
        ..NumberSpec::LOG
    })
}

/// Delay of an echo in the pixel of the event, and in one next to it.
const AFTER: Parameter = after(300.0, 1e5);
const AFTER_NEXT: Parameter = after(1.0, 1e4);
/// Light in which a spread falls, relative to white.
const DARK: Parameter = b(0.01, 1.0);
/// Standard deviations beyond which a column or a row is a bad one.
const BEYOND: Parameter = b(0.2, 2.5);

/// Amplitude of a threshold, or drift of the light's gain per second, with either sign.
const SIGNED: Parameter = a(-0.8, 3.0, Scale::Linear);
/// Spread of thresholds.
const SPREAD: Parameter = a(0.005, 0.6, Scale::Log);
/// Probability.
const SHARE: Parameter = a(0.005, 0.95, Scale::Log);
/// Rate, Hz.
const RATE: Parameter = a(0.05, 500.0, Scale::Log);
/// Time, us.
const TIME: Parameter = a(50.0, 1e5, Scale::Log);
/// Part of the light in a ghost.
const GHOST: Parameter = a(0.002, 0.5, Scale::Log);
/// Time constant, ms.
const DECAY: Parameter = b(0.3, 300.0);

const fn term(
    stage: &'static str,
    expression: &'static str,
    variable: &'static str,
    params: &'static [Parameter],
    domain: Domain,
    reading: &'static str,
) -> Term {
    let signature = Signature {
        look_for: reading,
        probe: Probe::EventImage,
        strength: Strength::Rising(&["a"]),
        beside: &[],
    };
    let spec = StageSpec {
        name: FORMULA,
        domain,
        summary: reading,
        formula: expression,
        params,
        source: Citation { key: "", text: "" },
        signature,
        build: |_| {
            STAGES[STAGES.iter().position(|s| s.name == FORMULA).unwrap_or(0)].typical_stage()
        },
    };
    Term { stage, expression, place: "", variable, reading, spec }
}

const fn threshold(
    expression: &'static str,
    variable: &'static str,
    params: &'static [Parameter],
    reading: &'static str,
) -> Term {
    term("threshold", expression, variable, params, Domain::Detector, reading)
}

const fn loss(
    expression: &'static str,
    variable: &'static str,
    params: &'static [Parameter],
    reading: &'static str,
) -> Term {
    term("loss", expression, variable, params, Domain::Readout, reading)
}

const fn echo(place: &'static str, params: &'static [Parameter], reading: &'static str) -> Term {
    Term { place, ..term("echo", "a", "", params, Domain::Readout, reading) }
}

const fn further(expression: &'static str, variable: &'static str, reading: &'static str) -> Term {
    let params: &'static [Parameter] = &[RATE, DECAY];
    term("events", expression, variable, params, Domain::Background, reading)
}

const fn delay(expression: &'static str, variable: &'static str, reading: &'static str) -> Term {
    term("delay", expression, variable, &[TIME], Domain::Clock, reading)
}

/// All terms, by stage.
pub(crate) static TERMS: &[Term] = &[
    threshold("1 + a*time_s", "time_s", &[SIGNED], "changes with time: temperature, supply?"),
    threshold(
        "1 + a*exp(-age_ms/b)",
        "age_ms",
        &[SIGNED, DECAY],
        "changes behind each event of the pixel: a slow reset?",
    ),
    threshold(
        "1 + a*exp(-neighbour_age_ms/b)",
        "neighbour_age_ms",
        &[SIGNED, DECAY],
        "changes behind events of neighbours: crosstalk over the supply?",
    ),
    threshold("1 + a*patch", "patch", &[SPREAD], "alike in neighbours: gradients over the die?"),
    threshold("1 + a*(column - 0.5)", "column", &[SIGNED], "changes over the columns: a gradient?"),
    threshold("1 + a*(row - 0.5)", "row", &[SIGNED], "changes over the rows: a gradient?"),
    threshold("1 + a*light", "light", &[SIGNED], "changes with light: gain of the photoreceptor?"),
    threshold(
        "1 + a*pixel*exp(-light/b)",
        "light",
        &[SPREAD, DARK],
        "differs from pixel to pixel, more in the dark: dark current?",
    ),
    threshold("1 + a*column_noise", "column_noise", &[SPREAD], "differs from column to column"),
    threshold("1 + a*row_noise", "row_noise", &[SPREAD], "differs from row to row"),
    term(
        "refractory",
        "a*step(polarity)",
        "polarity",
        &[TIME],
        Domain::Detector,
        "behind ON events alone: a timer of one comparator?",
    ),
    term(
        "refractory",
        "a*step(-polarity)",
        "polarity",
        &[TIME],
        Domain::Detector,
        "behind OFF events alone: a timer of one comparator?",
    ),
    loss("a", "", &[SHARE], "the same everywhere: a bad link?"),
    loss("a*column", "column", &[SHARE], "grows to the right: a bad driver?"),
    loss("a*(1 - column)", "column", &[SHARE], "grows to the left: a bad driver?"),
    loss("a*row", "row", &[SHARE], "grows to the bottom: a bad driver?"),
    loss("a*(1 - row)", "row", &[SHARE], "grows to the top: a bad driver?"),
    loss(
        "a*step(column_noise - b)",
        "column_noise",
        &[SHARE, BEYOND],
        "in some columns: bad contacts?",
    ),
    loss("a*step(row_noise - b)", "row_noise", &[SHARE, BEYOND], "in some rows: bad contacts?"),
    loss(
        "a*exp(-age_ms/b)",
        "age_ms",
        &[SHARE, DECAY],
        "behind events of the pixel: a busy latch?",
    ),
    loss(
        "a*exp(-neighbour_age_ms/b)",
        "neighbour_age_ms",
        &[SHARE, DECAY],
        "behind events of neighbours: collisions?",
    ),
    loss("a*step(polarity)", "polarity", &[SHARE], "of ON events alone"),
    loss("a*step(-polarity)", "polarity", &[SHARE], "of OFF events alone"),
    echo("here", &[SHARE, AFTER], "events come again: a latch that is read twice?"),
    echo("any", &[SHARE, AFTER_NEXT], "events come again next to them: crosstalk?"),
    echo("right", &[SHARE, AFTER_NEXT], "events come again in the column behind: crosstalk?"),
    echo("below", &[SHARE, AFTER_NEXT], "events come again in the row behind: crosstalk?"),
    further("a*exp(-age_ms/b)", "age_ms", "behind events of the pixel: ringing?"),
    further(
        "a*exp(-neighbour_age_ms/b)",
        "neighbour_age_ms",
        "behind events of neighbours: crosstalk?",
    ),
    term(
        "events",
        "a*light",
        "light",
        &[RATE],
        Domain::Background,
        "in proportion to light: charge from light?",
    ),
    term(
        "events",
        "a*time_s",
        "time_s",
        &[RATE],
        Domain::Background,
        "grows with time: temperature?",
    ),
    delay("a*row", "row", "grows to the bottom: rows exposed or read one after the other?"),
    delay("a*(1 - row)", "row", "grows to the top: rows exposed or read one after the other?"),
    delay("a*column", "column", "grows to the right: columns read one after the other?"),
    delay("a*(1 - column)", "column", "grows to the left: columns read one after the other?"),
    term(
        "photocurrent",
        "light + a*ghost",
        "ghost",
        &[GHOST],
        Domain::Photodiode,
        "light mirrored at the centre: a ghost in the lens?",
    ),
    term(
        "photocurrent",
        "light*(1 + a*time_s)",
        "time_s",
        &[SIGNED],
        Domain::Photodiode,
        "gain drifts with time: temperature?",
    ),
];

impl Term {
    /// The term with its second constant at each of some values across its range.
    pub(crate) fn trials(&'static self) -> Vec<Trial> {
        let params: Vec<&'static NumberSpec> = self.spec.number_params().collect();
        let mut effect = EffectConfig::new(FORMULA)
            .with("stage", self.stage)
            .with("expression", self.expression);
        if !self.place.is_empty() {
            effect = effect.with("place", self.place);
        }
        let plain = Trial { spec: &self.spec, effect, params: params.clone() };
        let Some(second) = params.get(1) else { return vec![plain] };
        // Echoes show only where their delay is nearly right.
        let count = if self.place == "here" { FINE } else { COARSE };
        let at = |k: usize| second.between(second.range, (k as f64 + 0.5) / count as f64);
        (0..count).map(|k| plain.with(second, at(k))).collect()
    }

    /// The constants of an effect of this term that lie at an end of what is tried: the best value may be beyond.
    pub(crate) fn at_an_end(&self, effect: &EffectConfig) -> Vec<&'static str> {
        let is_at_an_end = |spec: &&NumberSpec| {
            let Some(Value::Number(value)) = effect.params.get(spec.name) else { return false };
            [spec.range.0, spec.range.1].iter().any(|end| (value - end).abs() <= END * end.abs())
        };
        self.spec.number_params().filter(is_at_an_end).map(|spec| spec.name).collect()
    }

    /// The term that an effect is, if it is one.
    pub(crate) fn of(effect: &EffectConfig) -> Option<&'static Self> {
        let is = |term: &&Self, key: &str, word: &str| {
            effect.params.get(key) == Some(&word.into())
                || (word.is_empty() && term.place.is_empty())
        };
        TERMS.iter().find(|term| {
            is(term, "stage", term.stage)
                && is(term, "expression", term.expression)
                && is(term, "place", term.place)
        })
    }
}

/// How near to an end of its range a constant lies at it, relative to the end.
const END: f64 = 0.02;
/// Values of a second constant that are tried.
const COARSE: usize = 3;
const FINE: usize = 12;

#[cfg(test)]
mod tests {
    use evpose_sensor::{SensorConfig, SensorModel};

    use super::*;

    #[test]
    fn every_term_is_a_formula_at_every_strength_and_finds_itself() {
        for term in TERMS {
            for trial in term.trials() {
                for strength in trial.strengths() {
                    let effect = trial.with(trial.params[0], strength).effect;
                    let config = SensorConfig { effects: vec![effect.clone()] };
                    let model = SensorModel::from_config(&config);
                    assert!(model.is_ok(), "{}: {}", term.expression, model.unwrap_err());
                    let found = Term::of(&effect).unwrap();
                    assert_eq!((found.stage, found.expression), (term.stage, term.expression));
                    assert_eq!(found.place, term.place);
                }
            }
        }
    }
}
