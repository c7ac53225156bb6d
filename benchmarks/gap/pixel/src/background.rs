//! Events that no light causes: Poisson background and hot pixels. The pixel's memory does not
//! know.

use crate::circuit::{Background, HotPixels};
use crate::draw::{Purpose, Stream};
use crate::event::{HEIGHT, Spike, WIDTH};
use crate::pixel::Seeds;

/// Background events of one pixel up to `duration_s`.
pub fn background_spikes(
    background: &Background,
    seeds: Seeds,
    pixel: u32,
    duration_s: f64,
) -> Vec<Spike> {
    let mut spikes = Vec::new();
    // Both polarities have streams of their own: one's rate does not move the other's events.
    let polarities = [
        (background.on_hz, Purpose::BackgroundOn, true),
        (background.off_hz, Purpose::BackgroundOff, false),
    ];
    for (rate_hz, purpose, on) in polarities {
        let stream = Stream::new(seeds.run, purpose, u64::from(pixel));
        poisson(stream, rate_hz, duration_s, |t_s, _| spikes.push(Spike { t_s, pixel, on }));
    }
    if let Some(rate_hz) = background.hot.and_then(|hot| hot_rate_hz(&hot, seeds.camera, pixel)) {
        let on_share = Stream::new(seeds.camera, Purpose::HotMap, u64::from(pixel)).uniform(2);
        let stream = Stream::new(seeds.run, Purpose::HotEvents, u64::from(pixel));
        // Another stream: in the first, draw `index` is the interval before the event.
        let polarity = Stream::new(seeds.run ^ 1, Purpose::HotEvents, u64::from(pixel));
        poisson(stream, rate_hz, duration_s, |t_s, index| {
            spikes.push(Spike { t_s, pixel, on: polarity.uniform(index) < on_share });
        });
    }
    spikes
}

/// Rate of a hot pixel, `None` for a sound one. At least one pixel of the sensor is hot.
fn hot_rate_hz(hot: &HotPixels, camera_seed: u64, pixel: u32) -> Option<f64> {
    let stream = Stream::new(camera_seed, Purpose::HotMap, u64::from(pixel));
    let pixels = (WIDTH * HEIGHT) as f64;
    let chosen = Stream::new(camera_seed, Purpose::HotMap, u64::MAX).bits(0);
    // One pixel is hot in any case, so that the effect is never absent.
    let first = u64::from(pixel) == chosen % (WIDTH * HEIGHT) as u64;
    (first || stream.uniform(0) < (hot.count - 1.0) / pixels)
        .then(|| hot.median_hz * (hot.spread_ln * stream.normal(1)).exp())
}

fn poisson(stream: Stream, rate_hz: f64, duration_s: f64, mut event: impl FnMut(f64, u64)) {
    if rate_hz <= 0.0 {
        return;
    }
    let mut t_s = 0.0;
    for index in 0.. {
        // Intervals of a Poisson process are exponential, so that no time is stepped through.
        t_s += stream.exponential(index) / rate_hz;
        if t_s >= duration_s {
            return;
        }
        event(t_s, index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEDS: Seeds = Seeds { camera: 8, run: 9 };

    #[test]
    fn background_events_come_at_their_rates() {
        let background = Background { on_hz: 2.0, off_hz: 0.5, hot: None };
        let spikes: Vec<Spike> =
            (0..4000).flat_map(|pixel| background_spikes(&background, SEEDS, pixel, 1.0)).collect();
        let on = spikes.iter().filter(|spike| spike.on).count() as f64;
        let off = spikes.len() as f64 - on;
        // Four standard deviations of the Poisson counts 8000 and 2000.
        assert!((on - 8000.0).abs() < 4.0 * 8000.0_f64.sqrt());
        assert!((off - 2000.0).abs() < 4.0 * 2000.0_f64.sqrt());
    }

    #[test]
    fn as_many_pixels_are_hot_as_expected_and_the_same_ones_in_every_run() {
        let hot = HotPixels { count: 20.0, median_hz: 50.0, spread_ln: 0.5 };
        let map = |camera| -> Vec<u32> {
            (0..(WIDTH * HEIGHT) as u32)
                .filter(|&p| hot_rate_hz(&hot, camera, p).is_some())
                .collect()
        };
        let count = map(8).len() as f64;
        assert!((count - 20.0).abs() < 4.0 * 20.0_f64.sqrt());
        assert_eq!(map(8), map(8));
        assert_ne!(map(8), map(9));
    }
}
