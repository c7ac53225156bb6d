//! Detection of swapped or mirrored axes and inverted polarity, by a reference recording.

use std::path::Path;

use anyhow::{Result, bail};
use evpose_clean::symmetry::{Symmetry, find as find_symmetry};
use evpose_core::{Event, EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::open;

use super::passes::Passes;
use crate::commands::account::Account;
use crate::progress::say;

/// Length of the compared part of the reference, the maximum of the method.
const LENGTH: Micros = Micros(5_000_000);

/// The transform that corrects the recording, where it is unambiguous.
pub(super) fn find(
    passes: &Passes,
    sensor: SensorSize,
    reference: &Path,
) -> Result<Option<Symmetry>> {
    let wanted = open(reference)?;
    Account::from_recording(&wanted).print();
    let wanted = wanted.stream;
    // The reference begins somewhere in the recording: both are cut to its first stretch.
    let Some(&origin) = wanted.t().first() else {
        bail!("{}: no events to compare with", reference.display());
    };
    let window = TimeWindow { start: origin, end: origin + LENGTH };
    let mut seen = EventStream::empty(sensor);
    passes.read("comparing", |events| {
        let part = events.slice(window);
        seen.extend_columns(part.t(), part.x(), part.y(), part.polarity())?;
        Ok(())
    })?;
    let (seen, wanted) = (since(&seen, origin)?, since(&wanted.slice(window), origin)?);
    let Some(found) = find_symmetry(&seen, &wanted) else {
        bail!(
            "{}: too few events at the times of the recording, or a sensor that fits no way round",
            reference.display()
        );
    };
    let (score, as_it_is) = (found.score, found.as_it_is.unwrap_or(0.0));
    let scores = format!("likeness {score:.2}, as it is {as_it_is:.2}");
    if !found.is_clear {
        // The transform is used for all that follows, so that a guess would do harm.
        say(format!("axes      nothing speaks clearly against them as they are ({scores})"));
        return Ok(None);
    }
    say(format!("axes      {} ({scores})", found.best));
    for other in found.as_good {
        say(format!("axes      or, indistinguishable by this scene: {other}"));
    }
    Ok(Some(found.best))
}

fn since(events: &EventStream, origin: Micros) -> Result<EventStream> {
    let shifted = events.iter().map(|event| Event { t: event.t - origin, ..event });
    Ok(EventStream::from_events(events.sensor(), shifted)?)
}
