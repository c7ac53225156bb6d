//! Frames of a recording at equidistant time stamps.

use std::cmp::Reverse;

use anyhow::{Context, Result, ensure};
use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::Windows;
use evpose_repr::{ChannelOrder, Representation, StreamWindow, representation_by_name};
use image::RgbImage;

use super::ViewArgs;
use super::key::Key;
use super::overlay::Overlay;
use super::palette::Palette;
use crate::progress::bar;

/// Name of plain events among the representations.
const EVENTS: &str = "events";
/// Joints and their scores are legible on frames of this width.
const JOINTS_WIDTH_PX: u32 = 640;

/// A recording that is ready to be shown.
pub(super) struct FrameReader {
    pub(super) name: String,
    pub(super) sensor: SensorSize,
    pub(super) every: Micros,
    /// The time of the first event, as the file counts.
    pub(super) origin: Micros,
    pub(super) palette: Palette,
    overlay: Overlay,
    frames: u32,
    start: Micros,
    /// How long an event is shown.
    length: Micros,
    windows: Windows,
    representation: Box<dyn Representation>,
}

/// Events and representation of a frame.
pub(super) struct FrameData<'a> {
    /// After the first event of the recording.
    pub(super) t: Micros,
    pub(super) events: &'a EventStream,
    /// The representation, for [`Palette`].
    pub(super) planes: &'a [f32],
}

impl FrameReader {
    pub(super) fn open(args: &ViewArgs, frames: u32) -> Result<Self> {
        let input = &args.recording.input;
        let options = args.recording.opening.options_with_sensor(&args.recording.input)?;
        let mut windows = Windows::open(input, &options)?;
        let origin = windows.start().with_context(|| format!("{}: no events", input.display()))?;
        let sensor = windows.sensor();
        let (start, end) = span(args, origin, &mut windows)?;
        // It is never 0, or more frames than microseconds would all end at one time.
        let every = Micros(((end.0 - start.0) / i64::from(frames)).max(1));
        let length = Micros::from_seconds(args.window_ms * 1e-3);
        let window = StreamWindow::new(sensor, length, ChannelOrder::OffFirst)?;
        let is_events = args.of == EVENTS;
        let representation = representation_by_name(if is_events { "lnes" } else { &args.of })?;
        let representation = representation.start(window);
        let overlay = Overlay::open(args)?;
        let palette = Palette::new(sensor, is_events);
        // Joints need room: small sensors are enlarged.
        let palette =
            if overlay.has_joints() { palette.at_least(JOINTS_WIDTH_PX) } else { palette };
        let name = input.file_name().unwrap_or(input.as_os_str()).to_string_lossy().into_owned();
        Ok(Self {
            name,
            sensor,
            every,
            origin,
            palette,
            overlay,
            frames,
            start,
            length,
            windows,
            representation,
        })
    }

    /// Reads the recording up to the last frame, and passes the data of each to `show`.
    pub(super) fn play(
        &mut self,
        mut show: impl FnMut(&FrameData<'_>) -> Result<()>,
    ) -> Result<()> {
        let mut planes = vec![0.0; self.representation.channels() * self.sensor.pixels()];
        let mut events = EventStream::empty(self.sensor);
        let progress = bar("frames", u64::from(self.frames), "frames");
        // What the first frame shows began before it.
        let mut read_to = Micros(self.start.0 - self.length.0);
        for k in 1..=i64::from(self.frames) {
            let t = Micros(self.start.0 + k * self.every.0);
            self.windows.read(TimeWindow { start: read_to, end: t }, &mut events)?;
            self.representation.push(&events);
            self.representation.advance(t);
            self.representation.render(&mut planes);
            // Events before the start only fill the representation, and do not count.
            if read_to < self.start {
                events = events.slice(TimeWindow { start: self.start, end: t });
            }
            read_to = t;
            show(&FrameData { t: t - self.origin, events: &events, planes: &planes })?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Anomalies of the recording, as far as it was read.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let outside = self.windows.outside();
        if outside > 0 {
            warnings.push(format!("{outside} events lie outside the sensor: not shown"));
        }
        warnings.extend(self.windows.remarks());
        warnings
    }

    /// Number and spacing of the frames, as text.
    pub(super) fn summary(&self) -> String {
        let last = Micros(self.start.0 + i64::from(self.frames) * self.every.0) - self.origin;
        format!(
            "{} frames, one every {:.3} ms up to {:.3} s",
            self.frames,
            self.every.0 as f64 * 1e-3,
            last.as_seconds()
        )
    }
}

pub(super) struct RenderedFrame {
    /// End of the frame's window, after the first event of the recording.
    pub(super) t: Micros,
    pub(super) events: usize,
    pub(super) image: RgbImage,
}

/// All of them, for files that hold them together.
pub(super) struct RenderedFrames {
    pub(super) reader: FrameReader,
    pub(super) frames: Vec<RenderedFrame>,
    /// Meanings of the colours.
    pub(super) keys: Vec<Key>,
}

impl RenderedFrames {
    pub(super) fn take(mut reader: FrameReader) -> Result<Self> {
        let mut frames = Vec::new();
        let (palette, origin) = (reader.palette, reader.origin);
        // The overlay leaves the reader, all of which `play` borrows.
        let overlay = std::mem::take(&mut reader.overlay);
        // Two planes are drawn as polarities.
        let keys = overlay.keys(reader.representation.channels() == 2);
        reader.play(|data| {
            let image = palette.draw(data.planes);
            let image = overlay.draw(image, palette.scale(), data.t + origin)?;
            frames.push(RenderedFrame { t: data.t, events: data.events.len(), image });
            Ok(())
        })?;
        Ok(Self { reader, frames, keys })
    }

    /// The frame to begin with: the one that shows most events.
    ///
    /// Those of the first one do not count: simulated recordings begin with a burst of all pixels.
    pub(super) fn busiest(&self) -> usize {
        // A window that is longer than the spacing shows the events of several frames.
        let shown = ((self.reader.length.0 - 1) / self.reader.every.0 + 1) as usize;
        let events = |k: usize| -> usize {
            let first = (k + 1).saturating_sub(shown).max(1);
            self.frames.get(first..=k).into_iter().flatten().map(|frame| frame.events).sum()
        };
        (0..self.frames.len()).max_by_key(|&k| (events(k), Reverse(k))).unwrap_or(0)
    }

    /// The most events of a frame, the first one aside if there are others with any.
    pub(super) fn max_events(&self) -> usize {
        let (first, others) = self
            .frames
            .split_first()
            .map_or((0, [].as_slice()), |(first, others)| (first.events, others));
        others.iter().map(|frame| frame.events).max().filter(|&most| most > 0).unwrap_or(first)
    }
}

/// The time shown.
fn span(args: &ViewArgs, origin: Micros, windows: &mut Windows) -> Result<(Micros, Micros)> {
    let after = |seconds: f64| Micros(origin.0.saturating_add(Micros::from_seconds(seconds).0));
    let start = after(args.from.max(0.0));
    let end = match args.to {
        Some(to) => after(to),
        // A window excludes its end, and the last event counts.
        None => Micros(windows.end()?.0.saturating_add(1)),
    };
    ensure!(start < end, "--from lies behind the end of what is shown");
    ensure!(!windows.is_over_at(start)?, "--from lies behind the last event");
    Ok((start, end))
}
