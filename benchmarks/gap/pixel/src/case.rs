//! One case of the benchmark: what a measurement gives, and, apart from it, the truth.

use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::camera::record;
use crate::catalogue::{Nominal, Term, terms};
use crate::circuit::{Circuit, NoiseAddress};
use crate::convention::Convention;
use crate::effect::CameraStage;
use crate::event::{DURATION_S, HEIGHT, Recording, WIDTH};
use crate::evidence::{Evidence, compare};
use crate::pixel::Seeds;
use crate::scene::{Scene, SceneKind};
use crate::slot::Slot;
use crate::tier::Tier;

/// Frames per second of the luminance given beside the events.
pub const FPS: f64 = 1000.0;

/// Number of frames that cover a recording, both ends included.
pub const FRAMES: usize = 1001;

/// Role of a recording in its case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// The one to find the effect in.
    Train,
    /// Another scene before the same camera.
    Validation,
}

/// Groups of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseKind {
    /// One effect at one of its strengths.
    Single,
    /// Nothing hidden.
    Null,
    /// Only parameters differ.
    Parameter,
    /// Two visible effects of different stages.
    Pair,
    /// An effect that is removed from the catalogue at run time.
    LeftOut,
    /// An effect that no catalogue has.
    NeverCatalogued,
    /// Three to five effects.
    Several,
}

/// Scene and seeds of one recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RecordingSetup {
    /// Kind of the scene.
    pub scene: SceneKind,
    /// Seed of the scene.
    pub scene_seed: u64,
    /// Seed of all noise of the moment.
    pub run_seed: u64,
}

/// A case: one camera, two recordings.
#[derive(Debug, Clone)]
pub struct Case {
    /// Name that does not reveal the effects of the case.
    pub id: String,
    /// Composition of its plan.
    pub tier: Tier,
    /// Group of the plan.
    pub kind: CaseKind,
    /// Strength from 0 to 3, for singles.
    pub strength: Option<usize>,
    /// The recording to find the effect in.
    pub train: RecordingSetup,
    /// The second recording.
    pub validation: RecordingSetup,
    /// Seed of the camera's fixed pattern.
    pub camera_seed: u64,
    /// Nominal parameters, given beside the recordings.
    pub nominal: Nominal,
    /// The camera as it is.
    pub circuit: Circuit,
    /// The nominal camera with each of the hidden things alone.
    pub alone: Vec<Circuit>,
    /// The camera as it is, with each of the hidden things removed.
    pub without: Vec<Circuit>,
    /// Slots of all that is hidden or there by convention.
    pub slots: Vec<Slot>,
    /// Deviations from the ideal pixel that nothing mentions.
    pub conventions: Vec<Convention>,
    /// Effect to take out of the catalogue at run time.
    pub leave_out: Option<&'static str>,
}

/// One hidden thing and how visible it is in the train recording.
#[derive(Debug, Clone, Serialize)]
pub struct Truth {
    /// Name, kind, stage and values in catalogue units.
    #[serde(flatten)]
    pub term: Term,
    /// In a plan with conventions, the recording of the camera against the one without this; else
    /// the recording with only this against the nominal one.
    pub evidence: Evidence,
}

/// The truth about a case, for the scorer only.
#[derive(Debug, Clone, Serialize)]
pub struct Label {
    /// Name of the case.
    pub id: String,
    /// Composition of its plan.
    pub tier: Tier,
    /// Group of the plan.
    pub kind: CaseKind,
    /// Strength from 0 to 3, for singles.
    pub strength: Option<usize>,
    /// Scenes and seeds.
    pub train: RecordingSetup,
    /// Scenes and seeds of the second recording.
    pub validation: RecordingSetup,
    /// Nominal parameters, given beside the recordings.
    pub nominal: Nominal,
    /// The hidden things.
    pub truth: Vec<Truth>,
    /// Deviations from the ideal pixel that are right when named, and no miss when not.
    pub conventions: Vec<Convention>,
    /// Whether all of them are visible (false for a null).
    pub visible: bool,
    /// Stages of the hidden things.
    pub stages: Vec<CameraStage>,
    /// Whether the truth is not in the catalogue the case is looked up in.
    pub outside_catalogue: bool,
    /// Effect to take out of the catalogue at run time.
    pub leave_out: Option<&'static str>,
}

impl Case {
    /// The recording of the camera as it is.
    pub fn record(&self, which: Which) -> Recording {
        self.record_with(&self.circuit, which)
    }

    /// Frame `k` at [`FPS`]: linear luminance at the pixel centres, row by row, 1 = white.
    pub fn frame(&self, which: Which, k: usize) -> Vec<f32> {
        self.scene(which).frame(k, FPS)
    }

    /// The description beside a recording, as JSON.
    pub fn scene_json(&self, _which: Which) -> String {
        json!({
            "width": WIDTH,
            "height": HEIGHT,
            "fps": FPS,
            "duration_s": DURATION_S,
            "white": 1.0,
            "nominal": self.nominal,
        })
        .to_string()
    }

    /// The hidden things in catalogue units.
    pub fn terms(&self) -> Vec<Term> {
        self.alone.iter().flat_map(|circuit| terms(circuit, &self.nominal)).collect()
    }

    /// The scene of a recording; made anew, so keep it to draw many frames.
    pub fn scene(&self, which: Which) -> Scene {
        let take = self.take(which);
        Scene::new(take.scene, take.scene_seed)
    }

    /// The truth with its visibility: records the train scene once for each hidden thing and once
    /// more to compare with.
    pub fn label(&self) -> Label {
        let truth = match self.tier {
            Tier::Plain => self.truth_alone(),
            Tier::Home => self.truth_among_others(),
        };
        self.label_of(truth)
    }

    /// The label of a case whose hidden things are known.
    pub fn label_of(&self, truth: Vec<Truth>) -> Label {
        Label {
            id: self.id.clone(),
            tier: self.tier,
            kind: self.kind,
            strength: self.strength,
            train: self.train,
            validation: self.validation,
            nominal: self.nominal,
            // A case is visible only if all hidden things are, since its answer has to name each.
            visible: !truth.is_empty() && truth.iter().all(|truth| truth.evidence.visible),
            stages: truth.iter().map(|truth| truth.term.stage).collect(),
            truth,
            conventions: self.conventions.clone(),
            outside_catalogue: matches!(self.kind, CaseKind::LeftOut | CaseKind::NeverCatalogued),
            leave_out: self.leave_out,
        }
    }

    /// Each hidden thing against the nominal camera.
    fn truth_alone(&self) -> Vec<Truth> {
        if self.alone.is_empty() {
            return Vec::new();
        }
        let nominal = nominal_circuit(&self.nominal, self.circuit.noise_address);
        let without = self.record_with(&nominal, Which::Train);
        let of = |circuit: &Circuit| {
            self.truths(circuit, &without, &self.record_with(circuit, Which::Train))
        };
        self.alone.iter().flat_map(of).collect()
    }

    /// The camera as it is against the same one without each hidden thing.
    ///
    /// Stamps are compared to the microsecond, except where the grid of the clock is the hidden
    /// thing: on a grid, a shift of a microsecond over a tick would count as one of a period.
    fn truth_among_others(&self) -> Vec<Truth> {
        let fine = |circuit: &Circuit| {
            let mut circuit = circuit.clone();
            circuit.clock.period_us = 1.0;
            self.record_with(&circuit, Which::Train)
        };
        // Recorded once for all hidden things.
        let with = (!self.alone.is_empty()).then(|| fine(&self.circuit));
        let of = |(alone, without): (&Circuit, &Circuit)| {
            let has_grid = alone.clock.period_us > 1.0;
            let pair = match &with {
                Some(with) if !has_grid => (fine(without), with.clone()),
                _ => {
                    let record = |circuit| self.record_with(circuit, Which::Train);
                    (record(without), record(&self.circuit))
                }
            };
            self.truths(alone, &pair.0, &pair.1)
        };
        self.alone.iter().zip(&self.without).flat_map(of).collect()
    }

    /// The hidden things of a circuit, as visible as two recordings differ.
    fn truths(&self, circuit: &Circuit, without: &Recording, with: &Recording) -> Vec<Truth> {
        let truth = |term: Term| {
            let evidence = compare(without, with, term.stage);
            Truth { term, evidence }
        };
        terms(circuit, &self.nominal).into_iter().map(truth).collect()
    }

    fn take(&self, which: Which) -> RecordingSetup {
        match which {
            Which::Train => self.train,
            Which::Validation => self.validation,
        }
    }

    fn record_with(&self, circuit: &Circuit, which: Which) -> Recording {
        let seeds = Seeds { camera: self.camera_seed, run: self.take(which).run_seed };
        record(circuit, &self.scene(which), seeds)
    }
}

/// The ideal pixel with a nominal background.
pub fn nominal_circuit(nominal: &Nominal, noise_address: NoiseAddress) -> Circuit {
    let mut circuit = Circuit::ideal();
    circuit.noise_address = noise_address;
    circuit.background.on_hz = nominal.noise_on_hz;
    circuit.background.off_hz = nominal.noise_off_hz;
    circuit
}
