//! The stages of a sensor in the order of the signal, without neutral ones.

use crate::background::BackgroundStage;
use crate::clock::ClockStage;
use crate::detector::{ChangeDetector, PixelTerm};
use crate::formula::events::EventFormula;
use crate::formula::pixels::PixelFormula;
use crate::optics::AdaptiveSteps;
use crate::photoreceptor::Photoreceptor;
use crate::plan::ExecutionPlan;
use crate::readout::Readout;
use crate::stage::{PixelStage, PlaneStage};
use crate::traits::Traits;

/// Stages without the neutral ones.
#[derive(Debug)]
pub(crate) struct Chain {
    pub(crate) steps: Option<AdaptiveSteps>,
    /// From luminance to log voltage.
    pub(crate) front: Vec<Link<FrontStage>>,
    pub(crate) detector: Link<Box<dyn ChangeDetector>>,
    pub(crate) terms: Vec<Link<Box<dyn PixelTerm>>>,
    /// The path of a step, which follows from the traits of all stages.
    pub(crate) plan: ExecutionPlan,
    /// The term that redraws thresholds at every exposure, and how far they deviate at most, ln.
    pub(crate) redraws: Option<(usize, f32)>,
    /// Formula of thresholds or refractory periods, and whether it is more than a fixed pattern.
    pub(crate) formula: Option<PixelFormula>,
    pub(crate) varies: bool,
    pub(crate) background: Vec<Link<Box<dyn BackgroundStage>>>,
    pub(crate) readout: Link<Box<dyn Readout>>,
    /// Formula of events that are read out.
    pub(crate) event_formula: Option<EventFormula>,
    pub(crate) clock: Vec<Link<Box<dyn ClockStage>>>,
}

/// A stage, the name that keys its noise, and its properties.
#[derive(Debug)]
pub(crate) struct Link<S> {
    pub(crate) name: &'static str,
    pub(crate) traits: Traits,
    pub(crate) stage: S,
}

#[derive(Debug)]
pub(crate) enum FrontStage {
    Pixel(Box<dyn PixelStage>),
    Plane(Box<dyn PlaneStage>),
    Photoreceptor(Box<dyn Photoreceptor>),
}

impl FrontStage {
    pub(crate) fn is_plane(&self) -> bool {
        matches!(self, Self::Plane(_))
    }

    pub(crate) fn state_planes(&self) -> usize {
        match self {
            Self::Pixel(stage) => stage.state_planes(),
            Self::Plane(stage) => stage.state_planes(),
            Self::Photoreceptor(_) => 0,
        }
    }
}

impl Chain {
    /// Voltage of a pixel without light.
    pub(crate) fn dark_v(&self) -> f32 {
        let mut dark_v = [0.0];
        if let Some(law) = self.photoreceptor() {
            law.respond(&[0.0], &mut dark_v);
        }
        dark_v[0]
    }

    /// The shortest time in which a stage answers, in seconds.
    pub(crate) fn time_constant_s(&self) -> Option<f64> {
        let stages = self.front.iter().filter_map(|link| match &link.stage {
            FrontStage::Pixel(stage) => stage.time_constant_s(),
            _ => None,
        });
        stages.min_by(f64::total_cmp)
    }

    /// Whether every request is an event at its time: no stage behind the pixels does anything.
    pub(crate) fn delivers_requests(&self) -> bool {
        self.background.is_empty()
            && self.readout.traits.is_static
            && self.event_formula.is_none()
            && self.clock.is_empty()
    }

    /// The formula of thresholds or refractory periods, unless it is a fixed pattern.
    pub(crate) fn varying(&self) -> Option<&PixelFormula> {
        self.formula.as_ref().filter(|_| self.varies)
    }

    /// The law that turns light into voltage.
    pub(crate) fn photoreceptor(&self) -> Option<&dyn Photoreceptor> {
        self.front.iter().find_map(|link| match &link.stage {
            FrontStage::Photoreceptor(stage) => Some(&**stage),
            _ => None,
        })
    }

    /// Stage names, which differ if two chains differ in more than parameters.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let front = self.front.iter().map(|link| link.name).chain([self.detector.name]);
        let terms = self.terms.iter().map(|link| link.name);
        let background = self.background.iter().map(|link| link.name);
        let clock = self.clock.iter().map(|link| link.name);
        let formulas = self.formula.iter().map(|_| "formula of pixels");
        let formulas = formulas.chain(self.event_formula.iter().map(|_| "formula of events"));
        let all = front.chain(terms).chain(background).chain([self.readout.name]);
        all.chain(formulas).chain(clock).collect()
    }
}
