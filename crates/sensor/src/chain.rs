//! The stages of a sensor in the order of the signal, without neutral ones.

use crate::background::BackgroundStage;
use crate::clock::ClockStage;
use crate::detector::{ChangeDetector, PixelTerm, Recovery};
use crate::optics::AdaptiveSteps;
use crate::photoreceptor::Photoreceptor;
use crate::readout::Readout;
use crate::stage::{PixelStage, PlaneStage};

/// Stages without the neutral ones.
#[derive(Debug)]
pub(crate) struct Chain {
    pub(crate) steps: Option<AdaptiveSteps>,
    /// From luminance to log voltage.
    pub(crate) front: Vec<Link<FrontStage>>,
    pub(crate) detector: Link<Box<dyn ChangeDetector>>,
    pub(crate) terms: Vec<Link<Box<dyn PixelTerm>>>,
    /// The recovery of a pixel from an event.
    pub(crate) recovery: Recovery,
    /// Whether any term changes what holds until the next event.
    pub(crate) has_renewals: bool,
    pub(crate) steps_while_refractory: bool,
    /// The term that redraws thresholds at every exposure, and how far they deviate at most, ln.
    pub(crate) redraws: Option<(usize, f32)>,
    /// Whether events happen where a level is reached, and nowhere else.
    pub(crate) crosses_levels: bool,
    /// Whether voltages and memories are rounded to single precision as published.
    pub(crate) is_single: bool,
    pub(crate) background: Vec<Link<Box<dyn BackgroundStage>>>,
    pub(crate) readout: Link<Box<dyn Readout>>,
    pub(crate) clock: Vec<Link<Box<dyn ClockStage>>>,
}

/// A stage and the name that keys its noise.
#[derive(Debug)]
pub(crate) struct Link<S> {
    pub(crate) name: &'static str,
    pub(crate) stage: S,
}

/// A stage that acts on the signals of pixels.
#[derive(Debug)]
pub(crate) enum FrontStage {
    /// On light, in front of the photoreceptor law.
    LightPixel(Box<dyn PixelStage>),
    LightPlane(Box<dyn PlaneStage>),
    Photoreceptor(Box<dyn Photoreceptor>),
    /// On voltage, behind it.
    VoltagePixel(Box<dyn PixelStage>),
    VoltagePlane(Box<dyn PlaneStage>),
}

impl FrontStage {
    /// Whether the stage needs all pixels at once.
    pub(crate) fn is_plane(&self) -> bool {
        matches!(self, Self::LightPlane(_) | Self::VoltagePlane(_))
    }

    /// Whether its signal is light rather than voltage.
    pub(crate) fn is_in_light(&self) -> bool {
        matches!(self, Self::LightPixel(_) | Self::LightPlane(_))
    }

    /// Whether it acts on voltage, behind the photoreceptor law.
    pub(crate) fn is_on_voltage(&self) -> bool {
        matches!(self, Self::VoltagePixel(_) | Self::VoltagePlane(_))
    }

    pub(crate) fn state_planes(&self) -> usize {
        match self {
            Self::LightPixel(stage) | Self::VoltagePixel(stage) => stage.state_planes(),
            Self::LightPlane(stage) | Self::VoltagePlane(stage) => stage.state_planes(),
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

    /// Whether nothing acts on a pixel but its light, steady leaks and the recovery from events.
    pub(crate) fn goes_straight(&self) -> bool {
        let is_plain = self.crosses_levels && self.redraws.is_none();
        is_plain && !self.has_renewals && !self.steps_while_refractory
    }

    /// Whether a pixel answers a frame with a burst at its end, and nothing else ever acts on it.
    pub(crate) fn goes_in_bursts(&self) -> bool {
        let detector = &*self.detector.stage;
        let is_plain = detector.compares_frames() && !detector.spreads() && !self.is_single;
        is_plain && self.terms.is_empty() && !self.has_refractory_states()
    }

    /// Whether what a pixel says follows from the light it sees and has seen, and from nothing that
    /// goes on while the light stays as it is.
    pub(crate) fn rests_with_light(&self) -> bool {
        let is_static = |stage: &FrontStage| match stage {
            FrontStage::LightPixel(stage) | FrontStage::VoltagePixel(stage) => stage.is_static(),
            FrontStage::Photoreceptor(_) => true,
            FrontStage::LightPlane(_) | FrontStage::VoltagePlane(_) => false,
        };
        self.front.iter().all(|link| is_static(&link.stage))
            && self.terms.iter().all(|link| link.stage.is_pattern())
            && self.may_go_by_blocks()
            && !self.detector.stage.sees_light()
            && self.readout.stage.is_immediate()
    }

    /// Whether a block of pixels can go through the step before the next one begins: no pixel sees
    /// the voltage of another, and no event of one has a time that depends on others.
    pub(crate) fn may_go_by_blocks(&self) -> bool {
        let sees_others =
            |link: &Link<FrontStage>| matches!(link.stage, FrontStage::VoltagePlane(_));
        !self.front.iter().any(sees_others) && !self.detector.stage.spreads()
    }

    /// Whether bands of pixels can go through the step at the same time: no stage needs the whole
    /// plane.
    pub(crate) fn may_go_in_bands(&self) -> bool {
        self.may_go_by_blocks() && !self.front.iter().any(|link| link.stage.is_plane())
    }

    /// Whether pixels can be refractory for a while.
    pub(crate) fn has_refractory_states(&self) -> bool {
        self.recovery.is_refractory() || !self.readout.stage.is_immediate()
    }

    /// The shortest time in which a stage answers, in seconds.
    pub(crate) fn time_constant_s(&self) -> Option<f64> {
        let stages = self.front.iter().filter_map(|link| match &link.stage {
            FrontStage::LightPixel(stage) | FrontStage::VoltagePixel(stage) => {
                stage.time_constant_s()
            }
            _ => None,
        });
        stages.min_by(f64::total_cmp)
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
        front.chain(terms).chain(background).chain([self.readout.name]).chain(clock).collect()
    }
}
