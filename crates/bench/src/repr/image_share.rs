//! The share of an image in the work of a stream: of all representations.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use evpose_cli::progress::say;
use evpose_core::stats::quantile::nearest_rank;
use evpose_core::{EventStream, Micros, SensorSize};
use evpose_repr::{REPRESENTATIONS, representation_by_name};
use serde::Serialize;

use super::{SENSORS, WINDOW, events, stream_window};
use crate::peer_bench::is_named;

/// Events are pushed as they come from a camera: in packets of a millisecond.
const PACKET: Micros = Micros::MILLISECOND;
/// The largest share that an image should have of an update, per cent.
const LIMIT_PERCENT: f64 = 5.0;

/// An image, and the update of the window that it shows.
#[derive(Debug, Serialize)]
pub(super) struct ImageShare {
    representation: &'static str,
    sensor: String,
    /// A window of events, packet by packet; the window before leaves.
    update_us: f64,
    /// The image behind it.
    image_us: f64,
    /// Of the update.
    image_percent: f64,
}

pub(super) fn are_named(words: &[String]) -> bool {
    names().any(|(name, sensor)| is_named(&case(name, sensor), words))
}

/// Times those that are named by `words`, and prints the results.
pub(super) fn measure(count: usize, passes: usize, words: &[String]) -> Result<Vec<ImageShare>> {
    let mut shares = Vec::new();
    for (name, sensor) in names().filter(|&(name, sensor)| is_named(&case(name, sensor), words)) {
        let share = measure_one(name, &events::wandering(sensor, count), passes)?;
        let ImageShare { update_us, image_us, image_percent, .. } = &share;
        let is_large = if *image_percent > LIMIT_PERCENT { ", more than 5 %" } else { "" };
        say(format!(
            "{:46} {image_percent:9.1} % of an update ({image_us:.0} of {update_us:.0} µs{is_large})",
            case(name, sensor)
        ));
        shares.push(share);
    }
    Ok(shares)
}

fn names() -> impl Iterator<Item = (&'static str, SensorSize)> {
    let of_sensor = |sensor| REPRESENTATIONS.iter().map(move |entry| (entry.name, sensor));
    SENSORS.into_iter().flat_map(of_sensor)
}

fn case(name: &str, sensor: SensorSize) -> String {
    format!("{name} image share {sensor}")
}

fn measure_one(name: &'static str, window: &EventStream, passes: usize) -> Result<ImageShare> {
    let sensor = window.sensor();
    let mut running = representation_by_name(name)?.start(stream_window(sensor)?);
    let mut planes = vec![0.0; running.channels() * sensor.pixels()];
    let (mut updates_s, mut images_s) = (Vec::new(), Vec::new());
    // The first pass fills the window; it is not timed.
    for pass in 0..=passes.max(1) {
        // Each pass is a window later: the events of the last one have to leave, as in a stream.
        let packets = packets(window, Micros(pass as i64 * WINDOW.0))?;
        let begin = Instant::now();
        packets.iter().for_each(|packet| running.push(packet));
        let updated = Instant::now();
        running.render(&mut planes);
        black_box(&planes);
        let drawn = Instant::now();
        if pass > 0 {
            updates_s.push((updated - begin).as_secs_f64());
            images_s.push((drawn - updated).as_secs_f64());
        }
    }
    let median_us = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        1e6 * nearest_rank(&times, 0.5)
    };
    let (update_us, image_us) = (median_us(updates_s), median_us(images_s));
    Ok(ImageShare {
        representation: name,
        sensor: sensor.to_string(),
        update_us,
        image_us,
        image_percent: 100.0 * image_us / update_us,
    })
}

/// The events of a window that begins at `start`, in packets.
fn packets(window: &EventStream, start: Micros) -> Result<Vec<EventStream>> {
    let mut packets = Vec::new();
    let mut rest = window.iter().peekable();
    let mut end = PACKET;
    while rest.peek().is_some() {
        let mut packet = EventStream::empty(window.sensor());
        while let Some(mut event) = rest.next_if(|event| event.t < end) {
            // Windows follow each other, while these events begin at 0.
            event.t = Micros(start.0 + event.t.0);
            packet.push(event)?;
        }
        // Empty packets as well: a camera sends them.
        packets.push(packet);
        end = Micros(end.0 + PACKET.0);
    }
    Ok(packets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_the_window_later_and_every_millisecond_another() {
        let window = events::wandering(SensorSize::DAVIS240C, 3000);
        let packets = packets(&window, WINDOW).unwrap();
        assert_eq!(packets.len(), 100);
        let all = packets.iter().flat_map(EventStream::iter);
        assert!(all.eq(window.iter().map(|mut event| {
            event.t = Micros(event.t.0 + WINDOW.0);
            event
        })));
    }

    #[test]
    fn every_representation_has_a_share_on_every_sensor_and_words_choose_among_them() {
        assert_eq!(measure(200, 1, &[]).unwrap().len(), 2 * REPRESENTATIONS.iter().count());
        let words = ["voxel-grid image share".to_owned(), "240x180".to_owned()];
        assert!(are_named(&words) && !are_named(&["update".to_owned()]));
        let shares = measure(200, 2, &words).unwrap();
        let [share] = shares.as_slice() else { panic!("{shares:?}") };
        assert_eq!(share.representation, "voxel-grid");
        let percent = 100.0 * share.image_us / share.update_us;
        assert!(share.image_us > 0.0 && (share.image_percent - percent).abs() < 1e-9);
    }
}
