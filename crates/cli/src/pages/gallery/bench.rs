//! Sensors before scenes.

use anyhow::{Context, Result};
use evpose_core::{Event, Micros, Plane, SensorSize};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig, SensorModel, StageSpec};
use image::RgbImage;

use evpose_report::chart::Chart;
use evpose_report::html::escape;

/// A sensor with an effect at one strength, or without it.
pub(super) struct Variant {
    /// In a word.
    pub(super) label: &'static str,
    pub(super) values: String,
    pub(super) model: SensorModel,
    pub(super) colour: (u8, u8, u8),
}

/// Result of a measurement.
pub(super) enum Shown {
    Nothing,
    /// An image a variant, and its description.
    Images(String, Vec<RgbImage>),
    Together(Vec<Chart>),
    Each(Vec<Chart>),
}

const COLOURS: [(u8, u8, u8); 4] = [(150, 154, 164), (86, 180, 233), (0, 114, 178), (213, 94, 0)];

impl Variant {
    /// Without the effect, and at its strengths.
    pub(super) fn all(spec: &'static StageSpec) -> Result<Vec<Self>> {
        // An effect may show only with others: every variant has them, and it alone differs.
        let mut beside = Vec::new();
        for name in spec.signature.beside {
            let other = STAGES.find(name);
            beside.push(other.with_context(|| format!("no effect is called {name}"))?.typical());
        }
        let build =
            |effects: Vec<EffectConfig>| SensorModel::from_config(&SensorConfig { effects });
        let names = [&["ideal sensor"], spec.signature.beside].concat().join(" with ");
        let without = ("without", names, build(beside.clone())?);
        let mut variants = vec![without];
        for level in spec.strength_levels() {
            let effects = beside.iter().cloned().chain([level.effect]).collect();
            variants.push((level.label, level.values, build(effects)?));
        }
        let coloured = variants.into_iter().zip(COLOURS);
        let variants =
            coloured.map(|((label, values, model), colour)| Self { label, values, model, colour });
        Ok(variants.collect())
    }

    pub(super) fn caption(&self) -> String {
        format!("<b>{}</b> {}<br>", self.label, escape(&self.values))
    }
}

pub(super) fn size_of(planes: &[Plane<f32>]) -> SensorSize {
    planes.first().map_or(SensorSize { width: 1, height: 1 }, |plane| SensorSize {
        width: plane.width() as u16,
        height: plane.height() as u16,
    })
}

/// All events of planes a millisecond apart.
pub(super) fn watch(model: &SensorModel, planes: &[Plane<f32>], seed: u64) -> Result<Vec<Event>> {
    let mut run = model.start(size_of(planes), seed);
    let mut events = Vec::new();
    for (k, plane) in planes.iter().enumerate() {
        events.extend(run.expose(plane, Micros(k as i64 * 1_000))?.iter());
    }
    Ok(events)
}

/// A scene as a formula: light at column, row and seconds, known every `step_us`.
pub(super) struct Scene<L> {
    pub(super) size: (u16, u16),
    pub(super) steps: i64,
    pub(super) step_us: i64,
    pub(super) light: L,
}

/// More events than any histogram or map of a scene at rest needs.
const ENOUGH: usize = 400_000;

impl<L: Fn(usize, usize, f64) -> f64> Scene<L> {
    pub(super) fn size(&self) -> SensorSize {
        SensorSize { width: self.size.0, height: self.size.1 }
    }

    pub(super) fn plane(&self, t_s: f64) -> Plane<f32> {
        let mut plane = Plane::for_sensor(self.size(), 0.0);
        let width = usize::from(self.size.0);
        for (i, y) in plane.data_mut().iter_mut().enumerate() {
            *y = (self.light)(i % width, i / width, t_s) as f32;
        }
        plane
    }

    pub(super) fn show(&self, model: &SensorModel, seed: u64) -> Result<Vec<Event>> {
        Ok(self.run(model, seed, usize::MAX, |t_s| Some(self.plane(t_s)))?.0)
    }

    /// Events of a scene that does not change, until they are enough, and how many seconds it took.
    pub(super) fn rest(&self, model: &SensorModel, seed: u64) -> Result<(Vec<Event>, f64)> {
        self.run(model, seed, ENOUGH, |t_s| (t_s <= 0.0).then(|| self.plane(t_s)))
    }

    fn run(
        &self,
        model: &SensorModel,
        seed: u64,
        enough: usize,
        light: impl Fn(f64) -> Option<Plane<f32>>,
    ) -> Result<(Vec<Event>, f64)> {
        let mut run = model.start(self.size(), seed);
        let (mut events, mut seconds) = (Vec::new(), 0.0);
        let mut plane = Plane::for_sensor(self.size(), 0.0);
        for t in (0..=self.steps).map(|k| Micros(k * self.step_us)) {
            // None: the light has not changed.
            plane = light(t.as_seconds()).unwrap_or(plane);
            events.extend(run.expose(&plane, t)?.iter());
            seconds = t.as_seconds();
            // Strong noise would fill the memory, and a histogram needs no more.
            if events.len() > enough {
                break;
            }
        }
        Ok((events, seconds))
    }
}

pub(super) fn by_pixel(events: &[Event], size: SensorSize) -> Vec<Vec<Event>> {
    let mut pixels = vec![Vec::new(); size.pixels()];
    for event in events {
        pixels[usize::from(event.y) * usize::from(size.width) + usize::from(event.x)].push(*event);
    }
    pixels
}
