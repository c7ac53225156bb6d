//! Out-of-sequence measurements applied in the order of their event time stamps.

use std::collections::VecDeque;

use evpose_core::Micros;

use super::filter::{BodyEstimator, JointFilter, Measured, Track, pixels, seconds};
use super::{FusionConfig, FusionError};
use crate::body::{BODY_JOINTS, BodyPoints};

/// Applies every measurement at its place in time: the answer is that of measurements which all
/// came at once, bit for bit, as long as none is later than the history is long.
///
/// The state after each remembered measurement is kept, so that a late one costs as much as those
/// after it.
#[derive(Debug)]
pub(super) struct TimeOrder<F> {
    config: FusionConfig,
    /// The history in time order; of equal time stamps, velocities first.
    entries: VecDeque<Entry<F>>,
    /// The state before it, and its time if there ever was a measurement before.
    base: Tracks<F>,
    base_t: Option<Micros>,
}

type Tracks<F> = [Option<Track<F>>; BODY_JOINTS];

#[derive(Debug)]
struct Entry<F> {
    t: Micros,
    kind: Kind,
    measured: Measured,
    after: Tracks<F>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Velocity,
    Detection,
}

impl<F: JointFilter> TimeOrder<F> {
    pub(super) fn new(config: FusionConfig) -> Self {
        let base = [None; BODY_JOINTS];
        Self { config, entries: VecDeque::new(), base, base_t: None }
    }

    fn insert(&mut self, t: Micros, kind: Kind, measured: Measured) -> Result<(), FusionError> {
        if let Some(oldest) = self.base_t
            && t < oldest
        {
            return Err(FusionError::TooLate { t, oldest });
        }
        // Behind its equals, so that the order of arrival stays.
        let place = self.entries.partition_point(|entry| (entry.t, entry.kind) <= (t, kind));
        self.entries.insert(place, Entry { t, kind, measured, after: [None; BODY_JOINTS] });
        // What comes later is computed again from here.
        let mut tracks = self.before(place);
        for entry in self.entries.range_mut(place..) {
            entry.apply(&mut tracks, &self.config);
            entry.after = tracks;
        }
        self.forget();
        Ok(())
    }

    /// The state before entry number `place`.
    fn before(&self, place: usize) -> Tracks<F> {
        place.checked_sub(1).map_or(self.base, |last| self.entries[last].after)
    }

    /// Drops what is older than the history is long.
    fn forget(&mut self) {
        let Some(newest) = self.entries.back().map(|entry| entry.t) else { return };
        while let Some(entry) = self.entries.front()
            && seconds(entry.t, newest) > self.config.history_s
        {
            // Its state contains all measurements before it, which can no longer be reordered.
            (self.base, self.base_t) = (entry.after, Some(entry.t));
            self.entries.pop_front();
        }
    }
}

impl<F: JointFilter> Entry<F> {
    fn apply(&self, tracks: &mut Tracks<F>, config: &FusionConfig) {
        for (track, measured) in tracks.iter_mut().zip(self.measured) {
            let Some(measured) = measured else { continue };
            match (self.kind, &mut *track) {
                (Kind::Detection, Some(track)) if track.is_followed(self.t, config) => {
                    track.advance(self.t, config);
                    track.detect(measured, config);
                }
                // Never seen, or lost too long ago to be continued.
                (Kind::Detection, track) => *track = Some(Track::start(self.t, measured, config)),
                (Kind::Velocity, Some(track)) => {
                    let dt_s = track.advance(self.t, config);
                    track.filter.measure_velocity(measured, dt_s, config);
                }
                // A velocity has no position to move.
                (Kind::Velocity, None) => {}
            }
        }
    }
}

impl<F: JointFilter> BodyEstimator for TimeOrder<F> {
    fn detection(
        &mut self,
        described: Micros,
        positions_px: &Measured,
        now: Micros,
    ) -> Result<(), FusionError> {
        let t = if self.config.latency_compensation { described } else { now };
        self.insert(t, Kind::Detection, *positions_px)
    }

    fn velocity(&mut self, t: Micros, px_per_s: &Measured) -> Result<(), FusionError> {
        self.insert(t, Kind::Velocity, *px_per_s)
    }

    /// Also of the past, as far as it is remembered, from what was measured until then.
    fn query(&self, t: Micros) -> BodyPoints {
        let tracks = self.before(self.entries.partition_point(|entry| entry.t <= t));
        tracks.map(|track| {
            let track =
                track.filter(|track| track.at <= t && track.is_followed(t, &self.config))?;
            // A velocity is trusted for a while only: without a limit, lost joints would fly away.
            let ahead_s = seconds(track.at, t).min(self.config.extrapolation_limit_s);
            pixels(track.filter.position_px(ahead_s))
        })
    }
}
