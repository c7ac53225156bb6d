//! Inputs of a comparison: a model, training data and held-out data.

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_sensor::SensorConfig;

use super::time_grid::{is_on_frame_grid, moved_to_frames};
use super::{Model, prepared};
use crate::input::Nominal;
use crate::report::SECOND_RECORDING;
use crate::search::{Budget, DataSplits};
use crate::{GapError, Layout, LightSequence, Objective, ReferenceScene};

/// Fraction of a single recording that is training data; the rest is held out.
const FITTED: f64 = 0.6;

/// A recording with its scene, both of the same sensor size.
#[derive(Debug, Clone)]
pub struct ComparisonCase {
    /// Events of the recording.
    pub measured: EventStream,
    /// Luminance of the scene.
    pub scene: LightSequence,
    /// Window of time that is compared.
    pub window: TimeWindow,
}

impl ComparisonCase {
    /// The part of a recording that its scene covers.
    ///
    /// # Errors
    /// If they are of different sensors or there are no events.
    pub fn new(measured: &EventStream, scene: LightSequence) -> Result<Self, GapError> {
        let (of_events, of_scene): (SensorSize, SensorSize) = (measured.sensor(), scene.size());
        if of_events != of_scene {
            return Err(GapError::Recording(format!(
                "of a sensor of {of_events}, but the scene is of one of {of_scene}"
            )));
        }
        // The window includes the time of the last plane.
        let window = TimeWindow { start: Micros(0), end: scene.duration() + Micros(1) };
        let mut measured = measured.slice(window);
        if !scene.masked().is_empty() {
            let compared = measured.iter().filter(|event| scene.is_compared(event));
            measured = EventStream::from_events(of_scene, compared)
                .map_err(|error| GapError::Recording(error.to_string()))?;
        }
        if measured.is_empty() {
            return Err(GapError::Recording("no events while the scene lasts".to_owned()));
        }
        Ok(Self { measured, scene, window })
    }

    /// The first `duration` of the recording.
    pub(super) fn first(&self, duration: Micros) -> Self {
        let scene = self.scene.first(duration);
        let window = TimeWindow { start: Micros(0), end: scene.duration() + Micros(1) };
        Self { measured: self.measured.slice(window), scene, window }
    }
}

/// Held-out data that models are scored on.
#[derive(Debug, Clone)]
pub enum HeldOut {
    /// A second recording, preferably of another scene.
    Recording(ComparisonCase),
    /// The later part of the only recording.
    Later,
}

/// All inputs of a comparison.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// Training data.
    pub train: ComparisonCase,
    /// Held-out data that models are scored on.
    pub held_out: HeldOut,
    /// The sensor model.
    pub model: SensorConfig,
    /// Nominal values of the sensor, which override the model's.
    pub nominal: Option<Nominal>,
    /// Effects that are excluded from the search.
    pub left_out: Vec<String>,
    /// Seed of all noise of simulations.
    pub seed: u64,
    /// Whether fewer runs are made of everything but the search.
    pub is_quick: bool,
}

/// Both parts with their stamps moved to the frames of the scene, if those of the first lie on a
/// grid of them, and the time below which nothing is compared.
fn on_frame_grid(
    train: ComparisonCase,
    held_out: ComparisonCase,
    model: &Model,
    notes: &mut Vec<String>,
) -> Result<((ComparisonCase, ComparisonCase), f64), GapError> {
    // Stamps of a program that makes events at frames say nothing of what is between them.
    let step = Micros((1e6 * train.scene.step_s()).round() as i64);
    if !is_on_frame_grid(&train.measured, step) {
        return Ok(((train, held_out), 0.0));
    }
    notes.push(format!(
        "the time stamps lie on a grid of the frames: nothing below {} us is compared",
        step.0
    ));
    let moved = |case: ComparisonCase| -> Result<ComparisonCase, GapError> {
        let reference = ReferenceScene::new(case.scene.clone(), &model.reference)?;
        Ok(ComparisonCase { measured: moved_to_frames(&case.measured, &reference, step)?, ..case })
    };
    Ok(((moved(train)?, moved(held_out)?), step.0 as f64))
}

/// Inputs with their reference scenes, layout and notes.
#[derive(Debug)]
pub struct Prepared {
    /// The model and its reference.
    pub model: Model,
    /// Layout of the summary statistics.
    pub layout: Layout,
    /// Effects that are excluded from the search.
    pub left_out: Vec<String>,
    /// Seed of all noise.
    pub seed: u64,
    /// Whether fewer runs are made of everything but the search.
    pub is_quick: bool,
    /// Assumptions, a line each.
    pub notes: Vec<String>,
    /// Time below which nothing is compared, microseconds; zero if that is none.
    resolution_us: f64,
    /// Time that the search may take; none if it ends by itself.
    pub budget: Option<Budget>,
    pub(super) begins_at_rest: bool,
    pub(super) screen: (ComparisonCase, ReferenceScene),
    pub(super) train: (ComparisonCase, ReferenceScene),
    pub(super) held_out: (ComparisonCase, ReferenceScene),
}

impl Prepared {
    /// Prepares the reference scenes of all data splits.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn new(inputs: Inputs) -> Result<Self, GapError> {
        let model = prepared(&inputs.model, inputs.nominal.as_ref());
        let mut notes = model.notes.clone();
        let (train, held_out) = match inputs.held_out {
            HeldOut::Recording(held_out) => {
                notes.push(SECOND_RECORDING.to_owned());
                (inputs.train, held_out.held_out())
            }
            HeldOut::Later => {
                let all = inputs.train.compared();
                let train = all.first(Micros((FITTED * all.scene.duration().0 as f64) as i64));
                let window = TimeWindow { start: train.window.end, end: all.window.end };
                notes.push(format!(
                    "held out: the part behind {:.3} s of the only recording, with the same pixels \
                     and the same light",
                    window.start.as_seconds()
                ));
                (train, ComparisonCase { window, ..all })
            }
        };
        let ((train, held_out), resolution_us) =
            on_frame_grid(train, held_out, &model, &mut notes)?;
        // Cut after the split: the held-out part must not depend on how much is fitted.
        let whole = train.window.end;
        let train = train.training(inputs.is_quick);
        if train.window.end < whole {
            notes.push(format!("fitted: the first {:.3} s", train.window.end.as_seconds()));
        }
        let with_reference =
            |case: ComparisonCase| -> Result<(ComparisonCase, ReferenceScene), GapError> {
                let reference_scene = ReferenceScene::new(case.scene.clone(), &model.reference)?;
                Ok((case, reference_scene))
            };
        Ok(Self {
            screen: with_reference(train.screen())?,
            train: with_reference(train)?,
            held_out: with_reference(held_out)?,
            model,
            layout: Layout::of_all_probes(),
            left_out: inputs.left_out,
            seed: inputs.seed,
            is_quick: inputs.is_quick,
            notes,
            resolution_us,
            budget: None,
            begins_at_rest: false,
        })
    }

    /// Objectives of all data splits.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn data_splits(&self) -> Result<DataSplits<'_>, GapError> {
        Ok(DataSplits {
            screen: self.objective(&self.screen, 2)?,
            train: self.objective(&self.train, 0)?,
            held_out: self.objective(&self.held_out, 1)?,
            resolution_us: self.resolution_us,
            budget: self.budget,
        })
    }

    fn objective<'a>(
        &'a self,
        (case, reference_scene): &'a (ComparisonCase, ReferenceScene),
        i: u64,
    ) -> Result<Objective<'a>, GapError> {
        // A seed of its own for each part: equal noise in both would look like agreement.
        let seed = evpose_core::seed_for(self.seed, "lab", i);
        let reference = &self.model.reference;
        let mut objective = Objective::new(
            reference_scene,
            &self.layout,
            &case.measured,
            case.window,
            reference,
            seed,
        )?;
        objective.begins_at_rest = self.begins_at_rest;
        Ok(objective)
    }
}
