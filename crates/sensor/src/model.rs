//! A sensor: its stages in the order of the signal, ready to run.

use std::sync::Arc;

use evpose_core::SensorSize;

use crate::chain::{Chain, FrontStage, Link};
use crate::chain_table::{ChainRow, ChainTable};
use crate::detector::Recovery;
use crate::detector::level_crossing;
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

/// An effect of the configuration with its stage.
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
            if built.iter().all(|other| other.stage.place() != ideal.stage.place()) {
                built.push(ideal);
            }
        }
        // The sort is stable: within a domain the order of the list stays. Only the photoreceptor
        // law goes in front of all else in its domain.
        built.sort_by_key(|b| (b.spec.domain, !matches!(b.stage, Stage::Photoreceptor(_))));
        let rows = built.iter().map(|b| ChainRow {
            spec: b.spec,
            settings: b.settings.clone(),
            is_active: !b.stage.is_neutral(),
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
        let settings = Settings::resolve(spec, effect)?;
        let stage = (spec.build)(&settings)?;
        Ok(Self { spec, settings, stage })
    }

    fn check_beside(&self, others: &[Self]) -> Result<(), SensorError> {
        for other in others {
            if other.spec.name == self.spec.name {
                return Err(SensorError::DuplicateEffect { effect: self.spec.name });
            }
            if let Some(place) = self.stage.place()
                && other.stage.place() == Some(place)
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
    fn from(built: Vec<Built>) -> Self {
        let ideal: Box<dyn Readout> = Box::new(readout::ideal::Ideal);
        let mut chain = Self {
            steps: None,
            front: Vec::new(),
            detector: Link { name: level_crossing::SPEC.name, stage: level_crossing::ideal() },
            terms: Vec::new(),
            recovery: Recovery::NONE,
            has_renewals: false,
            steps_while_refractory: false,
            redraws: None,
            crosses_levels: true,
            is_single: false,
            background: Vec::new(),
            readout: Link { name: readout::ideal::SPEC.name, stage: ideal },
            clock: Vec::new(),
        };
        for Built { spec, stage, .. } in built.into_iter().filter(|b| !b.stage.is_neutral()) {
            let name = spec.name;
            let in_light = spec.domain < Domain::Photoreceptor;
            let front = match stage {
                Stage::Pixel(stage) if in_light => FrontStage::LightPixel(stage),
                Stage::Pixel(stage) => FrontStage::VoltagePixel(stage),
                Stage::Plane(stage) if in_light => FrontStage::LightPlane(stage),
                Stage::Plane(stage) => FrontStage::VoltagePlane(stage),
                Stage::Photoreceptor(stage) => FrontStage::Photoreceptor(stage),
                Stage::Detector(stage) => {
                    chain.crosses_levels = stage.crosses_levels();
                    chain.detector = Link { name, stage };
                    continue;
                }
                Stage::Steps(steps) => {
                    chain.steps = Some(steps);
                    continue;
                }
                Stage::Term(stage) => {
                    chain.recovery = chain.recovery.and(stage.recovery());
                    chain.has_renewals |= stage.renews();
                    chain.steps_while_refractory |= stage.steps_while_refractory();
                    let term = chain.terms.len();
                    chain.redraws = stage.redraws().map(|most| (term, most)).or(chain.redraws);
                    chain.terms.push(Link { name, stage });
                    continue;
                }
                Stage::Background(stage) => {
                    chain.background.push(Link { name, stage });
                    continue;
                }
                Stage::Readout(stage) => {
                    chain.readout = Link { name, stage };
                    continue;
                }
                Stage::Clock(stage) => {
                    chain.clock.push(Link { name, stage });
                    continue;
                }
            };
            chain.front.push(Link { name, stage: front });
        }
        let acts_on_voltage = chain.front.iter().any(|link| link.stage.is_on_voltage());
        chain.is_single = chain.detector.stage.rounds_as_published() && !acts_on_voltage;
        chain
    }
}
