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

use super::{ChangeDetector, THRESHOLD_OFF, THRESHOLD_ON, for_each_beyond};
use crate::stage::{Block, Stage, Tick};
use crate::{ChoiceSpec, Citation, Domain, Request, StageSpec};

const START: ChoiceSpec = ChoiceSpec {
    name: "start",
    allowed: &["settled", "cold"],
    doc: "whether the memory starts at the first frame or in the dark, with a burst of events",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "frame_difference",
    domain: Domain::Detector,
    summary: "whole thresholds between a frame and the memory, all at the time of the frame",
    formula: "n = max(1, floor(|V - M| / threshold)) where |V - M| > threshold; M += n threshold",
    params: &[THRESHOLD_ON, THRESHOLD_OFF],
    choices: &[START],
    source: Citation {
        key: "Rudnev et al. 2021",
        text: "V. Rudnev et al.: EventHands: Real-Time Neural 3D Hand Pose Estimation from an Event \
               Stream, ICCV 2021, supplement",
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(FrameDifference {
            threshold_on: settings.number(&THRESHOLD_ON) as f32,
            threshold_off: settings.number(&THRESHOLD_OFF) as f32,
            starts_cold: settings.word(&START) == "cold",
        })))
    },
};

/// Thresholds in units of ln.
#[derive(Debug)]
struct FrameDifference {
    threshold_on: f32,
    threshold_off: f32,
    starts_cold: bool,
}

impl ChangeDetector for FrameDifference {
    /// The memory.
    fn state_planes(&self) -> usize {
        1
    }

    fn init(&self, block: &mut Block<'_>, dark_v: f32, _noise: StageNoise) {
        let [memory] = block.state.planes();
        if self.starts_cold {
            memory.fill(dark_v);
        } else {
            memory.copy_from_slice(block.signal);
        }
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise, out: &mut Vec<Request>) {
        let (on, off) = (self.threshold_on, self.threshold_off);
        let [memory] = block.state.planes();
        let first = block.pixels.start;
        // Strict on both sides, as published: a change of exactly one threshold is no event.
        let beyond = |d: f32| (d > on) | (d < -off);
        for_each_beyond(block.signal, memory, beyond, |index, voltage, memory| {
            let d = voltage - *memory;
            let (polarity, threshold) =
                if d > 0.0 { (Polarity::On, on) } else { (Polarity::Off, off) };
            // Truncation is the floor of a positive number, without a call.
            let count = ((d.abs() / threshold) as u32).max(1);
            *memory += (count as f32 * threshold).copysign(d);
            let request = Request { t_s: tick.end_s, pixel: (first + index) as u32, polarity };
            out.extend(std::iter::repeat_n(request, count as usize));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::State;

    const TICK: Tick = Tick { start_s: 0.002, end_s: 0.003, index: 3 };

    /// Requests and new memory of one pixel that remembers `memory` and sees `voltage`.
    fn seen(threshold: f32, memory: f32, mut voltage: f32) -> (Vec<Request>, f32) {
        let detector = FrameDifference {
            threshold_on: threshold,
            threshold_off: threshold,
            starts_cold: false,
        };
        let mut planes = [vec![memory]];
        let mut block = Block {
            pixels: 0..1,
            photocurrent: &[],
            signal: std::slice::from_mut(&mut voltage),
            state: State::new(&mut planes, 0..1),
        };
        let mut out = Vec::new();
        detector.step(&TICK, &mut block, StageNoise::new(0, "frame_difference", 3), &mut out);
        (out, planes[0][0])
    }

    #[test]
    fn a_change_of_exactly_one_threshold_is_no_event() {
        assert_eq!(seen(0.5, 1.0, 1.5), (vec![], 1.0));
        assert_eq!(seen(0.5, 1.0, 0.5), (vec![], 1.0));
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
            let (requests, remembered) = seen(0.5, 1.0, voltage);
            assert_eq!(requests, vec![Request { t_s: 0.003, pixel: 0, polarity }; count]);
            assert_eq!(remembered, memory, "{voltage}");
        }
    }
}
