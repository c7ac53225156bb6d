//! What is compared with what: a model with one part of the data to fit and one to judge on.

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_sensor::SensorConfig;

use super::{Model, prepared};
use crate::input::Nominal;
use crate::naming::Bench;
use crate::report::SECOND_RECORDING;
use crate::{GapError, Lab, Layout, Scene, Stage};

/// Part of a single recording that is fitted; the rest is held out.
const FITTED: f64 = 0.6;

/// A recording beside its scene, both of the same sensor.
#[derive(Debug, Clone)]
pub struct Case {
    /// The events.
    pub measured: EventStream,
    /// The light.
    pub scene: Scene,
    /// The part of time that is compared.
    pub window: TimeWindow,
}

impl Case {
    /// All of a recording that its scene covers.
    ///
    /// # Errors
    /// If they are of different sensors or there are no events.
    pub fn new(measured: &EventStream, scene: Scene) -> Result<Self, GapError> {
        let (of_events, of_scene): (SensorSize, SensorSize) = (measured.sensor(), scene.size());
        if of_events != of_scene {
            return Err(GapError::Recording(format!(
                "of a sensor of {of_events}, but the scene is of one of {of_scene}"
            )));
        }
        // The last plane counts.
        let window = TimeWindow { start: Micros(0), end: scene.duration() + Micros(1) };
        let mut measured = measured.slice(window);
        if !scene.blind().is_empty() {
            let seen = measured.iter().filter(|event| scene.sees(event));
            measured = EventStream::from_events(of_scene, seen)
                .map_err(|error| GapError::Recording(error.to_string()))?;
        }
        if measured.is_empty() {
            return Err(GapError::Recording("no events while the scene lasts".to_owned()));
        }
        Ok(Self { measured, scene, window })
    }

    /// The first part of the recording.
    pub(super) fn first(&self, duration: Micros) -> Self {
        let scene = self.scene.first(duration);
        let window = TimeWindow { start: Micros(0), end: scene.duration() + Micros(1) };
        Self { measured: self.measured.slice(window), scene, window }
    }
}

/// What the answer is judged on.
#[derive(Debug, Clone)]
pub enum HeldOut {
    /// A second recording, best of another scene.
    Recording(Case),
    /// The later part of the only recording.
    Later,
}

/// All that a comparison needs.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// What is fitted.
    pub train: Case,
    /// What the answer is judged on.
    pub held: HeldOut,
    /// The model.
    pub model: SensorConfig,
    /// What the maker says of the sensor.
    pub nominal: Option<Nominal>,
    /// Effects that are not looked for.
    pub left_out: Vec<String>,
    /// Seed of all noise of simulations.
    pub seed: u64,
    /// Fewer runs of everything but the naming.
    pub is_quick: bool,
}

/// Inputs with all that is made of them once.
#[derive(Debug)]
pub struct Prepared {
    /// The model.
    pub model: Model,
    /// What is measured of events.
    pub layout: Layout,
    /// Effects that are not looked for.
    pub left_out: Vec<String>,
    /// Seed of all noise.
    pub seed: u64,
    /// Fewer runs of everything but the naming.
    pub is_quick: bool,
    /// What was assumed, a line each.
    pub notes: Vec<String>,
    pub(super) begins_at_rest: bool,
    pub(super) screen: (Case, Stage),
    pub(super) train: (Case, Stage),
    pub(super) held: (Case, Stage),
}

impl Prepared {
    /// Makes the stages of a comparison.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn new(inputs: Inputs) -> Result<Self, GapError> {
        let model = prepared(&inputs.model, inputs.nominal.as_ref());
        let mut notes = model.notes.clone();
        let (train, held) = match inputs.held {
            HeldOut::Recording(held) => {
                notes.push(SECOND_RECORDING.to_owned());
                (inputs.train, held)
            }
            HeldOut::Later => {
                let all = inputs.train;
                let train = all.first(Micros((FITTED * all.scene.duration().0 as f64) as i64));
                let window = TimeWindow { start: train.window.end, end: all.window.end };
                notes.push(format!(
                    "held out: the part behind {:.3} s of the only recording, with the same pixels \
                     and the same light",
                    window.start.as_seconds()
                ));
                (train, Case { window, ..all })
            }
        };
        let whole = train.window.end;
        let train = train.fitted(inputs.is_quick);
        if train.window.end < whole {
            notes.push(format!("fitted: the first {:.3} s", train.window.end.as_seconds()));
        }
        let staged = |case: Case| -> Result<(Case, Stage), GapError> {
            let stage = Stage::new(case.scene.clone(), &model.reference)?;
            Ok((case, stage))
        };
        Ok(Self {
            screen: staged(train.screen())?,
            train: staged(train)?,
            held: staged(held)?,
            model,
            layout: Layout::of_all_probes(),
            left_out: inputs.left_out,
            seed: inputs.seed,
            is_quick: inputs.is_quick,
            notes,
            begins_at_rest: false,
        })
    }

    /// The labs of a comparison.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn bench(&self) -> Result<Bench<'_>, GapError> {
        Ok(Bench {
            screen: self.lab(&self.screen, 2)?,
            train: self.lab(&self.train, 0)?,
            held: self.lab(&self.held, 1)?,
        })
    }

    fn lab<'a>(&'a self, (case, stage): &'a (Case, Stage), i: u64) -> Result<Lab<'a>, GapError> {
        let seed = evpose_core::seed_for(self.seed, "lab", i);
        let reference = &self.model.reference;
        let mut lab = Lab::new(stage, &self.layout, &case.measured, case.window, reference, seed)?;
        lab.begins_at_rest = self.begins_at_rest;
        Ok(lab)
    }
}
