//! A sensor: its stages in the order of the signal, ready to run.

use std::sync::Arc;

use evpose_core::SensorSize;

use crate::chain::{Chain, FrontStage, Link};
use crate::chain_table::{ChainRow, ChainTable};
use crate::detector::level_crossing;
use crate::formula::kind::Formula;
use crate::plan::{ExecutionPlan, PixelPath};
use crate::readout::{self, Readout};
use crate::{
    Domain, EffectConfig, STAGES, SensorConfig, SensorError, SensorRun, Settings, Stage, StageSpec,
};

/// The chain of stages that a [`SensorConfig`] describes. Cheap to clone.
#[derive(Debug, Clone)]
pub struct SensorModel {
    chain: Arc<Chain>,
    table: ChainTable,
    layout: Layout,
}

/// How pixels are divided, on which their events do not depend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    /// Pixels that go through the chain together.
    pub(crate) block_pixels: usize,
    /// Threads that take bands of pixels through a step.
    pub(crate) threads: usize,
}

/// Pixels that go through the chain together: their signals, 16 KiB, stay in the first-level cache
/// from one stage to the next.
const BLOCK_PIXELS: usize = 2048;

struct Built {
    spec: &'static StageSpec,
    settings: Settings,
    stage: Stage,
}

impl SensorModel {
    /// Builds the chain of a configuration from the stages of this crate.
    ///
    /// A sensor needs a photoreceptor law, a change detector and a readout. Those that the
    /// configuration leaves out are the ideal ones of [`SensorConfig::default`], so that an empty
    /// configuration is the ideal sensor.
    ///
    /// # Errors
    /// Unknown, repeated and contradicting effects; unknown, missing and impossible parameters.
    pub fn from_config(config: &SensorConfig) -> Result<Self, SensorError> {
        Self::from_config_in(&STAGES, config)
    }

    /// The same with a registry of the caller's: [`STAGES`] and own stages.
    ///
    /// # Errors
    /// As [`SensorModel::from_config`].
    pub fn from_config_in(
        registry: &[&'static StageSpec],
        config: &SensorConfig,
    ) -> Result<Self, SensorError> {
        let mut built: Vec<Built> = Vec::new();
        for effect in &config.effects {
            let next = Built::new(registry, effect)?;
            next.check_beside(&built)?;
            built.push(next);
        }
        for effect in &SensorConfig::default().effects {
            let ideal = Built::new(&STAGES, effect)?;
            if built.iter().all(|other| other.stage.role() != ideal.stage.role()) {
                built.push(ideal);
            }
        }
        // The sort is stable: within a domain the order of the list stays. Only the photoreceptor
        // law goes in front of all else in its domain.
        built.sort_by_key(|b| (b.domain(), !matches!(b.stage, Stage::Photoreceptor(_))));
        let rows = built.iter().map(|b| ChainRow {
            spec: b.spec,
            settings: b.settings.clone(),
            is_active: !b.is_neutral(),
        });
        let table = ChainTable { rows: rows.collect() };
        Ok(Self {
            chain: Arc::new(Chain::from(built)),
            table,
            layout: Layout { block_pixels: BLOCK_PIXELS, threads: 1 },
        })
    }

    /// The same model with another number of pixels per block. Events do not depend on it, only
    /// speed does.
    #[must_use]
    pub fn with_block_pixels(self, block_pixels: usize) -> Self {
        Self { layout: Layout { block_pixels: block_pixels.max(1), ..self.layout }, ..self }
    }

    /// The same model with bands of pixels that go through a step on this many threads, which every
    /// run has to itself: they spin while it steps. Events do not depend on it. Chains in which pixels
    /// see each other, or wait for each other at the readout, go through a step on one thread.
    ///
    /// Worth it where a single sensor is simulated: many recordings are better simulated side by side,
    /// each on its thread.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { layout: Layout { threads: threads.max(1), ..self.layout }, ..self }
    }

    /// A sensor of `size` pixels that has seen nothing yet. Equal seeds give equal events.
    pub fn start(&self, size: SensorSize, seed: u64) -> SensorRun {
        SensorRun::new(Arc::clone(&self.chain), size, seed, self.layout)
    }

    /// The chain as a table.
    pub fn describe(&self) -> &ChainTable {
        &self.table
    }

    pub(crate) fn chain(&self) -> &Arc<Chain> {
        &self.chain
    }
}

impl Built {
    fn new(registry: &[&'static StageSpec], effect: &EffectConfig) -> Result<Self, SensorError> {
        let spec = registry.iter().find(|spec| spec.name == effect.name).ok_or_else(|| {
            SensorError::UnknownEffect {
                effect: effect.name.clone(),
                allowed: registry.iter().map(|spec| spec.name).collect(),
            }
        })?;
        let settings = spec.settings(effect)?;
        let stage = (spec.build)(&settings)?;
        Ok(Self { spec, settings, stage })
    }

    /// Place in the signal path, which a formula chooses.
    fn domain(&self) -> Domain {
        match &self.stage {
            Stage::Formula(formula) => formula.domain(),
            _ => self.spec.domain,
        }
    }

    fn is_neutral(&self) -> bool {
        self.stage.role().is_none() && self.spec.is_neutral(&self.settings)
    }

    fn check_beside(&self, others: &[Self]) -> Result<(), SensorError> {
        for other in others {
            if other.spec.name == self.spec.name {
                return Err(SensorError::DuplicateEffect { effect: self.spec.name });
            }
            if let Some(place) = self.stage.role()
                && other.stage.role() == Some(place)
            {
                let (first, second) = (other.spec.name, self.spec.name);
                return Err(SensorError::PlaceTaken { place, first, second });
            }
        }
        Ok(())
    }
}

impl From<Vec<Built>> for Chain {
    /// Sorts stages, which come in the order of the signal, by what they act on.
    fn from(mut built: Vec<Built>) -> Self {
        // Neutral stages are removed first: the plan would be slower for nothing.
        built.retain(|b| !b.is_neutral());
        let traits = |b: &Built| b.stage.traits(b.domain());
        let plan = ExecutionPlan::choose(&built.iter().map(traits).collect::<Vec<_>>());
        // A sensor has one detector and one readout, which take the places of these.
        let (detector, readout) = (level_crossing::ideal(), Box::new(readout::ideal::Ideal));
        let mut chain = Self {
            steps: None,
            front: Vec::new(),
            detector: Link { name: "", traits: detector.traits(), stage: detector },
            terms: Vec::new(),
            plan,
            redraws: None,
            formula: None,
            varies: false,
            background: Vec::new(),
            readout: Link { name: "", traits: readout.traits(), stage: readout },
            event_formula: None,
            clock: Vec::new(),
        };
        for one in built {
            let (name, traits) = (one.spec.name, one.stage.traits(one.domain()));
            let stage = one.stage;
            let front = |stage| Link { name, traits, stage };
            match stage {
                Stage::Pixel(stage) => chain.front.push(front(FrontStage::Pixel(stage))),
                Stage::Plane(stage) => chain.front.push(front(FrontStage::Plane(stage))),
                Stage::Photoreceptor(law) => {
                    chain.front.push(front(FrontStage::Photoreceptor(law)));
                }
                Stage::Detector(stage) => chain.detector = Link { name, traits, stage },
                Stage::Steps(steps) => chain.steps = Some(steps),
                Stage::Term(stage) => {
                    // Detectors that cross no levels keep their thresholds.
                    if plan.path == PixelPath::RedrawnLevels {
                        let term = chain.terms.len();
                        chain.redraws = traits.redraws.map(|limit| (term, limit)).or(chain.redraws);
                    }
                    chain.terms.push(Link { name, traits, stage });
                }
                Stage::Background(stage) => chain.background.push(Link { name, traits, stage }),
                Stage::Readout(stage) => chain.readout = Link { name, traits, stage },
                Stage::Formula(Formula::Front(stage)) => {
                    chain.front.push(front(FrontStage::Plane(Box::new(stage))));
                }
                Stage::Formula(Formula::Pixels(formula)) => {
                    chain.varies = !formula.is_pattern();
                    chain.formula = Some(formula);
                }
                Stage::Formula(Formula::Events(formula)) => chain.event_formula = Some(formula),
                Stage::Clock(stage) => chain.clock.push(Link { name, traits, stage }),
            }
        }
        chain
    }
}
