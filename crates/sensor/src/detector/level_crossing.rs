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

use super::{Change, ChangeDetector, PixelStep, THRESHOLD_OFF, THRESHOLD_ON};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Compares, Domain, StageSpec, Traits};

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "level_crossing",
    domain: Domain::Detector,
    summary: "an event at the exact time at which log voltage crosses the next level",
    formula: "event where V(t) = M +- threshold; M = V(t)",
    params: &[THRESHOLD_ON, THRESHOLD_OFF],
    source: Citation::REBECQ_2018,
    signature: Signature {
        look_for: "events in proportion to the change of log light, at the exact times of the \
                   crossings; fewer with larger thresholds",
        probe: Probe::Trace,
        strength: Strength::Rising(&["threshold_on", "threshold_off"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(LevelCrossing {
            thresholds: [&THRESHOLD_ON, &THRESHOLD_OFF].map(|p| settings.number(p) as f32),
        })))
    },
};

/// The detector of a chain that names none.
pub(crate) fn ideal() -> Box<dyn ChangeDetector> {
    Box::new(LevelCrossing { thresholds: [0.2, 0.2] })
}

/// Thresholds in units of ln.
#[derive(Debug)]
struct LevelCrossing {
    thresholds: [f32; 2],
}

impl ChangeDetector for LevelCrossing {
    fn thresholds(&self) -> [f32; 2] {
        self.thresholds
    }

    fn traits(&self) -> Traits {
        Traits { compares: Compares::Levels, is_static: true, ..Traits::default() }
    }

    fn next(&self, pixel: &PixelStep, from_s: f64, _noise: StageNoise) -> Option<Change> {
        next_level(pixel, from_s)
    }
}

/// The next level that a pixel reaches, not before `from_s`. The array asks this function itself:
/// it is most of what a sensor does behind its front.
#[inline(always)]
pub(super) fn next_level(pixel: &PixelStep, from_s: f64) -> Option<Change> {
    let now = pixel.at(from_s);
    let (on, off) = (pixel.level(Polarity::On), pixel.level(Polarity::Off));
    let (highest, lowest) = (now.max(pixel.to), now.min(pixel.to));
    let (polarity, level) = if highest >= on && (now >= on || now > off) {
        (Polarity::On, on)
    } else if lowest <= off {
        (Polarity::Off, off)
    } else {
        return None;
    };
    // A level already behind, after a new threshold or a refractory period, is answered at once.
    // Levels are compared, not times: rounding a time must not lose the last event of a step.
    let is_behind = if polarity.is_on() { now >= on } else { now <= off };
    let way = (level - pixel.from) / (pixel.to - pixel.from);
    let t_s = pixel.start_s + (pixel.end_s - pixel.start_s) * way;
    let t_s = if is_behind { from_s } else { t_s.max(from_s).min(pixel.end_s) };
    Some(Change { t_s, polarity, count: 1, memory: level })
}

/// The next level that a pixel comes through, not before `from_s`: one that it is beyond already is
/// not answered.
pub(super) fn next_level_through(pixel: &PixelStep, from_s: f64) -> Option<Change> {
    let now = pixel.at(from_s);
    let polarity = Polarity::from_on(pixel.to > now);
    let level = pixel.level(polarity);
    // A level that was drawn behind the voltage is passed already in this exposure.
    let is_ahead = (level - now) * (pixel.to - now) > 0.0;
    let is_reached = if polarity.is_on() { pixel.to >= level } else { pixel.to <= level };
    let way = (level - pixel.from) / (pixel.to - pixel.from);
    let t_s = pixel.start_s + (pixel.end_s - pixel.start_s) * way;
    let t_s = t_s.max(from_s).min(pixel.end_s);
    (is_ahead && is_reached).then_some(Change { t_s, polarity, count: 1, memory: level })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Events of one pixel whose voltage goes in a line in 1 s, and its memory behind them.
    fn seen(memory: f64, from: f64, to: f64) -> (Vec<(f64, Polarity)>, f64) {
        let detector = LevelCrossing { thresholds: [0.25, 0.5] };
        let mut step = PixelStep::of_test(memory, [from, to], [0.25, 0.5]);
        let (mut events, mut now) = (Vec::new(), step.start_s);
        while let Some(change) = detector.next(&step, now, StageNoise::new(0, SPEC.name, 1)) {
            events.push((change.t_s, change.polarity));
            (now, step.memory) = (change.t_s, change.memory);
        }
        (events, step.memory)
    }

    #[test]
    fn a_rise_crosses_every_level_at_its_time() {
        // From 0 to 1 in 1 s: each level at the time of the same number.
        let (events, memory) = seen(0.0, 0.0, 1.0);
        assert_eq!(events, [0.25, 0.5, 0.75, 1.0].map(|t| (t, Polarity::On)));
        assert_eq!(memory, 1.0);
    }

    #[test]
    fn a_fall_has_its_own_threshold() {
        // From 0.2 down to -0.8 in 1 s, memory 0: only -0.5 is crossed, after 0.7 of the way.
        let (events, memory) = seen(0.0, 0.2, -0.8);
        assert_eq!(events.len(), 1);
        assert!((events[0].0 - 0.7).abs() < 1e-12 && events[0].1 == Polarity::Off);
        assert_eq!(memory, -0.5);
    }

    #[test]
    fn below_the_threshold_nothing_happens() {
        assert_eq!(seen(0.0, 0.0, 0.2499), (vec![], 0.0));
        assert_eq!(seen(0.0, 0.0, -0.4999), (vec![], 0.0));
    }

    #[test]
    fn a_level_already_behind_is_answered_at_once() {
        assert_eq!(seen(0.0, 0.3, 0.3), (vec![(0.0, Polarity::On)], 0.25));
    }
}
