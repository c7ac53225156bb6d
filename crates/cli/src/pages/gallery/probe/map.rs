//! Maps over the sensor: differences between pixels, and positions.

use anyhow::Result;
use evpose_core::{Event, Micros};

use super::{GREY, Shown, Variant};
use crate::pages::gallery::bench::Scene;
use crate::pages::gallery::event_image;

fn counts(events: &[Event], width: usize, pixels: usize) -> Vec<f64> {
    let mut counts = vec![0.0; pixels];
    for event in events {
        counts[usize::from(event.y) * width + usize::from(event.x)] += 1.0;
    }
    counts
}

/// Light of the whole image goes up and down five times.
pub(super) fn ramps(variants: &[Variant], seed: u64) -> Result<Shown> {
    let light = |_: usize, _: usize, t_s: f64| {
        let turn = 25.0 * t_s % 1.0;
        GREY * (2.0 * (1.0 - (2.0 * turn - 1.0).abs())).exp()
    };
    let scene = Scene { size: (90, 68), steps: 200, step_us: 1_000, light };
    let mut maps = Vec::new();
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        maps.push(counts(&events, 90, scene.size().pixels()));
    }
    // 2 / 0.2 events ten times over.
    let images = maps.iter().map(|map| event_image::map(map, 90, (0.0, 200.0))).collect();
    let what = "Events of each pixel while all see the same light go up and down five times: the \
                ideal sensor has 100; black none, white 200 or more.";
    Ok(Shown::Images(what.to_owned(), images))
}

/// A second without any change.
pub(super) fn rest(variants: &[Variant], seed: u64) -> Result<Shown> {
    let scene = Scene { size: (90, 68), steps: 2_000, step_us: 500, light: |_, _, _| GREY };
    let (mut maps, mut longest_s) = (Vec::new(), 0.0_f64);
    for variant in variants {
        let (events, seconds) = scene.rest(&variant.model, seed)?;
        longest_s = seconds.max(longest_s);
        let mut map = counts(&events, 90, scene.size().pixels());
        // A hot pixel has thousands of times the events of its neighbours.
        map.iter_mut().for_each(|count| *count = count.ln_1p());
        maps.push(map);
    }
    // Not below 1: without any event, the map would be divided by zero.
    let high = maps.iter().flatten().copied().fold(0.0, f64::max).max(1.0);
    let images = maps.iter().map(|map| event_image::map(map, 90, (0.0, high))).collect();
    let what = format!(
        "Events of each pixel of a grey scene in {longest_s:.1} s: black none, white {:.0}, logarithmic in \
         between.",
        high.exp_m1()
    );
    Ok(Shown::Images(what, images))
}

/// Straight bright lines that appear.
pub(super) fn grid(variants: &[Variant], seed: u64) -> Result<Shown> {
    const PITCH: usize = 27;
    let light = |x: usize, y: usize, t_s: f64| {
        let is_line = x % PITCH < 2 || y % PITCH < 2;
        // Pixels take the first light as their reference: lines come after it.
        if is_line && t_s > 0.0 { 3.0 * GREY } else { GREY }
    };
    let scene = Scene { size: (270, 203), steps: 1, step_us: 1_000, light };
    let mut images = Vec::new();
    for variant in variants {
        let events = scene.show(&variant.model, seed)?;
        images.push(event_image::events(&events, scene.size(), Micros(0)));
    }
    let what = "Events of a grid of straight lines that appears on 270 x 203 pixels.";
    Ok(Shown::Images(what.to_owned(), images))
}
