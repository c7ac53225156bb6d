//! `evpose calibrate noise`: noise rates and hot pixels.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use evpose_camera::calibrate::noise::{HOT, HotPixelRate, Motion, noise};
use evpose_core::{Micros, TimeWindow};
use evpose_sensor::EffectConfig;

use super::args::NoiseArgs;
use super::{interval_text, write};
use crate::commands::account::Account;
use crate::outputs::write_file;
use crate::progress::say;

/// Number of printed hot pixels.
const SHOWN: usize = 5;
/// Shorter recordings hardly show rates of single pixels below one event a second.
const RECOMMENDED_S: f64 = 1.0;
/// From here on the scene was hardly at rest.
const RESTLESS: f64 = 2.0;

pub(super) fn run(args: &NoiseArgs) -> Result<()> {
    let options = args.opening.options_with_sensor(&args.events)?;
    let recording = evpose_io::open_as(&args.events, &options)?;
    Account::from_recording(&recording).print();
    let events = recording.stream;
    let (Some(first), Some(last)) = (events.t().first(), events.t().last()) else {
        anyhow::bail!("{}: no events", args.events.display());
    };
    // Time before the first event is no part of a recording whose clock began elsewhere.
    let start = if first.as_seconds() < 1.0 { Micros(0) } else { *first };
    // A window excludes its end, and the last event counts.
    let window =
        TimeWindow { start: start + Micros::from_seconds(args.skip), end: *last + Micros(1) };
    anyhow::ensure!(
        args.skip >= 0.0 && window.start < window.end,
        "--skip {}: {} lasts {:.3} s",
        args.skip,
        args.events.display(),
        (*last - start).as_seconds()
    );
    let found = noise(&events, window, args.seed).with_context(|| match args.skip > 0.0 {
        true => format!("{} behind --skip {}", args.events.display(), args.skip),
        false => args.events.display().to_string(),
    })?;
    // Before words that a full output would lose them with.
    if let Some(path) = &args.out {
        let head = "Background by `evpose calibrate noise`, without hot pixels.";
        let rates = EffectConfig::new("uniform_noise")
            .with("on_hz", found.on_hz.estimate)
            .with("off_hz", found.off_hz.estimate);
        write(path, head, vec![rates])?;
    }
    if let Some(path) = &args.hot {
        let mut table = "x,y,on_hz,off_hz\n".to_owned();
        for HotPixelRate { x, y, on_hz, off_hz } in &found.hot {
            writeln!(table, "{x},{y},{on_hz:.4},{off_hz:.4}")?;
        }
        write_file(path, table)?;
    }
    let size = events.sensor();
    say(format!(
        "seen      {:.2} s of {size}, {} events",
        found.seconds,
        events.range(window).len()
    ));
    say("          rate of a pixel, without hot ones [95 % interval]; rate of the whole image");
    say(format!(
        "ON        {}; {:.0} per second",
        interval_text(found.on_hz, "Hz"),
        found.all_on_hz
    ));
    say(format!(
        "OFF       {}; {:.0} per second",
        interval_text(found.off_hz, "Hz"),
        found.all_off_hz
    ));
    say(format!(
        "hot       {} of {} pixels have clearly more than {HOT} times the events of others",
        found.hot.len(),
        size.pixels()
    ));
    for HotPixelRate { x, y, on_hz, off_hz } in found.hot.iter().take(SHOWN) {
        say(format!("          ({x}, {y}): {on_hz:.1} Hz ON, {off_hz:.1} Hz OFF"));
    }
    if found.seconds < RECOMMENDED_S {
        say(format!(
            "note      {:.2} s are short: hot pixels of low rates do not show, a minute is better",
            found.seconds
        ));
    }
    if found.unrest > RESTLESS {
        say(format!(
            "note      the busiest twentieth of time has {:.1} times the mean: was all at rest?",
            found.unrest
        ));
    }
    if let Some(Motion { seconds, columns, rows, times }) = found.motion {
        say(format!(
            "note      something moved: from {:.2} to {:.2} s, columns {} to {} and rows {} to {} have \
             {times:.0} times their events at rest",
            args.skip + seconds[0],
            args.skip + seconds[1],
            columns[0],
            columns[1],
            rows[0],
            rows[1]
        ));
    }
    for path in [&args.out, &args.hot].into_iter().flatten() {
        say(format!("written to {}", path.display()));
    }
    Ok(())
}
