//! A stage: configuration that acts on signals, with its state kept elsewhere.
//!
//! A stage never changes: all that does is in planes owned by the
//! [`SensorRun`](crate::SensorRun). A run can therefore be cut in blocks of any size, saved and
//! looked into, and one model can serve many runs.

use std::fmt::Debug;
use std::ops::Range;

use evpose_core::{SensorSize, StageNoise};
use smallvec::SmallVec;

use crate::Domain;
use crate::background::BackgroundStage;
use crate::clock::ClockStage;
use crate::detector::{ChangeDetector, PixelTerm};
use crate::formula::kind::Formula;
use crate::optics::AdaptiveSteps;
use crate::photoreceptor::Photoreceptor;
use crate::readout::Readout;
use crate::tick::Tick;
use crate::traits::{ActsOn, Traits};

/// Signal and state of consecutive pixels, as a stage gets them.
#[derive(Debug)]
pub struct Block<'a> {
    /// Pixel indices, row by row from the top left.
    pub pixels: Range<usize>,
    /// Photocurrent relative to white, for the stages behind the photoreceptor; empty in front of
    /// it, where `signal` is the light itself.
    pub photocurrent: &'a [f32],
    /// Luminance, irradiance or photocurrent (relative to white) in front of the photoreceptor,
    /// log voltage (units of ln) behind it.
    pub signal: &'a mut [f32],
    /// The stage's own memory of these pixels.
    pub state: State<'a>,
}

/// The state planes of one stage, as far as they belong to a block.
#[derive(Debug)]
pub struct State<'a> {
    planes: SmallVec<[&'a mut [f32]; COMMON_PLANES]>,
}

/// More planes than this are listed on the heap.
pub(crate) const COMMON_PLANES: usize = 4;

impl<'a> State<'a> {
    pub(crate) fn new(planes: &'a mut [&mut [f32]], range: Range<usize>) -> Self {
        Self { planes: planes.iter_mut().map(|plane| &mut plane[range.clone()]).collect() }
    }

    /// The `N` planes that the stage asked for in `state_planes`.
    ///
    /// # Panics
    /// If it asked for another number.
    pub fn planes<const N: usize>(&mut self) -> [&mut [f32]; N] {
        assert_eq!(self.planes.len(), N, "the number of planes given by `state_planes`");
        let mut planes = self.planes.iter_mut();
        std::array::from_fn(|_| match planes.next() {
            Some(plane) => &mut **plane,
            None => &mut [],
        })
    }
}

/// A stage that treats every pixel by itself, so that the chain may run it block by block.
pub trait PixelStage: Send + Sync + Debug {
    /// The shortest time in which the stage answers to light of white, in seconds, if it takes
    /// time at all: a chain that divides its steps keeps them shorter.
    fn time_constant_s(&self) -> Option<f64> {
        None
    }

    /// Properties from which the chain chooses the path of a step.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// How many `f32` values a pixel keeps between exposures, the same for all parameters.
    fn state_planes(&self) -> usize {
        0
    }

    /// Fills the state just before the first step; the signal is the one that step will see.
    fn init(&self, _block: &mut Block<'_>, _noise: StageNoise) {}

    /// Takes the signal from the stage before and leaves it for the stage behind.
    fn step(&self, tick: &Tick, block: &mut Block<'_>, noise: StageNoise);
}

/// A stage in which pixels see each other: the chain runs it on the whole plane.
pub trait PlaneStage: Send + Sync + Debug {
    /// Properties from which the chain chooses the path of a step.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// How many planes of `f32` it keeps between exposures or needs to work, the same for all
    /// parameters.
    fn state_planes(&self) -> usize {
        0
    }

    /// Fills the state just before the first step; the signal is the one that step will see.
    fn init(&self, _size: SensorSize, _plane: &mut Block<'_>, _noise: StageNoise) {}

    /// Takes the signal from the stage before and leaves it for the stage behind. The block holds
    /// all pixels.
    fn step(&self, tick: &Tick, size: SensorSize, plane: &mut Block<'_>, noise: StageNoise);
}

/// A stage of any kind, as the registry builds it.
#[derive(Debug)]
pub enum Stage {
    /// Acts on the signal of one pixel: optics, photodiode or photoreceptor.
    Pixel(Box<dyn PixelStage>),
    /// Acts on the signal of the whole plane: optics, photodiode or photoreceptor.
    Plane(Box<dyn PlaneStage>),
    /// Turns photocurrent into log voltage. A sensor has one.
    Photoreceptor(Box<dyn Photoreceptor>),
    /// Turns log voltage into requests. A sensor has one.
    Detector(Box<dyn ChangeDetector>),
    /// Changes how pixels detect changes.
    Term(Box<dyn PixelTerm>),
    /// Adds requests.
    Background(Box<dyn BackgroundStage>),
    /// Divides steps. A sensor has one.
    Steps(AdaptiveSteps),
    /// Serves requests. A sensor has one.
    Readout(Box<dyn Readout>),
    /// Moves events in time.
    Clock(Box<dyn ClockStage>),
    /// Acts where the settings say.
    Formula(Formula),
}

impl Stage {
    pub(crate) fn traits(&self, domain: Domain) -> Traits {
        let in_light = domain < Domain::Photoreceptor;
        let at_rest = Traits { is_static: true, ..Traits::default() };
        let (acts_on, own) = match self {
            Self::Pixel(stage) if in_light => (ActsOn::Light, stage.traits()),
            Self::Pixel(stage) => (ActsOn::Voltage, stage.traits()),
            Self::Plane(stage) if in_light => (ActsOn::LightPlane, stage.traits()),
            Self::Plane(stage) => (ActsOn::VoltagePlane, stage.traits()),
            Self::Detector(stage) => (ActsOn::Pixels, stage.traits()),
            Self::Term(stage) => (ActsOn::Pixels, stage.traits()),
            Self::Readout(stage) => (ActsOn::Requests, stage.traits()),
            Self::Formula(Formula::Front(stage)) if in_light => {
                (ActsOn::LightPlane, stage.traits())
            }
            Self::Formula(Formula::Front(stage)) => (ActsOn::VoltagePlane, stage.traits()),
            Self::Formula(Formula::Pixels(formula)) => (ActsOn::Pixels, formula.traits()),
            // These keep no path from being taken: they have no memory, or run before or behind the
            // step.
            Self::Photoreceptor(_) => (ActsOn::Law, at_rest),
            Self::Steps(_) => (ActsOn::Light, at_rest),
            Self::Background(_) | Self::Formula(Formula::Events(_)) => (ActsOn::Requests, at_rest),
            Self::Clock(stage) => (ActsOn::Requests, Traits { is_static: true, ..stage.traits() }),
        };
        Traits { acts_on, ..own }
    }

    /// Role of the stage, if a sensor has exactly one stage of it.
    pub fn role(&self) -> Option<&'static str> {
        match self {
            Self::Photoreceptor(_) => Some("photoreceptor law"),
            Self::Detector(_) => Some("change detector"),
            Self::Readout(_) => Some("readout"),
            Self::Pixel(_)
            | Self::Plane(_)
            | Self::Term(_)
            | Self::Background(_)
            | Self::Steps(_)
            | Self::Formula(_)
            | Self::Clock(_) => None,
        }
    }
}
