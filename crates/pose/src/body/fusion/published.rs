//! hpe-core's estimators number for number, where that differs from what they mean.

use evpose_core::Micros;
use glam::DVec2;

use super::constant_position::ConstantPosition;
use super::displacement::{MEASURED_OVER_PX, SLOTS};
use super::filter::{BodyEstimator, JointFilter, Measured, pixels, seconds};
use super::{FusionConfig, FusionError};
use crate::body::{BODY_JOINTS, BodyPoints, file_from_network};

/// Joints that share one clock, which the first of them moves on.
#[derive(Debug)]
pub(super) struct SharedClock<F> {
    config: FusionConfig,
    filters: [Option<F>; BODY_JOINTS],
    clock: Option<Micros>,
}

impl<F: JointFilter> SharedClock<F> {
    pub(super) fn new(config: FusionConfig) -> Self {
        Self { config, filters: [None; BODY_JOINTS], clock: None }
    }
}

/// Numbers of joints in the order in which hpe-core goes through them.
fn in_order() -> [usize; BODY_JOINTS] {
    file_from_network(&std::array::from_fn(|joint| joint))
}

/// The position, unless a coordinate is zero or both are negative: hpe-core's test.
fn given(position_px: Option<DVec2>) -> Option<DVec2> {
    position_px.filter(|p| p.x != 0.0 && p.y != 0.0 && p.max_element() > 0.0)
}

/// Whole milliseconds from one time to a later one.
fn milliseconds(from: Micros, to: Micros) -> usize {
    to.0.saturating_sub(from.0) as usize / 1_000
}

/// Time does not run backwards.
fn check(t: Micros, clock: Option<Micros>) -> Result<(), FusionError> {
    match clock {
        Some(oldest) if t < oldest => Err(FusionError::TooLate { t, oldest }),
        _ => Ok(()),
    }
}

impl<F: JointFilter> BodyEstimator for SharedClock<F> {
    fn detection(
        &mut self,
        _: Micros,
        positions_px: &Measured,
        now: Micros,
    ) -> Result<(), FusionError> {
        check(now, self.clock)?;
        for joint in in_order() {
            let Some(position_px) = given(positions_px[joint]) else { continue };
            // As published: one clock for all joints, so that after the first no time has passed.
            let dt_s = self.clock.replace(now).map_or(0.0, |before| seconds(before, now));
            match &mut self.filters[joint] {
                Some(filter) => {
                    filter.advance(dt_s, &self.config);
                    filter.detect(position_px, &self.config);
                }
                unknown => *unknown = Some(F::start(position_px, &self.config)),
            }
        }
        Ok(())
    }

    fn velocity(&mut self, t: Micros, px_per_s: &Measured) -> Result<(), FusionError> {
        check(t, self.clock)?;
        // The first detection starts the clock; velocities before it have no duration.
        let Some(before) = self.clock else { return Ok(()) };
        self.clock = Some(t);
        for (k, joint) in in_order().into_iter().enumerate() {
            let dt_s = if k == 0 || F::ALL_CLOCKS_MOVE { seconds(before, t) } else { 0.0 };
            if let (Some(filter), Some(px_per_s)) = (&mut self.filters[joint], px_per_s[joint]) {
                filter.advance(dt_s, &self.config);
                filter.measure_velocity(px_per_s, dt_s, &self.config);
            }
        }
        Ok(())
    }

    fn query(&self, _: Micros) -> BodyPoints {
        self.filters.map(|filter| pixels(filter?.position_px(0.0)))
    }
}

/// [`super::displacement::Displacement`] whose history begins with the last detection.
#[derive(Debug)]
pub(super) struct ForgetfulDisplacement {
    config: FusionConfig,
    joints: [Option<ConstantPosition>; BODY_JOINTS],
    ways: [Way; BODY_JOINTS],
    detected: Option<Micros>,
}

impl ForgetfulDisplacement {
    pub(super) fn new(config: FusionConfig) -> Self {
        let ways = std::array::from_fn(|_| Way::new());
        Self { config, joints: [None; BODY_JOINTS], ways, detected: None }
    }
}

impl BodyEstimator for ForgetfulDisplacement {
    fn detection(
        &mut self,
        described: Micros,
        positions_px: &Measured,
        now: Micros,
    ) -> Result<(), FusionError> {
        let is_compensated = self.config.latency_compensation;
        // With compensation, a detection belongs to the image that it describes.
        let t = if is_compensated { described } else { now };
        check(t, self.detected)?;
        let before = self.detected.replace(t).unwrap_or(t);
        for (joint, way) in self.ways.iter_mut().enumerate() {
            let position_px = given(positions_px[joint]);
            match &mut self.joints[joint] {
                Some(filter) => {
                    // All of the way without compensation.
                    let elapsed_ms = milliseconds(before, t);
                    let count = if is_compensated { elapsed_ms.min(SLOTS) } else { SLOTS };
                    let (past, rest) = way.px_per_ms.split_at(count);
                    // The way before the image, then the detection, then the way since.
                    filter.shift(past.iter().sum());
                    filter.advance(seconds(before, t), &self.config);
                    if let Some(position_px) = position_px {
                        filter.detect(position_px, &self.config);
                    }
                    filter.shift(rest.iter().sum());
                }
                unknown => {
                    *unknown = position_px.map(|at| ConstantPosition::start(at, &self.config));
                }
            }
            way.clear();
        }
        Ok(())
    }

    fn velocity(&mut self, t: Micros, px_per_s: &Measured) -> Result<(), FusionError> {
        let Some(detected) = self.detected else { return Ok(()) };
        check(t, Some(detected))?;
        let now_ms = milliseconds(detected, t);
        for (way, px_per_s) in self.ways.iter_mut().zip(px_per_s) {
            if let Some(px_per_s) = px_per_s {
                way.add(now_ms, *px_per_s * 1e-3);
            }
        }
        Ok(())
    }

    fn query(&self, _: Micros) -> BodyPoints {
        std::array::from_fn(|k| {
            let filter = self.joints[k]?;
            pixels(filter.position_px(0.0) + self.ways[k].px_per_ms.iter().sum::<DVec2>())
        })
    }
}

/// Mean velocities of the milliseconds after a detection.
#[derive(Debug)]
struct Way {
    px_per_ms: Vec<DVec2>,
    counts: Vec<u32>,
}

impl Way {
    fn new() -> Self {
        Self { px_per_ms: vec![DVec2::ZERO; SLOTS], counts: vec![0; SLOTS] }
    }

    fn add(&mut self, now_ms: usize, px_per_ms: DVec2) {
        if px_per_ms == DVec2::ZERO {
            return;
        }
        // What is published writes behind the last slot when the history is full.
        let last = now_ms.min(SLOTS - 1);
        let lasts_ms = MEASURED_OVER_PX / px_per_ms.length();
        let first = (last as f64 - lasts_ms).max(0.0) as usize + 1;
        for slot in first..=last {
            self.counts[slot] += 1;
            let change = px_per_ms - self.px_per_ms[slot];
            self.px_per_ms[slot] += change / f64::from(self.counts[slot]);
        }
    }

    fn clear(&mut self) {
        self.px_per_ms.fill(DVec2::ZERO);
        self.counts.fill(0);
    }
}
