//! A formula of the user's at a stage of the camera.
//!
//! # Model
//! What the value of the formula is depends on the stage that it acts at:
//!
//! | stage | value | evaluated |
//! |---|---|---|
//! | `photocurrent` | the photocurrent itself, relative to white: `light*1.1`, `light + 0.01` | at every exposure |
//! | `voltage` | what is added to the log voltage, ln | at every exposure |
//! | `threshold` | factor of both thresholds, 0.001 to 1000 | at every exposure and event, a line in between |
//! | `refractory` | refractory period behind an event, us; the memory then follows the voltage | at every event of a pixel |
//! | `loss` | probability that an event is lost | at every event that is read out |
//! | `echo` | probability that an event comes again `after_us` later, at `place` | at every event that is read out |
//! | `events` | rate of further events of each polarity, Hz per pixel | at every exposure |
//! | `delay` | delay of an event, us; none if it is negative | at every event that is read out |
//!
//! `threshold` and `refractory` act behind all other effects of the detector, on change detectors of
//! any kind (on those that compare frames once an exposure); the last four between readout and clock,
//! in the order of time, each on what is read out. Further events leave the pixels' memories alone.
//!
//! Variables, as far as a stage has them:
//!
//! | variable | what it is |
//! |---|---|
//! | `light`, `d_light` | light relative to white at the end of the exposure, and its change per ms |
//! | `age_ms`, `neighbour_age_ms` | time since the last event of the pixel, and of its eight neighbours (at `threshold` and `refractory`, of exposures before this one): 10,000 at most, and before the first |
//! | `polarity` | 1 or -1: of the event, or of the threshold or rate in question |
//! | `last_polarity` | of the last event of the pixel; 0 before the first |
//! | `time_s` | time |
//! | `column`, `row` | place in the image, from 0 (left, top) to 1 |
//! | `pixel`, `column_noise`, `row_noise` | a standard normal number of the pixel, the column, the row, for good |
//! | `patch` | the same, alike in neighbours: independent 8 pixels away |
//! | `ghost` | light at the place that is mirrored at the centre of the image |
//!
//! `a` and `b` are constants of the configuration. There are `+ - * / ^`, brackets, `exp`, `log`, `sqrt`,
//! `abs`, `sin`, `cos`, `min`, `max`, and `step`, which is 1 from zero on. All is evaluated in single
//! precision.
//!
//! # Source
//! The terms of a discrepancy between a model and data (Kaheman et al. 2019) as parts of the simulator.

pub(crate) mod events;
mod expression;
pub(crate) mod front;
pub(crate) mod kind;
pub(crate) mod pixels;
mod program;
pub(crate) mod variable;

pub use expression::FormulaFault;
pub use kind::Formula;
pub(crate) use program::{Input, Inputs, Program};

use events::{EventFormula, EventStage};
use expression::{Names, parse};
use front::FrontFormula;
use pixels::{PixelFormula, PixelQuantity};
use variable::{MAX_AGE_MS, VARIABLES, Variable};

use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, EffectConfig, LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO, NumberSpec, Parameter,
    SensorError, Settings, StageSpec, TextSpec, WordSpec,
};

const STAGE: Parameter = Parameter::Word(WordSpec {
    name: "stage",
    allowed: &[
        "threshold",
        "refractory",
        "loss",
        "echo",
        "events",
        "delay",
        "photocurrent",
        "voltage",
    ],
    default: Some("threshold"),
    doc: "the quantity that the formula gives: a factor of both thresholds, a refractory period \
          (us), the probability that an event is lost, or that it comes again, the rate of further \
          events (Hz), a delay (us), the photocurrent, or what is added to the log voltage (ln)",
});

const EXPRESSION: Parameter = Parameter::Text(TextSpec {
    name: "expression",
    example: "0.5 + 0.2*light",
    doc: "the formula: figures, the constants a and b, the variables light, d_light, age_ms, \
          neighbour_age_ms, polarity, last_polarity, time_s, column, row, pixel, patch, \
          column_noise, row_noise and ghost as far as the stage has them, + - * / ^, brackets, exp, \
          log, sqrt, abs, sin, cos, min, max and step",
});

const A: Parameter = Parameter::Number(NumberSpec {
    name: "a",
    range: (-1e6, 1e6),
    doc: "a constant of the formula",
    ..LINEAR_OFF_AT_ZERO
});

const B: Parameter = Parameter::Number(NumberSpec {
    name: "b",
    range: (1e-6, 1e6),
    doc: "another constant of the formula, such as a time in ms",
    ..LOG_OFF_AT_ZERO
});

const AFTER: Parameter = Parameter::Number(NumberSpec {
    name: "after_us",
    unit: "us",
    range: (1.0, 1e6),
    typical: Some((1.0, 1e5)),
    doc: "time from an event to its echo",
    ..LOG_OFF_AT_ZERO
});

const PLACE: Parameter = Parameter::Word(WordSpec {
    name: "place",
    allowed: &["here", "right", "left", "below", "above", "any"],
    default: Some("here"),
    doc: "the pixel of an echo: that of the event, or the next one; any of these four at random",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "formula",
    domain: Domain::Readout,
    summary: "a formula of light, ages of events, time and place acts at one stage of the camera",
    formula: "stage = expression",
    params: &[A, B, AFTER, STAGE, PLACE, EXPRESSION],
    source: Citation {
        key: "Kaheman et al. 2019",
        text: "K. Kaheman, E. Kaiser, B. Strom, J. N. Kutz, S. L. Brunton: Learning Discrepancy \
               Models from Experimental Data, arXiv 1909.08574, 2019",
    },
    signature: Signature {
        look_for: "what the formula says: an effect that has no name yet",
        probe: Probe::EventImage,
        strength: Strength::FromFiles,
        beside: &[],
    },
    build: |settings| {
        // Without an expression the stage is neutral, and left out of the chain.
        let text = settings.text(&EXPRESSION).unwrap_or("1");
        Ok(Stage::Formula(Formula::read(text, settings)?))
    },
};

/// Values of the formula of an effect along one of its variables. Others are those of an ON event of a
/// pixel at rest: light of one half, ages without end, in the middle of the image; patterns are zero.
///
/// # Errors
/// As for a chain with the effect.
pub fn formula_curve(
    effect: &EffectConfig,
    along: &str,
    at: &[f64],
) -> Result<Vec<f64>, SensorError> {
    let settings = SPEC.settings(effect)?;
    let program = Formula::program(settings.text(&EXPRESSION).unwrap_or("1"), &settings)?;
    let mut point = [0.0; VARIABLES];
    for (variable, value) in [
        (Variable::Light, 0.5),
        (Variable::Age, MAX_AGE_MS),
        (Variable::NeighbourAge, MAX_AGE_MS),
        (Variable::Polarity, 1.0),
        (Variable::Column, 0.5),
        (Variable::Row, 0.5),
    ] {
        point[variable as usize] = value;
    }
    let variable = Variable::ALL.into_iter().find(|variable| variable.name() == along);
    let value = |x: &f64| {
        if let Some(variable) = variable {
            point[variable as usize] = *x as f32;
        }
        f64::from(program.value(&point))
    };
    Ok(at.iter().map(value).collect())
}

/// Variables of pixels and of events.
const OF_PIXELS: &[Variable] = &[
    Variable::Light,
    Variable::LightChange,
    Variable::Age,
    Variable::NeighbourAge,
    Variable::Polarity,
    Variable::LastPolarity,
    Variable::Time,
    Variable::Column,
    Variable::Row,
    Variable::Pixel,
    Variable::Patch,
    Variable::ColumnNoise,
    Variable::RowNoise,
];

/// Variables of light and voltage, which know of no events.
const OF_FRONT: &[Variable] = &[
    Variable::Light,
    Variable::LightChange,
    Variable::Time,
    Variable::Column,
    Variable::Row,
    Variable::Pixel,
    Variable::Patch,
    Variable::ColumnNoise,
    Variable::RowNoise,
    Variable::Ghost,
];

impl Formula {
    fn program(text: &str, settings: &Settings) -> Result<Program, SensorError> {
        let stage = settings.word(&STAGE).unwrap_or("threshold");
        let variables = match stage {
            "photocurrent" | "voltage" => OF_FRONT,
            _ => OF_PIXELS,
        };
        let constants = [("a", settings.number(&A)), ("b", settings.number(&B))];
        let refused = |fault| SensorError::Formula { text: text.to_owned(), stage, fault };
        let program = parse(text, Names { variables, constants: &constants }).map_err(refused)?;
        if let Some(value) = program.first_not_finite() {
            let problem = format!("the value {value}; it has to be finite");
            return Err(refused(FormulaFault { column: 1, problem }));
        }
        Ok(program)
    }

    fn read(text: &str, settings: &Settings) -> Result<Self, SensorError> {
        let program = Self::program(text, settings)?;
        let events = |stage| {
            let after_s = settings.number(&AFTER) * 1e-6;
            let place = settings.word(&PLACE).unwrap_or("here");
            Self::Events(EventFormula::new(program.clone(), stage, after_s, place))
        };
        Ok(match settings.word(&STAGE).unwrap_or("threshold") {
            "photocurrent" => Self::Front(FrontFormula::new(program, Domain::Photodiode)),
            "voltage" => Self::Front(FrontFormula::new(program, Domain::Photoreceptor)),
            "refractory" => Self::Pixels(PixelFormula::new(program, PixelQuantity::Refractory)),
            "loss" => events(EventStage::Loss),
            "echo" => events(EventStage::Echo),
            "events" => events(EventStage::Rate),
            "delay" => events(EventStage::Delay),
            _ => Self::Pixels(PixelFormula::new(program, PixelQuantity::Threshold)),
        })
    }
}
