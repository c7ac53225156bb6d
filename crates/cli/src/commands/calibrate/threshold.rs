//! `evpose calibrate threshold`: contrast thresholds.

use anyhow::{Context, Result};
use evpose_camera::calibrate::threshold::ThresholdRun;
use evpose_core::{Micros, Plane};
use evpose_sensor::EffectConfig;

use super::args::ThresholdArgs;
use super::{interval_text, read, write};
use crate::progress::{bar, say};

/// Offset of the logarithm, relative to white, as in the `ideal` preset.
const DARK_OFFSET: f64 = 1e-3;

pub(super) fn run(args: &ThresholdArgs) -> Result<()> {
    let mut options = args.opening.options(&args.events)?;
    let mut source = args.frames.open(&options)?;
    // Images of a recording are on the clock of its events, which then stays as it is.
    let start = source.start().filter(|_| args.frames.fps.is_none());
    options.zero_time &= start.is_none();
    let start_s = start.map_or(0.0, Micros::as_seconds);
    let (fps, times_s) = match args.frames.stated_times(&source)? {
        Some(times_s) => {
            let fps = (times_s.len() as f64 - 1.0) / times_s.last().copied().unwrap_or(0.0);
            (fps, Some(times_s.iter().map(|time_s| start_s + time_s).collect()))
        }
        None => (args.frames.rate()?, None),
    };
    let events = read(&args.events, source.size(), &options)?;
    let mut run = ThresholdRun::new(source.size(), fps, args.floor, &events)
        .with_context(|| format!("{}, {}", args.frames.frames.display(), args.events.display()))?;
    if let Some(times_s) = times_s {
        run = run.at_times(times_s);
    }
    let mut frame = Plane::for_sensor(source.size(), 0.0);
    let progress = bar("events of", source.frames(), "frames");
    while source.next_into(&mut frame)? {
        run.push(&frame)?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let found = run
        .finish(args.seed)
        .with_context(|| format!("{}, {}", args.frames.frames.display(), args.events.display()))?;
    // Before words that a full output would lose it with.
    if let Some(path) = &args.out {
        let head = "Thresholds by `evpose calibrate threshold`, by steps.";
        let effects = vec![
            EffectConfig::new("logarithmic").with("dark_offset", DARK_OFFSET),
            EffectConfig::new("level_crossing")
                .with("threshold_on", found.by_steps_on.estimate)
                .with("threshold_off", found.by_steps_off.estimate),
        ];
        write(path, head, effects)?;
    }
    say(format!("seen      {} frames, {} ON and {} OFF events", found.frames, found.on, found.off));
    say("          threshold, change of log light [95 % interval]");
    say(format!("by steps  ON  {}", interval_text(found.by_steps_on, "ln")));
    say(format!("          OFF {}", interval_text(found.by_steps_off, "ln")));
    say(format!("by totals ON  {}", interval_text(found.by_totals_on, "ln")));
    say(format!("          OFF {}", interval_text(found.by_totals_off, "ln")));
    say(format!("          all {}", interval_text(found.by_totals, "ln")));
    // Totals divide all change by all events: noise lowers them, and lost events raise them.
    for (polarity, steps, totals) in [
        ("ON", found.by_steps_on.estimate, found.by_totals_on.estimate),
        ("OFF", found.by_steps_off.estimate, found.by_totals_off.estimate),
    ] {
        let (count, causes) = match totals / steps {
            ..0.8 => ("more", "noise, flicker, or frames that miss motion"),
            1.5.. => ("fewer", "dead time, a slow pixel, or light below it"),
            _ => continue,
        };
        say(format!("note      many {count} {polarity} events than light explains: {causes}"));
    }
    if let Some(path) = &args.out {
        say(format!("written to {}", path.display()));
    }
    Ok(())
}
