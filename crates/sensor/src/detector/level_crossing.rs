//! The ideal change detector: an event at every exact crossing of a level.
//!
//! # Model
//! Log voltage runs in a straight line from one exposure to the next. With memory `M`, an ON event
//! happens when `V` reaches `M + C_on` and an OFF event when it reaches `M - C_off`; `M` is then
//! that level. A monotone change `ΔV` of a pixel at rest gives `⌊|ΔV| / C⌋` events.
//!
//! # Source
//! Rebecq et al. 2018 (ESIM).

use evpose_core::{Polarity, StageNoise};

use super::{ChangeDetector, THRESHOLD_OFF, THRESHOLD_ON, for_each_beyond};
use crate::stage::{Block, Stage, Tick};
use crate::{Citation, Domain, Request, StageSpec};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "level_crossing",
    domain: Domain::Detector,
    summary: "an event at the exact time at which log voltage crosses the next level",
    formula: "event where V(t) = M +- threshold; M = V(t)",
    params: &[THRESHOLD_ON, THRESHOLD_OFF],
    choices: &[],
    source: Citation {
        key: "Rebecq et al. 2018",
        text: "H. Rebecq, D. Gehrig, D. Scaramuzza: ESIM: an Open Event Camera Simulator, CoRL 2018",
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(LevelCrossing {
            threshold_on: settings.number(&THRESHOLD_ON),
            threshold_off: settings.number(&THRESHOLD_OFF),
        })))
    },
};

/// Thresholds in units of ln.
#[derive(Debug)]
struct LevelCrossing {
    threshold_on: f64,
    threshold_off: f64,
}

impl ChangeDetector for LevelCrossing {
    /// The memory, and the voltage at the exposure before.
    fn state_planes(&self) -> usize {
        2
    }

    fn init(&self, block: &mut Block<'_>, _dark_v: f32, _noise: StageNoise) {
        for plane in block.state.planes::<2>() {
            plane.copy_from_slice(block.signal);
        }
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise, out: &mut Vec<Request>) {
        let [memory, before] = block.state.planes();
        let first = block.pixels.start;
        // The search in f32 finds every pixel that the exact comparison below would: rounding
        // keeps the order of a difference and its threshold.
        let (on, off) = (self.threshold_on as f32, self.threshold_off as f32);
        let beyond = |d: f32| (d >= on) | (d <= -off);
        for_each_beyond(block.signal, memory, beyond, |index, voltage, memory| {
            let (from, to, level) =
                (f64::from(before[index]), f64::from(voltage), f64::from(*memory));
            let (polarity, threshold) = if to > level {
                (Polarity::On, self.threshold_on)
            } else {
                (Polarity::Off, -self.threshold_off)
            };
            // Truncation is the floor of a positive number, without a call.
            let count = ((to - level) / threshold) as u32;
            for k in 1..=count {
                let crossed = level + f64::from(k) * threshold;
                // A level already behind at the start of the step, after a new threshold, is
                // answered at once, and so is 0/0.
                let way = (crossed - from) / (to - from);
                let fraction = if way > 0.0 { way.min(1.0) } else { 0.0 };
                out.push(Request {
                    t_s: tick.start_s + tick.dt_s() * fraction,
                    pixel: (first + index) as u32,
                    polarity,
                });
            }
            *memory = (level + f64::from(count) * threshold) as f32;
        });
        before.copy_from_slice(block.signal);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::State;

    const TICK: Tick = Tick { start_s: 1.0, end_s: 3.0, index: 1 };

    /// Requests and new memory of one pixel whose voltage goes in a line.
    fn seen(memory: f32, from: f32, mut to: f32) -> (Vec<Request>, f32) {
        let detector = LevelCrossing { threshold_on: 0.25, threshold_off: 0.5 };
        let mut planes = [vec![memory], vec![from]];
        let mut block = Block {
            pixels: 0..1,
            photocurrent: &[],
            signal: std::slice::from_mut(&mut to),
            state: State::new(&mut planes, 0..1),
        };
        let mut out = Vec::new();
        detector.step(&TICK, &mut block, StageNoise::new(0, "level_crossing", 1), &mut out);
        assert_eq!(planes[1][0], to);
        (out, planes[0][0])
    }

    #[test]
    fn a_rise_crosses_every_level_at_its_time() {
        // From 0 to 1 in 2 s: levels 0.25, 0.5, 0.75 and 1 at 1.5, 2, 2.5 and 3 s.
        let (requests, memory) = seen(0.0, 0.0, 1.0);
        let times: Vec<f64> = requests.iter().map(|r| r.t_s).collect();
        assert_eq!(times, [1.5, 2.0, 2.5, 3.0]);
        assert!(requests.iter().all(|r| r.polarity == Polarity::On));
        assert_eq!(memory, 1.0);
    }

    #[test]
    fn a_fall_has_its_own_threshold() {
        // From 0.2 down to -0.8 in 2 s, memory 0: only -0.5 is crossed, after 0.7 of the way.
        let (requests, memory) = seen(0.0, 0.2, -0.8);
        assert_eq!(requests.len(), 1);
        assert!((requests[0].t_s - 2.4).abs() < 1e-6 && requests[0].polarity == Polarity::Off);
        assert_eq!(memory, -0.5);
    }

    #[test]
    fn below_the_threshold_nothing_happens() {
        assert_eq!(seen(0.0, 0.0, 0.2499), (vec![], 0.0));
        assert_eq!(seen(0.0, 0.0, -0.4999), (vec![], 0.0));
    }

    #[test]
    fn a_level_already_behind_is_answered_at_once() {
        let (requests, memory) = seen(0.0, 0.3, 0.3);
        assert_eq!((requests.len(), memory), (1, 0.25));
        assert!((1.0..=3.0).contains(&requests[0].t_s));
    }
}
