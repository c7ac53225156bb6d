//! A recording for the viewer.

use std::path::Path;

use evpose_core::{EventStream, Micros, SensorSize};
use re_sdk_types::archetypes::{EncodedImage, Points2D, Scalars};
use re_sdk_types::components::MediaType;

use crate::rerun::RerunError;
use crate::rerun::layout::{self, EVENT_IMAGE, POLARITIES};
use crate::rerun::output::Output;

/// Upper bound of the points of a frame, which the viewer draws without a delay.
const MAX_POINTS: usize = 100_000;

/// A recording of event images, events and rates, to a file or a viewer.
///
/// Dropped before [`finish`](Self::finish), a file does not appear.
pub struct RerunRecording {
    output: Output,
    counts: SendCounts,
}

/// Data of one time stamp.
#[derive(Debug, Clone, Copy)]
pub struct FrameContents<'a> {
    /// Event time since the first event of the recording.
    pub t: Micros,
    /// Time since the frame before.
    pub length: Micros,
    /// Events of that length.
    pub events: &'a EventStream,
    /// The event image of the sensor's size, as a PNG file.
    pub event_image: &'a [u8],
}

/// Counts of what was sent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SendCounts {
    /// Events that the rates count.
    pub events: u64,
    /// Events that are points: of frames with very many, every second, third, … event.
    pub points: u64,
}

impl RerunRecording {
    /// Begins the file `path`, which appears with [`finish`](Self::finish).
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, name: &str, sensor: SensorSize) -> Result<Self, RerunError> {
        Self::begin(Output::create(path, name, layout::recording_views())?, sensor)
    }

    /// Connects to the viewer at `address`, `HOST:PORT` or a URL; none is the viewer's default.
    ///
    /// # Errors
    /// If the address is malformed, or no viewer answers.
    pub fn connect(
        address: Option<&str>,
        name: &str,
        sensor: SensorSize,
    ) -> Result<Self, RerunError> {
        Self::begin(Output::connect(address, name, layout::recording_views())?, sensor)
    }

    fn begin(output: Output, sensor: SensorSize) -> Result<Self, RerunError> {
        layout::send(&output.stream, sensor)?;
        Ok(Self { output, counts: SendCounts::default() })
    }

    /// Sends the next frame.
    ///
    /// # Errors
    /// If the SDK refuses the data. Errors of the transport are returned by
    /// [`finish`](Self::finish).
    pub fn send(&mut self, frame: &FrameContents<'_>) -> Result<(), RerunError> {
        self.output.set_time(frame.t);
        let stream = &self.output.stream;
        let image = EncodedImage::new(frame.event_image.to_vec()).with_media_type(MediaType::png());
        stream.log(EVENT_IMAGE, &image)?;
        // The viewer is slow with many points: they are thinned evenly over both polarities.
        let every = frame.events.len().div_ceil(MAX_POINTS).max(1);
        for paths in &POLARITIES {
            let mut count = 0_u64;
            let mut points = Vec::new();
            for (k, event) in frame.events.iter().enumerate() {
                if event.polarity != paths.polarity {
                    continue;
                }
                count += 1;
                if k % every == 0 {
                    // Pixel 0 reaches from 0 to 1.
                    points.push((f32::from(event.x) + 0.5, f32::from(event.y) + 0.5));
                }
            }
            self.counts.events += count;
            self.counts.points += points.len() as u64;
            let points = Points2D::update_fields().with_positions(points);
            stream.log(paths.events, &points)?;
            // All events count, those that are not shown as well.
            let per_second = count as f64 / frame.length.as_seconds();
            stream.log(paths.rate, &Scalars::single(per_second))?;
        }
        Ok(())
    }

    /// Waits until everything has arrived, and gives a file its final name.
    ///
    /// # Errors
    /// If the file could not be written, or the connection was lost.
    pub fn finish(self) -> Result<SendCounts, RerunError> {
        self.output.finish()?;
        Ok(self.counts)
    }
}
