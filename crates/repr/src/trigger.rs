//! Trigger of new representations of a stream: after a minimum time *and* a minimum number of
//! events.
//!
//! # Model
//! A representation is due at the first event at least `min_interval_us` after the last
//! representation by which at least `min_events` events have come since. Events of one microsecond
//! belong together: the representation shows all of them. So a fast hand gets a representation
//! every millisecond, a slow one fewer, and a scene at rest as many as its noise makes.
//!
//! A moving object passes over a number of pixels in proportion to all there are, and noise comes
//! from each of them, so `min_events` is said for 240x180 pixels and goes with their number,
//! rounded up: 3 of 120x90, 1 of 60x45.
//!
//! # Source
//! EventHands, slow-motion mode: 1 ms, and more than 10 events in the program, 10 or more in the
//! supplement. There the time of the first representation counts from zero, here from the first
//! event.

use evpose_core::{Micros, SensorSize};
use serde::{Deserialize, Serialize};

/// How often a [`RepresentationTrigger`] fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriggerConfig {
    /// Minimum time between representations, in microseconds.
    // The card of the shipped `hand-quick` spells it so.
    #[serde(alias = "least_interval_us")]
    pub min_interval_us: u32,
    /// Minimum number of new events between representations of 240x180 pixels; scaled with the
    /// number of pixels for other sizes.
    #[serde(alias = "least_events")]
    pub min_events: u32,
}

impl TriggerConfig {
    /// The published program: more than 10 events.
    pub const PROGRAM: Self = Self { min_interval_us: 1_000, min_events: 11 };

    /// Minimum number of new events for `sensor`; at least 1.
    pub fn min_events_of(&self, sensor: SensorSize) -> u64 {
        let published = SensorSize::DAVIS240C.pixels() as u64;
        (u64::from(self.min_events) * sensor.pixels() as u64).div_ceil(published).max(1)
    }
}

impl Default for TriggerConfig {
    fn default() -> Self {
        Self::PROGRAM
    }
}

/// Watches the times of a stream's events and says when a representation is due.
#[derive(Debug, Clone)]
pub struct RepresentationTrigger {
    min_interval: Micros,
    min_events: u64,
    /// Time of the last representation; of the first event before there was one.
    since: Option<Micros>,
    last_event: Option<Micros>,
    new_events: u64,
}

impl RepresentationTrigger {
    /// A trigger for the events of `sensor`.
    pub fn new(config: &TriggerConfig, sensor: SensorSize) -> Self {
        Self {
            min_interval: Micros(config.min_interval_us.into()),
            min_events: config.min_events_of(sensor),
            since: None,
            last_event: None,
            new_events: 0,
        }
    }

    /// The earliest time at which a representation can be due; none before the first event.
    pub fn earliest(&self) -> Option<Micros> {
        Some(self.since? + self.min_interval)
    }

    /// Takes events by their ascending times until a representation is due, and returns how many
    /// that were: the representation shows these, at the time of the last of them. None if all were
    /// taken and no representation is due. To be called again with the rest.
    ///
    /// A stream may be cut anywhere but between events of one microsecond. Times before the last
    /// event taken mean that the stream started again, and so does the trigger.
    pub fn due(&mut self, times: &[Micros]) -> Option<usize> {
        let first = *times.first()?;
        if self.last_event.is_some_and(|last| first < last) {
            self.reset();
        }
        let since = *self.since.get_or_insert(first);
        let mut taken = 0;
        // Events of one microsecond have no order among themselves: all are shown, or none.
        for together in times.chunk_by(|a, b| a == b) {
            let now = together[0];
            taken += together.len();
            self.last_event = Some(now);
            self.new_events += together.len() as u64;
            let waited_us = now.0.saturating_sub(since.0);
            if waited_us >= self.min_interval.0 && self.new_events >= self.min_events {
                self.since = Some(now);
                self.new_events = 0;
                return Some(taken);
            }
        }
        None
    }

    /// Forgets every event and representation.
    pub fn reset(&mut self) {
        (self.since, self.last_event, self.new_events) = (None, None, 0);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn trigger(config: TriggerConfig) -> RepresentationTrigger {
        RepresentationTrigger::new(&config, SensorSize::DAVIS240C)
    }

    /// The times at which representations are due, the stream cut as it comes in `packets`.
    fn due_us(trigger: &mut RepresentationTrigger, packets: &[Vec<Micros>]) -> Vec<i64> {
        let mut out = Vec::new();
        for packet in packets {
            let mut from = 0;
            while let Some(taken) = trigger.due(&packet[from..]) {
                from += taken;
                out.push(packet[from - 1].0);
            }
        }
        out
    }

    fn every(step_us: i64, count: i64) -> Vec<Micros> {
        (0..count).map(|k| Micros(k * step_us)).collect()
    }

    /// 20 events a millisecond: time decides. One in 250 µs: events do.
    #[test]
    fn a_representation_needs_a_millisecond_and_eleven_events() {
        let dense = due_us(&mut trigger(TriggerConfig::PROGRAM), &[every(50, 101)]);
        assert_eq!(dense, [1_000, 2_000, 3_000, 4_000, 5_000]);
        let sparse = due_us(&mut trigger(TriggerConfig::PROGRAM), &[every(250, 33)]);
        assert_eq!(sparse, [2_500, 5_250, 8_000]);
        let supplement = due_us(
            &mut trigger(TriggerConfig { min_events: 10, ..TriggerConfig::PROGRAM }),
            &[every(250, 30)],
        );
        assert_eq!(supplement, [2_250, 4_750, 7_250]);
    }

    #[test]
    fn events_of_one_time_are_shown_together() {
        let mut frames = vec![Micros(0); 30];
        frames.extend([Micros(1_000); 30]);
        frames.extend([Micros(2_000); 5]);
        let mut trigger = trigger(TriggerConfig::PROGRAM);
        assert_eq!(trigger.due(&frames), Some(60));
        assert_eq!(trigger.due(&frames[60..]), None);
        assert_eq!(trigger.due(&[Micros(2_500); 6]), Some(6));
    }

    #[test]
    fn fewer_pixels_need_fewer_events_and_one_at_least() {
        let config = TriggerConfig::PROGRAM;
        let least = |width, height| config.min_events_of(SensorSize { width, height });
        assert_eq!([least(240, 180), least(120, 90), least(60, 45), least(3, 2)], [11, 3, 1, 1]);
        assert_eq!(least(480, 360), 44);
    }

    #[test]
    fn silence_has_no_representations_and_time_that_jumps_back_starts_anew() {
        let mut trigger = trigger(TriggerConfig::PROGRAM);
        assert_eq!(trigger.due(&[]), None);
        let packets = [vec![Micros(90_000); 10], every(100, 22)];
        assert_eq!(due_us(&mut trigger, &packets), [1_000, 2_100]);
    }

    proptest! {
        #[test]
        fn how_a_stream_is_cut_does_not_matter(
            gaps in prop::collection::vec(1i64..400, 1..200), cut in 1usize..40,
        ) {
            let times: Vec<Micros> = gaps
                .iter()
                .scan(0, |t, gap| { *t += gap; Some(Micros(*t)) })
                .collect();
            let whole = due_us(&mut trigger(TriggerConfig::PROGRAM), std::slice::from_ref(&times));
            let packets: Vec<Vec<Micros>> = times.chunks(cut).map(<[Micros]>::to_vec).collect();
            prop_assert_eq!(whole, due_us(&mut trigger(TriggerConfig::PROGRAM), &packets));
        }
    }
}
