//! Removes the pixels that are hot in the recording itself: [`PixelActivity`] says when.

use evpose_core::{EventStream, NumberSpec, Parameter, SensorSize, WordSpec};

use crate::{CleanError, Cleaner, CleanerSpec, HotRule, Mask, Masking, Note, PixelActivity};

const PRESET: Parameter = Parameter::Word(WordSpec {
    name: "preset",
    allowed: &["dhp19"],
    default: None,
    doc: "dhp19: pixels with 10,000 events or more",
});
const FACTOR: Parameter = Parameter::Number(NumberSpec {
    name: "factor",
    range: (1.0, 1e6),
    default: Some(5.0),
    doc: "hot pixels have clearly more than so many times the median of their neighbours",
    ..NumberSpec::LINEAR
});
const COUNT: Parameter = Parameter::Number(NumberSpec {
    name: "count",
    range: (1.0, u32::MAX as f64),
    doc: "pixels with so many events are hot, whatever their neighbours do",
    ..NumberSpec::LINEAR
});

pub(crate) static SPEC: CleanerSpec = CleanerSpec {
    name: "hot",
    summary: "removes pixels that fire far more often than those around them",
    params: &[PRESET, FACTOR, COUNT],
    displaces: false,
    build: |settings, sensor| {
        let rule = if settings.word(&PRESET).is_some() {
            SPEC.alone(settings, &PRESET)?;
            HotRule::DHP19
        } else if settings.is_given(&COUNT) {
            SPEC.alone(settings, &COUNT)?;
            HotRule::Count(settings.number(&COUNT).ceil() as u32)
        } else {
            HotRule::Neighbours { factor: settings.number(&FACTOR) }
        };
        Ok(Box::new(HotPixels::new(sensor, rule)))
    },
};

/// Finds hot pixels in a survey, and removes them.
#[derive(Debug, Clone)]
pub struct HotPixels {
    rule: HotRule,
    activity: PixelActivity,
    masking: Masking,
}

impl HotPixels {
    /// A cleaner that knows no hot pixels yet and has to survey events first.
    pub fn new(sensor: SensorSize, rule: HotRule) -> Self {
        Self {
            rule,
            activity: PixelActivity::new(sensor),
            masking: Masking::new(Mask::new(sensor)),
        }
    }
}

impl Cleaner for HotPixels {
    fn clean(&mut self, events: &mut EventStream) {
        self.masking.clean(events);
    }

    fn surveys(&self) -> bool {
        true
    }

    fn survey(&mut self, events: &EventStream) {
        self.activity.push(events);
    }

    fn settle(&mut self) -> Result<(), CleanError> {
        self.masking = Masking::new(self.activity.mask(self.rule));
        Ok(())
    }

    fn reset(&mut self) {}

    fn notes(&self) -> Vec<Note> {
        let hot = self.mask().map_or(0, |mask| mask.pixels.len());
        vec![Note { what: "hot pixels", count: hot as u64 }]
    }

    fn mask(&self) -> Option<&Mask> {
        self.masking.mask()
    }
}
