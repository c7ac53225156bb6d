//! Events without a neighbour, which are noise, before they reach a representation.

use evpose_core::{EventStream, Micros, SensorSize};
use serde::{Deserialize, Serialize};

use crate::{Background, BackgroundOptions, Cleaner as _};

/// A filter of the view's events: an event stays where enough of the eight pixels around it fired
/// shortly before.
///
/// An EROS does not fade, so that noise fills it in the end however rare it is. Edges fire in
/// company, noise alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Denoise {
    /// How long an event confirms its neighbours, in milliseconds.
    pub tau_ms: f64,
    /// Neighbours that must have fired, 1 to 8.
    pub neighbours: u8,
}

impl Denoise {
    /// Whether the values make sense.
    pub fn is_valid(&self) -> bool {
        (0.001..=1e6).contains(&self.tau_ms) && (1..=8).contains(&self.neighbours)
    }

    /// The filter for events of a view.
    pub fn start(&self, view: SensorSize) -> DenoiseFilter {
        let options = BackgroundOptions {
            tau: Micros::from_seconds(1e-3 * self.tau_ms),
            neighbours: self.neighbours,
            ..BackgroundOptions::default()
        };
        DenoiseFilter(Background::new(view, options))
    }
}

/// A running [`Denoise`].
#[derive(Debug, Clone)]
pub struct DenoiseFilter(Background);

impl DenoiseFilter {
    /// Removes events without enough neighbours.
    ///
    /// # Panics
    /// If the events are of another view.
    pub fn apply(&mut self, events: &mut EventStream) {
        self.0.clean(events);
    }

    /// Forgets all events.
    pub fn reset(&mut self) {
        self.0.reset();
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{CounterRng, Event, Polarity};

    use super::*;

    const VIEW: SensorSize = SensorSize { width: 80, height: 60 };

    /// Noise of 1 Hz a pixel for a second, and a bar that moves at 50 pixels a second.
    fn scene() -> (EventStream, usize) {
        let mut rng = CounterRng::new(2, "denoise test", 0);
        let mut events: Vec<(i64, u16, u16, bool)> = (0..VIEW.pixels())
            .map(|_| {
                let t = 1_000 * rng.below(1_000) as i64;
                (t, rng.below(80) as u16, rng.below(60) as u16, false)
            })
            .collect();
        for step in 0..50 {
            for y in 15..45 {
                // The bar rests 20 ms in each column, and its rows fire one after the other.
                events.push((20_000 * step + 100 * i64::from(y), 10 + step as u16, y, true));
            }
        }
        events.sort_by_key(|event| event.0);
        let bar = events.iter().filter(|event| event.3).count();
        let event = |&(t, x, y, is_bar): &(i64, u16, u16, bool)| Event {
            t: Micros(t),
            x,
            y,
            polarity: if is_bar { Polarity::On } else { Polarity::Off },
        };
        (EventStream::from_events(VIEW, events.iter().map(event)).unwrap(), bar)
    }

    #[test]
    fn noise_goes_and_a_moving_edge_stays() {
        let (mut events, bar) = scene();
        let noise = events.len() - bar;
        Denoise { tau_ms: 20.0, neighbours: 2 }.start(VIEW).apply(&mut events);
        let kept_bar = events.polarity().iter().filter(|p| p.is_on()).count();
        let kept_noise = events.len() - kept_bar;
        assert!(kept_bar as f64 > 0.9 * bar as f64, "{kept_bar} of {bar}");
        // Eight neighbours of 1 Hz fire 0.16 times in 20 ms, so that 1 % of noise has two.
        assert!((kept_noise as f64) < 0.08 * noise as f64, "{kept_noise} of {noise}");
    }

    /// Eight pixels fire one after the other around one that fires last.
    fn ring(fired: usize, late_us: i64) -> EventStream {
        let around = [(1, 1), (2, 1), (3, 1), (1, 2), (3, 2), (1, 3), (2, 3), (3, 3)];
        let last = (2, 2, 1_000 + late_us);
        let before = around[..fired].iter().map(|(x, y)| (*x, *y, 1_000));
        let event = |(x, y, t)| Event { t: Micros(t), x, y, polarity: Polarity::On };
        EventStream::from_events(VIEW, before.chain([last]).map(event)).unwrap()
    }

    #[test]
    fn as_many_neighbours_confirm_for_as_long_as_was_asked_for() {
        for neighbours in 1..=8 {
            for fired in 0..=8 {
                for (late_us, is_late) in [(0, false), (2_500, false), (2_501, true)] {
                    let mut filter = Denoise { tau_ms: 2.5, neighbours }.start(VIEW);
                    let mut events = ring(fired, late_us);
                    filter.apply(&mut events);
                    let stays = events.iter().any(|event| (event.x, event.y) == (2, 2));
                    assert_eq!(stays, fired >= neighbours.into() && !is_late, "{fired}");
                    // After a reset, those from before do not confirm.
                    filter.reset();
                    let mut alone = ring(0, late_us);
                    filter.apply(&mut alone);
                    assert!(alone.is_empty());
                }
            }
        }
    }

    #[test]
    fn values_out_of_range_are_not_valid() {
        for (tau_ms, neighbours) in [(0.0, 2), (f64::NAN, 2), (10.0, 0), (10.0, 9)] {
            assert!(!Denoise { tau_ms, neighbours }.is_valid());
        }
        for (tau_ms, neighbours) in [(0.001, 1), (1e6, 8)] {
            assert!(Denoise { tau_ms, neighbours }.is_valid());
        }
    }
}
