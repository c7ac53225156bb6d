//! A recording of a camera, and what it shows alone.

use std::collections::BTreeSet;

use evpose_camera::calibrate::noise::{Noise, noise};
use evpose_core::stats::distribution::{NORMAL_975, student_975};
use evpose_core::stats::interval::{Interval, wilson};
use evpose_core::{EventStream, Micros, TimeWindow};
use serde::Serialize;

use super::{Source, Spec};
use crate::GapError;
use crate::surrogate::scene_free::{quiet_share, test_recording};
use crate::surrogate::{SceneFreeEffect, SceneFreeFindings};

/// Surrogates of each test: with fewer, one outlier among them hides an effect.
const REPLICATES: usize = 39;
const SEED: u64 = 1;
/// Minimum fraction of pixels and time at rest of a static scene.
const MIN_QUIET: f64 = 0.9;
/// Reason why a recording is none of a scene at rest.
const MOVES: &str = "something moves or flickers, or the recording is short";

/// A quantity as one recording shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reading {
    /// Name of the recording.
    pub recording: String,
    /// Value with its interval of 95 %; none where the recording does not show it.
    pub value: Option<Interval>,
    /// Variant, as words; none of most quantities.
    pub variant: Option<&'static str>,
    /// Reason why the recording does not show it.
    pub why: Option<String>,
}

/// Events of a camera, tested.
#[derive(Debug, Clone, Serialize)]
pub struct CameraRecording {
    /// Name, as given.
    pub name: String,
    /// From the first event to the last, seconds.
    pub seconds: f64,
    /// Whether nothing moves or flickers.
    pub is_at_rest: bool,
    /// The events.
    #[serde(skip)]
    pub events: EventStream,
    #[serde(skip)]
    findings: SceneFreeFindings,
    /// Of all of it and of both halves; none of a recording that is too short.
    #[serde(skip)]
    noise: Option<[Noise; 3]>,
}

/// An interval of a value that is not negative, with the same reach to both sides.
pub(super) fn interval(estimate: f64, reach: f64) -> Interval {
    Interval { estimate, low: Some((estimate - reach).max(0.0)), high: Some(estimate + reach) }
}

/// From a value to the upper end of its interval; the lower one may be cut off at zero.
pub(super) fn reach(value: &Interval) -> f64 {
    value.high.map_or(0.0, |high| high - value.estimate)
}

impl CameraRecording {
    /// Tests a recording for effects and measures its rates.
    ///
    /// # Errors
    /// A recording without events.
    pub fn new(name: String, events: EventStream) -> Result<Self, GapError> {
        let (Some(first), Some(last)) = (events.t().first(), events.t().last()) else {
            return Err(GapError::Recording(format!("{name}: no events")));
        };
        let window = TimeWindow { start: *first, end: *last + Micros(1) };
        let seconds = window.length().as_seconds();
        let middle = Micros((first.0 + last.0) / 2);
        let halves = [(*first, middle), (middle, window.end)];
        let [early, late] = halves.map(|(start, end)| TimeWindow { start, end });
        let parts = [window, early, late].map(|part| noise(&events, part, SEED).ok());
        let noise = match parts {
            [Some(whole), Some(early), Some(late)] => Some([whole, early, late]),
            _ => None,
        };
        let findings = test_recording(&events, REPLICATES, SEED);
        let has_lamp = findings.effects.iter().any(|effect| effect.name == "lamp_flicker");
        let is_at_rest = !has_lamp
            && noise.as_ref().is_some_and(|[whole, ..]| whole.motion.is_none())
            && quiet_share(&events).is_some_and(|share| share >= MIN_QUIET);
        Ok(Self { name, seconds, is_at_rest, events, findings, noise })
    }

    pub(super) fn known(&self, value: Interval) -> Reading {
        let recording = self.name.clone();
        Reading { recording, value: Some(value), variant: None, why: None }
    }

    pub(super) fn unknown(&self, why: &str) -> Reading {
        let (recording, why) = (self.name.clone(), Some(why.to_owned()));
        Reading { recording, value: None, variant: None, why }
    }

    pub(super) fn has_lamp(&self) -> bool {
        self.effect("lamp_flicker").is_some()
    }

    fn effect(&self, name: &str) -> Option<&SceneFreeEffect> {
        self.findings.effects.iter().find(|effect| effect.name == name)
    }

    /// Places of hot pixels.
    pub(super) fn hot_pixels(&self) -> BTreeSet<(u16, u16)> {
        self.effect("hot_pixels").into_iter().flat_map(|effect| effect.pixels.clone()).collect()
    }

    /// OFF and ON rate of a pixel at rest, Hz.
    pub(super) fn rest_hz(&self) -> Option<[f64; 2]> {
        let [noise, ..] = self.noise.as_ref().filter(|_| self.is_at_rest)?;
        Some([noise.off_hz.estimate, noise.on_hz.estimate])
    }

    /// Reads a quantity; `hot` pixels are hot in all recordings.
    pub(super) fn read(&self, spec: &Spec, hot: usize) -> Reading {
        let noise = self.noise.as_ref().filter(|_| self.is_at_rest);
        match (spec.source, spec.name, noise) {
            // Where something moves, some pixels see more of it than their neighbours.
            (_, name, None) if name.starts_with("hot_") => self.unknown(MOVES),
            (Source::Effect(name, parameter, resolution), ..) => {
                self.of_effect([name, parameter], resolution)
            }
            (Source::Nothing(why), ..) => self.unknown(why),
            (_, "hot_fraction", _) if self.effect("hot_pixels").is_some() => {
                let pixels = self.events.sensor().pixels();
                let (low, high) = wilson(hot, pixels);
                let estimate = hot as f64 / pixels as f64;
                self.known(Interval { estimate, low: Some(low), high: Some(high) })
            }
            (_, "hot_fraction", _) => self.unknown(self.why_not("hot_pixels")),
            (.., None) => self.unknown(MOVES),
            (_, "background_on_hz", Some(noise)) => self.known(self.rate(noise, |one| one.on_hz)),
            (_, "background_off_hz", Some(noise)) => self.known(self.rate(noise, |one| one.off_hz)),
            (.., Some(noise)) => {
                self.leak(self.rate(noise, |one| one.on_hz), self.rate(noise, |one| one.off_hz))
            }
        }
    }

    fn why_not(&self, effect: &str) -> &str {
        let untestable = self.findings.untestable.iter().find(|one| one.name == effect);
        untestable.map_or("not significant, or halves of a recording differ", |one| &one.why)
    }

    fn of_effect(&self, [name, parameter]: [&str; 2], [relative, absolute]: [f64; 2]) -> Reading {
        let is_lamp = name == "lamp_flicker";
        if !is_lamp && self.has_lamp() {
            return self.unknown("harmonics of the lamp look like it");
        }
        // A frequency is known to half a period in the time that is tested.
        let of_lamp = if is_lamp { 0.5 / self.findings.seconds } else { 0.0 };
        let effect = self.effect(name);
        let value = effect.and_then(|one| one.parameters.iter().find(|one| one.name == parameter));
        let (Some(effect), Some(value)) = (effect, value) else {
            return self.unknown(self.why_not(name));
        };
        let apart = value.halves.map_or(0.0, |[early, late]| 0.5 * (early - late).abs());
        let resolution = relative * value.value + absolute + of_lamp;
        let reach = (student_975(1) * apart).max(resolution);
        Reading { variant: effect.variant, ..self.known(interval(value.value, reach)) }
    }

    /// A rate at rest with the longest of its own interval, one of Poisson events, since few parts of time may be alike,
    /// and that to both halves, which differ where the camera warms up or the light changes slowly.
    fn rate(&self, [whole, early, late]: &[Noise; 3], of: impl Fn(&Noise) -> Interval) -> Interval {
        let pixel_s = self.seconds * self.events.sensor().pixels() as f64;
        let rate = of(whole);
        // Below the exact end of any count: 3.69 of none, 5.57 of one, 18.4 of ten.
        let poisson = NORMAL_975 * (rate.estimate * pixel_s + 1.0).sqrt() + 2.0;
        let drift = 0.5 * (of(early).estimate - of(late).estimate).abs();
        interval(rate.estimate, reach(&rate).max(poisson / pixel_s).max(drift))
    }

    /// Leak of the memory, regular ON events at rest (Nozaki and Delbruck 2017).
    ///
    /// Noise of rate `R`, twice that of OFF events, resets the memory. The leak, of rate `rho`, then has an event only
    /// where none came by chance for `1 / rho`, and adds `d = R / (exp(R / rho) - 1)` to the ON rate:
    /// `rho = R / ln(1 + R / d)`.
    fn leak(&self, on: Interval, off: Interval) -> Reading {
        if self.effect("leak_on").is_none() {
            return self.unknown(self.why_not("leak_on"));
        }
        let (excess, noise_hz) = (on.estimate - off.estimate, 2.0 * off.estimate);
        let value = if noise_hz > 0.0 { noise_hz / (noise_hz / excess).ln_1p() } else { excess };
        let relative = reach(&on).hypot(reach(&off)) / excess;
        self.known(interval(value, relative * value))
    }
}
