//! A Kalman filter of the position, moved by the mean velocity of every millisecond.

use evpose_core::Micros;
use glam::DVec2;

use super::constant_position::ConstantPosition;
use super::filter::{BodyEstimator, JointFilter as _, Measured, Track, pixels};
use super::{FusionConfig, FusionError};
use crate::body::{BODY_JOINTS, BodyPoints};

/// Milliseconds that are remembered.
pub(super) const SLOTS: usize = 5_000;
/// How far an edge has come when its velocity is known, pixels: the length of a triplet.
pub(super) const MEASURED_OVER_PX: f64 = 2.0;
const SLOT_US: i64 = 1_000;

/// hpe-core's `multiJointLatComp`.
///
/// # Model
/// A velocity `v` of time `t` was measured while the joint came two pixels far, and counts for
/// `max(2 / |v|, time since the velocity before)` until `t`. The velocity of a millisecond is the
/// mean of those that count for it. A detection of time `s` corrects the position at `s`, to which
/// the velocities lead from the detection before; the answer for `t` is this position and the way
/// from `s` to `t`.
///
/// The published lifetime is `2 / |v|` alone, which leaves gaps where a joint is faster than two
/// pixels per query; it forgets the way with every detection, having added all of it to the
/// position.
#[derive(Debug)]
pub(super) struct Displacement {
    config: FusionConfig,
    joints: [Option<Track<ConstantPosition>>; BODY_JOINTS],
    ways: [Way; BODY_JOINTS],
}

impl Displacement {
    pub(super) fn new(config: FusionConfig) -> Self {
        let ways = std::array::from_fn(|_| Way::new());
        Self { config, joints: [None; BODY_JOINTS], ways }
    }
}

/// Moves a joint along its way, then lets the time pass.
fn advance(joint: &mut Track<ConstantPosition>, to: Micros, way: &Way, config: &FusionConfig) {
    joint.filter.shift(way.between(joint.at, to));
    joint.advance(to, config);
}

impl BodyEstimator for Displacement {
    fn detection(
        &mut self,
        described: Micros,
        positions_px: &Measured,
        now: Micros,
    ) -> Result<(), FusionError> {
        // Without compensation, a detection counts as one of now.
        let t = if self.config.latency_compensation { described } else { now };
        // All joints are checked first, so that an error leaves every one of them unchanged.
        let measured = self.joints.iter().zip(positions_px).filter(|(_, p)| p.is_some());
        let oldest = measured.filter_map(|(joint, _)| Some(joint.as_ref()?.at)).max();
        if let Some(oldest) = oldest.filter(|&oldest| t < oldest) {
            return Err(FusionError::TooLate { t, oldest });
        }
        for ((joint, way), &position_px) in self.joints.iter_mut().zip(&self.ways).zip(positions_px)
        {
            let Some(position_px) = position_px else { continue };
            match joint {
                Some(joint) if joint.is_followed(t, &self.config) => {
                    advance(joint, t, way, &self.config);
                    joint.detect(position_px, &self.config);
                }
                // Never seen, or lost too long ago to be continued.
                _ => *joint = Some(Track::start(t, position_px, &self.config)),
            }
        }
        Ok(())
    }

    fn velocity(&mut self, t: Micros, px_per_s: &Measured) -> Result<(), FusionError> {
        let oldest = self.ways.iter().filter_map(Way::oldest).max();
        if let Some(oldest) = oldest.filter(|&oldest| t < oldest) {
            return Err(FusionError::TooLate { t, oldest });
        }
        for ((joint, way), &px_per_s) in self.joints.iter_mut().zip(&mut self.ways).zip(px_per_s) {
            let Some(px_per_s) = px_per_s else { continue };
            // What is about to be forgotten moves the joint for good.
            if let Some(joint) = joint
                && let forgotten = way.oldest_with(t)
                && joint.at < forgotten
            {
                advance(joint, forgotten, way, &self.config);
            }
            way.add(t, px_per_s);
        }
        Ok(())
    }

    fn query(&self, t: Micros) -> BodyPoints {
        std::array::from_fn(|k| {
            let joint = self.joints[k].filter(|joint| joint.at <= t)?;
            let way_px = self.ways[k].between(joint.at, t);
            joint.is_followed(t, &self.config).then_some(())?;
            pixels(joint.filter.position_px(0.0) + way_px)
        })
    }
}

/// The velocities of the last milliseconds, a slot each.
#[derive(Debug)]
struct Way {
    slots: Vec<Slot>,
    /// The latest slot, counted from time 0, once there is one.
    newest: Option<i64>,
    /// The time of the latest velocity.
    until: Option<Micros>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    mean_px_per_s: DVec2,
    count: u32,
}

impl Way {
    fn new() -> Self {
        Self { slots: vec![Slot::default(); SLOTS], newest: None, until: None }
    }

    /// The earliest time that is remembered.
    fn oldest(&self) -> Option<Micros> {
        self.newest.map(oldest_beside)
    }

    /// The same once `t` is.
    fn oldest_with(&self, t: Micros) -> Micros {
        oldest_beside(self.newest.map_or(slot_before(t), |newest| newest.max(slot_before(t))))
    }

    fn slot(&self, number: i64) -> usize {
        number.rem_euclid(self.slots.len() as i64) as usize
    }

    /// Makes room for the time until `t`.
    fn reach(&mut self, t: Micros) -> i64 {
        let last = slot_before(t);
        let newest = self.newest.unwrap_or(last);
        if last > newest {
            // After a long gap, every slot of the ring is stale and is cleared once.
            let empty = last.saturating_sub(newest).min(SLOTS as i64);
            for number in last - empty + 1..=last {
                let slot = self.slot(number);
                self.slots[slot] = Slot::default();
            }
        }
        let newest = newest.max(last);
        self.newest = Some(newest);
        newest
    }

    fn add(&mut self, t: Micros, px_per_s: DVec2) {
        let newest = self.reach(t);
        let since_us = self.until.map_or(0, |until| t.0.saturating_sub(until.0));
        self.until = Some(self.until.map_or(t, |until| until.max(t)));
        let speed = px_per_s.length();
        // A velocity of zero would count for ever and dilute all that was measured before.
        if speed == 0.0 {
            return;
        }
        // A float that is too large for an integer becomes the largest.
        let lasts_us = ((MEASURED_OVER_PX / speed * 1e6) as i64).max(since_us);
        let first = t.0.saturating_sub(lasts_us).div_euclid(SLOT_US);
        for number in first.max(newest - SLOTS as i64 + 1)..=slot_before(t) {
            let slot = self.slot(number);
            let Slot { mean_px_per_s, count } = &mut self.slots[slot];
            *count += 1;
            *mean_px_per_s += (px_per_s - *mean_px_per_s) / f64::from(*count);
        }
    }

    /// How far it went from one time to another, px.
    fn between(&self, from: Micros, to: Micros) -> DVec2 {
        let (Some(newest), Some(until)) = (self.newest, self.until) else { return DVec2::ZERO };
        // The way is known until the last velocity; after it, the joint rests.
        let to = to.min(until);
        let first = from.0.div_euclid(SLOT_US).max(newest - SLOTS as i64 + 1);
        let mut way_px = DVec2::ZERO;
        for number in first..=slot_before(to).min(newest) {
            let start_us = number.saturating_mul(SLOT_US);
            let end_us = start_us.saturating_add(SLOT_US).min(to.0);
            let inside_us = end_us - start_us.max(from.0);
            way_px += self.slots[self.slot(number)].mean_px_per_s * (inside_us as f64 * 1e-6);
        }
        way_px
    }
}

/// The slot that ends at `t` or holds it.
fn slot_before(t: Micros) -> i64 {
    t.0.saturating_sub(1).div_euclid(SLOT_US)
}

/// The start of the oldest slot that is kept beside the newest one.
fn oldest_beside(newest: i64) -> Micros {
    Micros((newest - SLOTS as i64 + 1).saturating_mul(SLOT_US))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_that_overlap_are_averaged_where_they_do() {
        let mut way = Way::new();
        // Two pixels at 500 px/s: 4 ms each.
        way.add(Micros(10_000), DVec2::new(500.0, 0.0));
        way.add(Micros(12_000), DVec2::new(0.0, 500.0));
        let all = way.between(Micros(0), Micros(20_000));
        assert!((all - DVec2::new(1.5, 1.5)).length() < 1e-12, "{all}");
        let part = way.between(Micros(9_500), Micros(10_500));
        assert!((part - DVec2::new(0.125, 0.375)).length() < 1e-12, "{part}");
    }

    #[test]
    fn fast_velocities_leave_no_gaps() {
        let mut way = Way::new();
        for k in 1..=100 {
            way.add(Micros(5_000 * k), DVec2::new(0.0, 2000.0));
        }
        let way_px = way.between(Micros(5_000), Micros(500_000));
        assert!((way_px - DVec2::new(0.0, 990.0)).length() < 1e-9, "{way_px}");
    }

    #[test]
    fn what_falls_out_of_the_history_has_moved_the_joint() {
        let config = FusionConfig { lost_after_s: f64::INFINITY, ..FusionConfig::default() };
        let mut body = Displacement::new(config);
        let start = [Some(DVec2::new(10.0, 20.0)); BODY_JOINTS];
        assert_eq!(body.detection(Micros(0), &start, Micros(0)), Ok(()));
        assert_eq!(body.velocity(Micros(0), &[Some(DVec2::ZERO); BODY_JOINTS]), Ok(()));
        for k in 1..=6_000 {
            let velocity = [Some(DVec2::new(8.0, 0.0)); BODY_JOINTS];
            assert_eq!(body.velocity(Micros(2_000 * k), &velocity), Ok(()));
        }
        let head = body.query(Micros(12_000_000))[0].expect("followed");
        // In 12 s at 8 px/s it moves by 96 px, of which only 5 s are remembered.
        assert!((head - glam::Vec2::new(106.0, 20.0)).length() < 1e-3, "{head}");
        // From before what is remembered.
        let late = body.velocity(Micros(6_999_000), &[None; BODY_JOINTS]);
        assert!(matches!(late, Err(FusionError::TooLate { .. })), "{late:?}");
    }
}
