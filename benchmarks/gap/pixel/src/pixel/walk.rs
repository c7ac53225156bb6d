//! Walks one pixel through time on a clock of dyadic ticks (2^-20 s), looking closer where needed.
//!
//! Light is read about every other millisecond and, wherever its midpoint is off the straight line,
//! at halves of that down to one tick. Without noise the instant of an event is the root of "input
//! minus threshold" with the light read at every trial instant, to 1e-8 s. With noise the path is
//! refined by its bridge until it is clear of the thresholds or one tick long.

use super::comparator::Comparators;
use super::front::{Front, FrontState};
use super::noise::NodeNoiseModel;
use super::{PhotonEvents, Seeds};
use crate::circuit::Circuit;
use crate::event::Spike;

/// Ticks of the pixel's clock in a second.
const TICKS_PER_S: f64 = 1_048_576.0;

/// Ticks between two looks at the light where nothing happens.
const SAMPLE_TICKS: u64 = 2048;

/// Largest departure of light from a straight line within a segment, in `ln I`.
const STRAIGHT_LN: f64 = 4e-3;

/// Width in seconds to which the instant of an event is narrowed.
const INSTANT_S: f64 = 1e-8;

#[derive(Debug, Clone, Copy)]
struct LightSample {
    tick: u64,
    t_s: f64,
    log: f64,
}

/// One pixel on its way through a recording.
pub(super) struct Walker<F> {
    log_light: F,
    front: Front,
    noise: Option<NodeNoiseModel>,
    photons: Option<PhotonEvents>,
    comparators: Comparators,
    pixel: u32,
    state: FrontState,
    noise_now: f64,
    spikes: Vec<Spike>,
}

impl<F: Fn(f64) -> f64> Walker<F> {
    pub(super) fn new(circuit: &Circuit, seeds: Seeds, pixel: u32, log_light: F) -> Self {
        let front = Front::new(circuit);
        // The camera has been looking at the scene for long: nothing fires as it begins.
        let state = front.settled(front.log_current(log_light(0.0)));
        let noise = NodeNoiseModel::new(circuit, seeds.run, pixel);
        let noise_now = noise.map_or(0.0, |noise| noise.settled());
        let mut comparators = Comparators::new(circuit, seeds.camera, seeds.run, pixel);
        comparators.balance(state.output() + noise_now, 0.0);
        Self {
            log_light,
            front,
            noise,
            photons: PhotonEvents::new(circuit, seeds.run, pixel),
            comparators,
            pixel,
            state,
            noise_now,
            spikes: Vec::new(),
        }
    }

    pub(super) fn run(mut self, duration_s: f64) -> Vec<Spike> {
        let cells = (duration_s * TICKS_PER_S / SAMPLE_TICKS as f64).ceil() as u64;
        let mut before = self.sample(0);
        for cell in 1..=cells {
            let after = self.sample(cell * SAMPLE_TICKS);
            self.refine(before, after);
            before = after;
        }
        // The last cell may reach beyond the end of the recording.
        self.spikes.retain(|spike| spike.t_s < duration_s);
        self.spikes
    }

    fn log_at(&self, t_s: f64) -> f64 {
        self.front.log_current((self.log_light)(t_s))
    }

    fn sample(&self, tick: u64) -> LightSample {
        let t_s = tick as f64 / TICKS_PER_S;
        LightSample { tick, t_s, log: self.log_at(t_s) }
    }

    /// Halves the span until light is straight in it and the noise's step is short.
    fn refine(&mut self, from: LightSample, to: LightSample) {
        if to.tick - from.tick <= 1 {
            return self.pass(from, to);
        }
        let middle = self.sample((from.tick + to.tick) / 2);
        let bent = (middle.log - 0.5 * (from.log + to.log)).abs() > STRAIGHT_LN;
        // Noise is drawn once a span: one that is long against its memory would be too smooth.
        let half_s = middle.t_s - from.t_s;
        if bent || self.noise.is_some_and(|noise| noise.is_coarse(middle.log, half_s)) {
            self.refine(from, middle);
            self.refine(middle, to);
        } else {
            self.pass(from, middle);
            self.pass(middle, to);
        }
    }

    fn pass(&mut self, from: LightSample, to: LightSample) {
        match self.noise {
            None => self.pass_smooth(from, to),
            Some(noise) => {
                let dt_s = to.t_s - from.t_s;
                let log = 0.5 * (from.log + to.log);
                let noise_to = noise.step(self.noise_now, log, dt_s, to.tick);
                self.pass_noisy(noise, from, to, noise_to);
            }
        }
    }

    /// The next end of a reset or photon event up to `end_s`.
    fn interrupt(&self, end_s: f64) -> Option<f64> {
        let release = self.comparators.release_s().unwrap_or(f64::INFINITY);
        let photon = self.photons.as_ref().map_or(f64::INFINITY, |photons| photons.next_s);
        let first = release.min(photon);
        (first <= end_s).then_some(first)
    }

    /// Ends a reset and lets photon noise fire, for all that is due by `t_s`.
    fn attend(&mut self, input: f64, log: f64, t_s: f64) {
        if self.comparators.release_s().is_some_and(|release| release <= t_s) {
            self.comparators.balance(input, t_s);
        }
        while let Some(photons) = self.photons.as_mut().filter(|photons| photons.next_s <= t_s) {
            if let Some(on) = photons.take(log).filter(|_| self.comparators.release_s().is_none()) {
                // An event without a crossing: the amplifier is balanced at its input.
                self.comparators.reset(on, input, t_s);
                self.record(on, t_s);
            }
        }
    }

    fn record(&mut self, on: bool, t_s: f64) {
        self.spikes.push(Spike { t_s, pixel: self.pixel, on });
    }

    fn pass_smooth(&mut self, from: LightSample, to: LightSample) {
        let (mut t_s, mut log) = (from.t_s, from.log);
        loop {
            let due = self.interrupt(to.t_s);
            let (end_s, end_log) = match due {
                Some(due_s) if due_s < to.t_s => {
                    // What was due before this moment is due now.
                    let due_s = due_s.max(t_s);
                    (due_s, self.log_at(due_s))
                }
                _ => (to.t_s, to.log),
            };
            let end = self.front.advance(&self.state, log, end_log, end_s - t_s);
            if self.comparators.release_s().is_none() {
                if let Some(on) = self.comparators.crossing(self.state.output(), t_s) {
                    // The level is crossed already: a step of light can cross several at once.
                    self.comparators.fire(on, t_s);
                    self.record(on, t_s);
                    continue;
                }
                if let Some(on) = self.comparators.crossing(end.output(), end_s) {
                    let side = usize::from(!on);
                    (t_s, log, self.state) = self.instant((t_s, log), (end_s, end_log, end), side);
                    self.comparators.fire(on, t_s);
                    self.record(on, t_s);
                    continue;
                }
            }
            (t_s, log, self.state) = (end_s, end_log, end);
            if due.is_some() {
                self.attend(self.state.output(), log, t_s);
            }
            if t_s >= to.t_s && self.interrupt(t_s).is_none() {
                // An event right at the end is found at the start of the next span.
                return;
            }
        }
    }

    /// The first instant at which the distance to one threshold is not positive: false position,
    /// with bisection where that is slow (a step of light).
    fn instant(
        &self,
        start: (f64, f64),
        end: (f64, f64, FrontState),
        side: usize,
    ) -> (f64, f64, FrontState) {
        let distance =
            |state: &FrontState, t_s: f64| self.comparators.distances(state.output(), t_s)[side];
        let (mut low_s, mut low) = (start.0, distance(&self.state, start.0));
        let (mut high, mut high_distance) = (end, distance(&end.2, end.0));
        let mut bisect = false;
        // Closer to the threshold than 1e-12, further steps would follow rounding errors.
        while high.0 - low_s > INSTANT_S && high_distance < -1e-12 {
            let width_s = high.0 - low_s;
            // Not at the very ends, where false position would stand still.
            let share = if bisect { 0.5 } else { (low / (low - high_distance)).clamp(0.01, 0.99) };
            let t_s = low_s + share * width_s;
            let log = self.log_at(t_s);
            let state = self.front.advance(&self.state, start.1, log, t_s - start.0);
            let here = distance(&state, t_s);
            if here > 0.0 {
                (low_s, low) = (t_s, here);
            } else {
                (high, high_distance) = ((t_s, log, state), here);
            }
            // Where false position did not halve the interval, bisection does next.
            bisect = high.0 - low_s > 0.5 * width_s;
        }
        high
    }

    fn pass_noisy(
        &mut self,
        noise: NodeNoiseModel,
        from: LightSample,
        to: LightSample,
        noise_to: f64,
    ) {
        let dt_s = to.t_s - from.t_s;
        let end = self.front.advance(&self.state, from.log, to.log, dt_s);
        let log = 0.5 * (from.log + to.log);
        let input = end.output() + noise_to;
        let undisturbed = self.interrupt(to.t_s).is_none();
        let in_reset = self.comparators.release_s().is_some();
        // Nothing is due, and in reset or far from both thresholds nothing crosses in between.
        let clear = undisturbed
            && (in_reset || {
                let here =
                    self.comparators.distances(self.state.output() + self.noise_now, from.t_s);
                let there = self.comparators.distances(input, to.t_s);
                (0..2).all(|side| noise.stays([here[side], there[side]], log, dt_s))
            });
        if clear || to.tick - from.tick <= 1 {
            self.state = end;
            self.noise_now = noise_to;
            if !clear {
                self.attend(input, to.log, to.t_s);
                // A step may cross several thresholds.
                while self.comparators.release_s().is_none() {
                    let Some(on) = self.comparators.crossing(input, to.t_s) else { break };
                    self.comparators.fire(on, to.t_s);
                    self.record(on, to.t_s);
                }
            }
            return;
        }
        let middle = self.sample((from.tick + to.tick) / 2);
        let ends = [self.noise_now, noise_to];
        // The noise in the middle, given that at both ends.
        let noise_middle = noise.midpoint(ends, log, dt_s, middle.tick);
        self.pass_noisy(noise, from, middle, noise_middle);
        self.pass_noisy(noise, middle, to, noise_to);
    }
}
