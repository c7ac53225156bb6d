//! Windows of a recording as planes, one after the other, in constant memory.

use anyhow::{Context, Result, ensure};
use evpose_camera::{Calibration, CalibrationSource, CanonicalView, ViewAdaptor};
use evpose_clean::{Denoise, DenoiseFilter};
use evpose_core::{Distortion, EventStream, LensCamera, Micros, Pinhole, SensorSize, TimeWindow};
use evpose_io::Windows;
use evpose_repr::{
    ChannelOrder, Memory, Representation, RepresentationChoice, StreamWindow,
    representation_by_name,
};
use glam::{DVec2, Vec2};

use super::RepresentArgs;
use crate::commands::account::Account;
use crate::progress::bar;

/// Event time that is read at once.
const STEP: Micros = Micros(20_000);
/// Maximal count of windows: one every millisecond for 2.7 hours.
const MAX_WINDOWS: u64 = 10_000_000;
/// Neighbours that must confirm an event.
const NEIGHBOURS: u8 = 2;

/// Times of the windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Schedule {
    pub(super) count: u64,
    pub(super) length: Micros,
    pub(super) every: Micros,
    /// Begin of the first window.
    start: Micros,
    /// End of what is shown: the last window may reach beyond it.
    end: Micros,
}

impl Schedule {
    /// The windows of `length` that show everything from `start` to `end`; at least one.
    fn new(start: Micros, end: Micros, length: Micros, every: Micros) -> Self {
        let behind_first = end.0.saturating_sub(start.0).saturating_sub(length.0).max(0) as u64;
        let count = behind_first.div_ceil(every.0 as u64) + 1;
        Self { count, length, every, start, end }
    }

    fn end_of(&self, k: u64) -> Micros {
        Micros(self.start.0 + self.length.0 + k as i64 * self.every.0)
    }
}

/// A recording that is ready to be represented.
pub(super) struct WindowReader {
    pub(super) schedule: Schedule,
    pub(super) choice: RepresentationChoice,
    pub(super) size: SensorSize,
    windows: Windows,
    /// Time stamp of the first event that the planes depend on.
    begin: Micros,
    adaptor: Option<ViewAdaptor>,
    denoise: Option<DenoiseFilter>,
    representation: Box<dyn Representation>,
}

impl WindowReader {
    pub(super) fn open(args: &RepresentArgs) -> Result<Self> {
        let choice = representation_by_name(&args.of)?;
        let time = |ms: f64| Micros::from_seconds(ms * 1e-3);
        let (length, every) = (time(args.window_ms), time(args.every_ms.unwrap_or(args.window_ms)));
        let mut windows = open_windows(args)?;
        let sensor = windows.sensor();
        let size = args.size.unwrap_or(sensor);
        ensure!(
            size.width <= sensor.width && size.height <= sensor.height,
            "--size {size}: the sensor is {sensor}, and events can be pooled but not enlarged"
        );
        let denoise = args.denoise;
        let denoise = denoise.map(|tau_ms| Denoise { tau_ms, neighbours: NEIGHBOURS }.start(size));
        let path = args.recording.input.display();
        let origin = windows.start().with_context(|| format!("{path}: no events"))?;
        let after = |s: f64| Micros(origin.0.saturating_add(Micros::from_seconds(s).0));
        let start = after(args.from);
        // A window excludes its end, and the last event counts.
        let behind = Micros(windows.end()?.0.saturating_add(1));
        let end = args.to.map_or(behind, |to| after(to).min(behind));
        ensure!(start < behind, "--from {}: the recording ends before", args.from);
        ensure!(start < end, "--from lies behind --to");
        let schedule = Schedule::new(start, end, length, every);
        ensure!(
            schedule.count <= MAX_WINDOWS,
            "{path}: {} windows, more than {MAX_WINDOWS}: choose a part with --from and --to, or a \
             longer --every-ms",
            schedule.count
        );
        let window = StreamWindow::new(size, length, ChannelOrder::OffFirst)?;
        // What remembers events, a denoiser too, has to see the recording from its first one.
        let remembers = choice.spec().memory != Memory::Window || denoise.is_some();
        let begin = if remembers { origin } else { start };
        let representation = choice.start(window);
        Ok(Self {
            schedule,
            choice,
            size,
            windows,
            begin,
            adaptor: (size != sensor).then(|| pooling(sensor, size)),
            denoise,
            representation,
        })
    }

    /// Passes the end and the planes of each window to `take`.
    pub(super) fn play(
        &mut self,
        mut take: impl FnMut(u64, Micros, &[f32]) -> Result<()>,
    ) -> Result<()> {
        let schedule = self.schedule;
        let mut planes = vec![0.0; self.choice.channels() * self.size.pixels()];
        let mut events = EventStream::empty(self.windows.sensor());
        let mut pooled = EventStream::empty(self.size);
        let progress = bar("windows", schedule.count, "windows");
        let mut read_to = self.begin;
        for k in 0..schedule.count {
            let end = schedule.end_of(k);
            while read_to < end.min(schedule.end) {
                // Steps are short, since a window may be longer than its events fit the memory.
                let window =
                    TimeWindow { start: read_to, end: (read_to + STEP).min(end).min(schedule.end) };
                self.windows.read(window, &mut events)?;
                read_to = window.end;
                let shown = match &mut self.adaptor {
                    Some(adaptor) => {
                        adaptor.push(&events, &mut pooled);
                        &mut pooled
                    }
                    None => &mut events,
                };
                if let Some(denoise) = &mut self.denoise {
                    denoise.apply(shown);
                }
                self.representation.push(shown);
            }
            // Representations show what is later than a length before, up to now.
            self.representation.advance(Micros(end.0 - 1));
            self.representation.render(&mut planes);
            take(k, end, &planes)?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Anomalies of the recording, as far as it was read.
    pub(super) fn account(&self) -> Account {
        Account::from_windows(&self.windows)
    }
}

/// Opens the recording.
fn open_windows(args: &RepresentArgs) -> Result<Windows> {
    let path = &args.recording.input;
    let options = args.recording.opening.options_with_sensor(path)?;
    Ok(Windows::open(path, &options)?)
}

/// A map of events from all of a sensor to all of a smaller image.
fn pooling(sensor: SensorSize, size: SensorSize) -> ViewAdaptor {
    let pixels = |size: SensorSize| DVec2::new(size.width.into(), size.height.into());
    let camera = LensCamera {
        // Over the focal length of 1 below, this maps the whole sensor to the whole image.
        focal_px: pixels(sensor) / pixels(size),
        principal_px: DVec2::ZERO,
        distortion: Distortion::default(),
    };
    let calibration =
        Calibration { sensor, camera, source: CalibrationSource::Guessed, note: None };
    let pinhole = Pinhole { focal_px: 1.0, principal_px: Vec2::ZERO };
    ViewAdaptor::new(&calibration, &CanonicalView { sensor: size, pinhole })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_show_everything_and_no_more_of_them_than_that_takes() {
        let count = |end, length, every| {
            Schedule::new(Micros(100), Micros(end), Micros(length), Micros(every)).count
        };
        assert_eq!(count(101, 50, 10), 1);
        assert_eq!(count(150, 50, 10), 1);
        assert_eq!(count(151, 50, 10), 2);
        assert_eq!(count(200, 50, 50), 2);
        assert_eq!(count(201, 50, 50), 3);
        let schedule = Schedule::new(Micros(100), Micros(200), Micros(50), Micros(10));
        assert_eq!(schedule.end_of(schedule.count - 1), Micros(200));
    }
}
