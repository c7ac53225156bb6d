//! Properties of events and of the light at their pixel, in ranges of physical units.

use evpose_core::Micros;
use serde::{Deserialize, Serialize};

use crate::{EventFeatures, View};

/// Ranges of light, of equally many pixels and times.
const LIGHTS: usize = 8;
/// Ranges of time and place.
const PARTS: usize = 10;
/// Edges of the change of log luminance per second.
const SPEEDS: [f64; 6] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Edges of the time since the pixel's last event, milliseconds.
const INTERVALS_MS: [f64; 9] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
/// Time between two samples of the scene, by which its exposure is counted.
const SAMPLE: Micros = Micros(10_000);

/// A property of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Property {
    /// Luminance at its pixel and time, relative to white.
    Light,
    /// Absolute change of log luminance per second.
    Speed,
    /// Time since the pixel's last event, milliseconds.
    Interval,
    /// Time since the start of the window, seconds.
    Time,
    /// Column, pixels.
    Column,
    /// Row, pixels.
    Row,
}

impl Property {
    /// All properties.
    pub const ALL: [Self; 6] =
        [Self::Light, Self::Speed, Self::Interval, Self::Time, Self::Column, Self::Row];

    /// The property as a noun phrase, for use within a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::Speed => "change of log light",
            Self::Interval => "time since the last event of the pixel",
            Self::Time => "time",
            Self::Column => "column",
            Self::Row => "row",
        }
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Light => "of white",
            Self::Speed => "per second",
            Self::Interval => "ms",
            Self::Time => "s",
            Self::Column | Self::Row => "px",
        }
    }

    /// Whether its ranges are even on a logarithmic scale.
    pub fn is_logarithmic(self) -> bool {
        matches!(self, Self::Light | Self::Speed | Self::Interval)
    }

    /// Whether a power of it is a law of physics.
    pub(super) fn has_powers(self) -> bool {
        self.is_logarithmic() || self == Self::Time
    }

    fn of_event(self, event: &EventFeatures, view: &View<'_>) -> Option<f64> {
        let width = usize::from(view.size().width);
        Some(match self {
            Self::Light => {
                let t_s = Micros(event.t_us).as_seconds();
                view.reference_scene.classes.log_at(event.pixel as usize, t_s).exp().into()
            }
            Self::Speed => f64::from(event.slope).abs(),
            Self::Interval => event.before()?.0 as f64 * 1e-3,
            Self::Time => view.since_start_us(event.t_us) as f64 * 1e-6,
            Self::Column => (event.pixel as usize % width) as f64,
            Self::Row => (event.pixel as usize / width) as f64,
        })
    }
}

#[derive(Debug, Clone)]
pub(super) struct Bins {
    pub(super) property: Property,
    pub(super) edges: Vec<f64>,
    /// A value within each range.
    pub(super) x: Vec<f64>,
    /// Pixels times seconds that the scene has in each range; empty where that is not a property
    /// of the scene.
    pub(super) exposure_s: Vec<f64>,
}

impl Bins {
    pub(super) fn of_scene(property: Property, view: &View<'_>) -> Self {
        let (size, seconds) = (view.size(), view.seconds());
        let parts = |length: f64| -> Vec<f64> {
            (1..PARTS).map(|k| length * k as f64 / PARTS as f64).collect()
        };
        let mut values = Vec::new();
        if matches!(property, Property::Light | Property::Speed) {
            let classes = &view.reference_scene.classes;
            let mut t = view.window.start;
            while t < view.window.end {
                let t_s = t.as_seconds();
                values.extend((0..size.pixels()).map(|pixel| match property {
                    Property::Light => f64::from(classes.log_at(pixel, t_s).exp()),
                    _ => f64::from(classes.slope_at(pixel, t_s)).abs(),
                }));
                t = t + SAMPLE;
            }
            values.sort_by(f64::total_cmp);
        }
        let edges = match property {
            Property::Light => {
                let quantile = |k: usize| values.get(k * values.len() / LIGHTS).copied();
                let mut edges: Vec<f64> = (1..LIGHTS).filter_map(quantile).collect();
                // Much of an image may be of one brightness, which is then one range.
                edges.dedup();
                edges
            }
            Property::Speed => SPEEDS.to_vec(),
            Property::Interval => INTERVALS_MS.to_vec(),
            Property::Time => parts(seconds),
            Property::Column => parts(f64::from(size.width)),
            Property::Row => parts(f64::from(size.height)),
        };
        let count = edges.len() + 1;
        let mut exposure_s = match property {
            // How long pixels spend at an interval depends on the events: there is no exposure to
            // divide by.
            Property::Interval => Vec::new(),
            Property::Light | Property::Speed => vec![0.0; count],
            _ => vec![seconds * size.pixels() as f64 / count as f64; count],
        };
        let each_s = seconds * size.pixels() as f64 / values.len().max(1) as f64;
        for value in &values {
            exposure_s[edges.partition_point(|edge| edge <= value)] += each_s;
        }
        let x = (0..count).map(|k| middle(property, &edges, k)).collect();
        Self { property, edges, x, exposure_s }
    }

    /// Counts of OFF and of ON events in each range.
    pub(super) fn counts(&self, view: &View<'_>) -> [Vec<f64>; 2] {
        let mut counts = [vec![0.0; self.x.len()], vec![0.0; self.x.len()]];
        for event in view.events() {
            if let Some(value) = self.property.of_event(event, view) {
                let bin = self.edges.partition_point(|edge| *edge <= value);
                counts[usize::from(event.is_on)][bin] += 1.0;
            }
        }
        counts
    }
}

/// A value within range `k`.
fn middle(property: Property, edges: &[f64], k: usize) -> f64 {
    let is_log = property.is_logarithmic();
    match (k.checked_sub(1).and_then(|i| edges.get(i)), edges.get(k)) {
        (Some(low), Some(high)) if is_log => (low * high).sqrt(),
        (Some(low), Some(high)) => 0.5 * (low + high),
        (None, Some(high)) => 0.5 * high,
        // The outer ranges have one end only: a value somewhat beyond it stands for them.
        (Some(low), None) if is_log => 1.5 * low,
        (Some(low), None) => low + 0.5 * edges.first().copied().unwrap_or(0.0),
        (None, None) => 1.0,
    }
}
