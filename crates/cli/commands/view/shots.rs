//! Pictures of a recording at moments that lie evenly in time.

use anyhow::{Context, Result, ensure};
use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::{SensorOrigin, Windows};
use evpose_repr::{ChannelOrder, StreamWindow, representation_called};
use image::RgbImage;

use super::ViewArgs;
use super::picture::Palette;
use crate::progress::bar;

/// What plain events are drawn as.
const EVENTS: &str = "events";

/// One picture.
pub(super) struct Shot {
    /// What happened up to here, after the first event of the recording.
    pub(super) t: Micros,
    /// Events since the picture before.
    pub(super) events: usize,
    pub(super) image: RgbImage,
}

/// All of them.
pub(super) struct Shots {
    pub(super) name: String,
    pub(super) sensor: SensorSize,
    /// From one to the next.
    pub(super) every: Micros,
    /// The time of the first event, as the file counts.
    pub(super) origin: Micros,
    pub(super) shots: Vec<Shot>,
    pub(super) warnings: Vec<String>,
}

impl Shots {
    /// Reads the recording up to the last picture.
    pub(super) fn take(args: &ViewArgs, pictures: u32) -> Result<Self> {
        let input = &args.recording.input;
        let options = args.recording.opening.options();
        let mut windows = Windows::open(input, &options)?;
        let origin = windows.start().with_context(|| format!("{}: no events", input.display()))?;
        let sensor = windows.sensor();
        let mut warnings = Vec::new();
        if windows.sensor_origin() == SensorOrigin::Inferred {
            warnings.push(format!(
                "the file does not state its sensor: {sensor} holds its first events; --sensor says \
                 what it was"
            ));
        }
        let (start, end) = span(args, origin, &mut windows)?;
        let every = Micros(((end.0 - start.0) / i64::from(pictures)).max(1));
        let length = Micros::from_seconds(args.window_ms * 1e-3);
        let window = StreamWindow::new(sensor, length, ChannelOrder::OffFirst)?;
        let name = if args.of == EVENTS { "lnes" } else { &args.of };
        let representation = representation_called(name)?;
        let mut representation = representation.start(window);
        let mut planes = vec![0.0; representation.channels() * sensor.pixels()];
        let palette = Palette { sensor, is_events: args.of == EVENTS };
        let mut events = EventStream::empty(sensor);
        let progress = bar("pictures", u64::from(pictures), "pictures");
        let mut shots = Vec::new();
        // What the first picture shows began before it.
        let mut read_to = Micros(start.0 - length.0);
        for k in 1..=i64::from(pictures) {
            let t = Micros(start.0 + k * every.0);
            windows.read(TimeWindow { start: read_to, end: t }, &mut events)?;
            read_to = t;
            representation.push(&events);
            representation.advance(t);
            representation.render(&mut planes);
            let image = palette.draw(&planes);
            shots.push(Shot { t: t - origin, events: events.len(), image });
            progress.inc(1);
        }
        progress.finish_and_clear();
        let outside = windows.rejected().outside_sensor;
        if outside > 0 {
            warnings.push(format!("{outside} events lie outside the sensor: not shown"));
        }
        warnings.extend(windows.remarks());
        let name = input.file_name().unwrap_or(input.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, sensor, every, origin, shots, warnings })
    }

    /// What there is, in words.
    pub(super) fn summary(&self) -> String {
        let last = self.shots.last().map_or(Micros(0), |shot| shot.t);
        format!(
            "{} pictures, one every {:.3} ms up to {:.3} s",
            self.shots.len(),
            self.every.0 as f64 * 1e-3,
            last.as_seconds()
        )
    }
}

/// The time shown.
fn span(args: &ViewArgs, origin: Micros, windows: &mut Windows) -> Result<(Micros, Micros)> {
    let after = |seconds: f64| Micros(origin.0.saturating_add(Micros::from_seconds(seconds).0));
    let start = after(args.from.max(0.0));
    let end = match args.to {
        Some(to) => after(to),
        None => Micros(windows.end()?.0.saturating_add(1)),
    };
    ensure!(start < end, "--from lies behind the end of what is shown");
    ensure!(!windows.is_over_at(start)?, "--from lies behind the last event");
    Ok((start, end))
}
