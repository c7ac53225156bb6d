//! The change detector of EventHands: it compares frames and knows nothing between them.
//!
//! # Model
//! With memory `M` and `d = V - M`: if `d > C_on`, `n = max(1, ⌊d / C_on⌋)` ON events and
//! `M += n C_on`; if `d < -C_off`, `n = max(1, ⌊-d / C_off⌋)` OFF events and `M -= n C_off`;
//! otherwise nothing. All events carry the time of the exposure.
//!
//! # Source
//! EventHands (Rudnev et al. 2021), supplement, and the published simulator, whose
//! memory starts at the voltage of darkness (`start = "cold"`), so that its first frame bursts.

use evpose_core::{Polarity, StageNoise};

use super::{Change, ChangeDetector, PixelStep, THRESHOLD_OFF, THRESHOLD_ON};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Compares, Domain, Parameter, StageSpec, Traits, WordSpec};

const START: Parameter = Parameter::Word(WordSpec {
    name: "start",
    allowed: &["settled", "cold"],
    default: Some("settled"),
    doc: "whether the memory starts at the first frame or in the dark, with a burst of events",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "frame_difference",
    domain: Domain::Detector,
    summary: "whole thresholds between frame and memory, at the time of the frame",
    formula: "n = max(1, floor(|V - M| / threshold)) where |V - M| > threshold; M += n threshold",
    params: &[THRESHOLD_ON, THRESHOLD_OFF, START],
    source: Citation::RUDNEV_2021,
    signature: Signature {
        look_for: "all events of a step at the same time, that of the exposure",
        probe: Probe::Trace,
        strength: Strength::Rising(&["threshold_on", "threshold_off"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(FrameDifference {
            thresholds: [&THRESHOLD_ON, &THRESHOLD_OFF].map(|p| settings.number(p) as f32),
            starts_cold: settings.word(&START) == Some("cold"),
        })))
    },
};

/// Thresholds in units of ln.
#[derive(Debug)]
struct FrameDifference {
    thresholds: [f32; 2],
    starts_cold: bool,
}

impl ChangeDetector for FrameDifference {
    fn thresholds(&self) -> [f32; 2] {
        self.thresholds
    }

    fn traits(&self) -> Traits {
        Traits {
            compares: Compares::Frames,
            is_static: true,
            starts_cold: self.starts_cold,
            ..Traits::default()
        }
    }

    /// Memories that start cold are whole thresholds above darkness, and so is what a hand leaves
    /// behind in front of a black background: exactly one threshold away, and silent.
    fn event_limits(&self, memory: f32, [on, off]: [f32; 2]) -> Option<[f32; 2]> {
        Some([first_above(memory, on), -first_above(-memory, off)])
    }

    /// In single precision, as published: the bits of a recording depend on it.
    fn next(&self, pixel: &PixelStep, _from_s: f64, _noise: StageNoise) -> Option<Change> {
        let (memory, voltage) = (pixel.memory as f32, pixel.to as f32);
        let (on, off) = (pixel.threshold_on as f32, pixel.threshold_off as f32);
        let d = voltage - memory;
        // Strict on both sides, as published: a change of exactly one threshold is no event.
        let (polarity, threshold) = if d > on {
            (Polarity::On, on)
        } else if d < -off {
            (Polarity::Off, off)
        } else {
            return None;
        };
        // Truncation is the floor of a positive number, without a call.
        let count = ((d.abs() / threshold) as u32).max(1);
        let memory = f64::from(memory + (count as f32 * threshold).copysign(d));
        Some(Change { t_s: pixel.end_s, polarity, count, memory })
    }
}

/// The lowest voltage whose difference from `memory` is rounded to more than `threshold`.
fn first_above(memory: f32, threshold: f32) -> f32 {
    // More is rounded to from halfway to the next number on.
    let halfway = 0.5 * (f64::from(threshold) + f64::from(threshold.next_up()));
    let nearest = (f64::from(memory) + halfway) as f32;
    if nearest - memory > threshold { nearest } else { nearest.next_up() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Count, polarity and new memory of one pixel that remembers `memory` and sees `voltage`.
    fn seen(threshold: f64, memory: f64, voltage: f64) -> Option<(u32, Polarity, f64)> {
        let detector = FrameDifference { thresholds: [threshold as f32; 2], starts_cold: false };
        let step = PixelStep::of_test(memory, [memory, voltage], [threshold; 2]);
        let change = detector.next(&step, 0.0, StageNoise::new(0, SPEC.name, 3))?;
        assert_eq!(change.t_s, 1.0);
        Some((change.count, change.polarity, change.memory))
    }

    proptest! {
        #[test]
        fn a_pixel_event_limits_where_it_is_said_to(
            memory in -6.0..6.0f32, on in 0.01..2.0f32, off in 0.01..2.0f32, steps in -3..4i32,
        ) {
            let detector = FrameDifference { thresholds: [on, off], starts_cold: false };
            let [up, down] = detector.event_limits(memory, [on, off]).unwrap();
            for (from, is_up) in [(up, true), (down, false)] {
                // The next representable values above or below.
                let further = |v: f32| if steps > 0 { v.next_up() } else { v.next_down() };
                let voltage = (0..steps.abs()).fold(from, |v, _| further(v));
                let step =
                    PixelStep::of_test(memory.into(), [0.0, voltage.into()], [on, off].map(f64::from));
                let has_event = if is_up { voltage >= up } else { voltage <= down };
                let change = detector.next(&step, 0.0, StageNoise::new(0, SPEC.name, 1));
                prop_assert_eq!(change.is_some(), has_event);
            }
        }
    }

    #[test]
    fn a_change_of_exactly_one_threshold_is_no_event() {
        assert_eq!(seen(0.5, 1.0, 1.5), None);
        assert_eq!(seen(0.5, 1.0, 0.5), None);
    }

    #[test]
    fn whole_thresholds_are_counted_and_remembered() {
        for (voltage, count, polarity, memory) in [
            (1.51, 1, Polarity::On, 1.5),
            (1.99, 1, Polarity::On, 1.5),
            (2.0, 2, Polarity::On, 2.0),
            (3.7, 5, Polarity::On, 3.5),
            (0.49, 1, Polarity::Off, 0.5),
            (-0.6, 3, Polarity::Off, -0.5),
        ] {
            assert_eq!(seen(0.5, 1.0, voltage), Some((count, polarity, memory)), "{voltage}");
        }
    }
}
