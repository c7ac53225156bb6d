//! A recording that is read in several passes.

use std::path::Path;

use anyhow::Result;
use evpose_core::{EventStream, Micros, TimeWindow};
use evpose_io::{OpenOptions, Recording, SensorOrigin, Windows, open_as};

use crate::commands::account::Account;
use crate::progress::spinner;

/// Event time of a batch.
const STEP: Micros = Micros(20_000);

/// Source of events.
pub(in crate::commands) enum Passes<'a> {
    Windows(&'a Path, OpenOptions),
    /// In memory: the size of its sensor is inferred from all events.
    Whole(Box<Recording>),
}

impl<'a> Passes<'a> {
    /// Reads the recording once, and decides whether it can be read in windows.
    pub(in crate::commands) fn open(
        path: &'a Path,
        options: OpenOptions,
    ) -> Result<(Self, Account)> {
        let mut windows = Windows::open(path, &options)?;
        // An inferred sensor is known only after the last event, too late for windows.
        if windows.sensor_origin() != SensorOrigin::Inferred && windows.start().is_some() {
            // Read to the end once: only then is it known whether windows give every event.
            windows.end()?;
            let is_assumed = windows.sensor_origin() == SensorOrigin::Assumed;
            let is_too_small = is_assumed && windows.outside() > 0;
            if !is_too_small {
                let account = Account::from_windows(&windows);
                return Ok((Self::Windows(path, options), account));
            }
        }
        let recording = open_as(path, &options)?;
        let account = Account::from_recording(&recording);
        Ok((Self::Whole(Box::new(recording)), account))
    }

    /// Calls `each` with batches of events in time order.
    pub(in crate::commands) fn read(
        &self,
        what: &str,
        mut each: impl FnMut(&mut EventStream) -> Result<()>,
    ) -> Result<()> {
        let progress = spinner();
        match self {
            Self::Whole(recording) => {
                progress.set_message(what.to_owned());
                // A clone, since stages change the events and other passes read them again.
                each(&mut recording.stream.clone())?;
            }
            Self::Windows(path, options) => {
                let mut windows = Windows::open(path, options)?;
                let mut events = EventStream::empty(windows.sensor());
                let mut seen = 0;
                let mut next = windows.start();
                while let Some(start) = next
                    && !windows.is_over_at(start)?
                {
                    let window = TimeWindow { start, end: start + STEP };
                    windows.read(window, &mut events)?;
                    seen += events.len();
                    progress.set_message(format!("{what}: {seen} events"));
                    each(&mut events)?;
                    // Over a silence of hours at once, instead of in windows without events.
                    next = Some(window.end.max(windows.next_after(window.end)));
                }
            }
        }
        progress.finish_and_clear();
        Ok(())
    }
}
