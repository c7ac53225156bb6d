//! A recording on its way to the viewer.

use std::path::Path;
use std::time::Duration;

use evpose_core::{EventStream, Micros, SensorSize};
use re_sdk::sink::SinkFlushError;
use re_sdk::{RecordingStream, RecordingStreamBuilder, TimeCell};
use re_sdk_types::archetypes::{EncodedImage, Points2D, Scalars};
use re_sdk_types::components::MediaType;

use crate::RerunError;
use crate::layout::{self, PICTURE, SIDES, TIMELINE};
use crate::rrd_file::RrdFile;

/// The name under which the viewer keeps how its windows are arranged.
const APPLICATION: &str = "evpose";
/// Points of one picture, at most: the viewer draws so many without a pause.
const MOST_POINTS: usize = 100_000;
/// How long a viewer may take to answer at first.
const ANSWER: Duration = Duration::from_secs(10);

/// Pictures, events and rates over time, on their way to a file or a viewer.
///
/// Dropped before [`finish`](Self::finish), a file does not appear.
pub struct Recording {
    stream: RecordingStream,
    to: Destination,
    sent: Sent,
}

/// What the viewer gets at one time.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The sensor's time since the first event of the recording.
    pub t: Micros,
    /// Since the moment before.
    pub length: Micros,
    /// Events of that length.
    pub events: &'a EventStream,
    /// A picture of the sensor's size, as a PNG file.
    pub picture: &'a [u8],
}

/// How much the viewer got.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sent {
    /// Events that the rates count.
    pub events: u64,
    /// Events that are points: of a moment with very many, every second, third, … one.
    pub points: u64,
}

enum Destination {
    File(RrdFile),
    Viewer(String),
}

impl Recording {
    /// Begins the file `path`, which appears with [`finish`](Self::finish).
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, name: &str, sensor: SensorSize) -> Result<Self, RerunError> {
        let stream = builder(name).buffered()?;
        let file = RrdFile::create(path)?;
        stream.set_sink(Box::new(file.clone()));
        Self::begin(stream, Destination::File(file), sensor)
    }

    /// Connects to the viewer at `address`, `HOST:PORT` or a URL; none is the viewer's default.
    ///
    /// # Errors
    /// If the address is none, or nobody answers there.
    pub fn connect(
        address: Option<&str>,
        name: &str,
        sensor: SensorSize,
    ) -> Result<Self, RerunError> {
        let address = match address {
            None => re_sdk::DEFAULT_CONNECT_URL.to_owned(),
            Some(url) if url.contains("://") => url.to_owned(),
            Some(host_and_port) => format!("rerun+http://{host_and_port}/proxy"),
        };
        let stream = match builder(name).connect_grpc_opts(address.as_str()) {
            Ok(stream) => stream,
            Err(source) => return Err(RerunError::Address { address, source }),
        };
        let recording = Self::begin(stream, Destination::Viewer(address), sensor)?;
        // Before a long recording is read for nobody.
        recording.flush(ANSWER)?;
        Ok(recording)
    }

    fn begin(
        stream: RecordingStream,
        to: Destination,
        sensor: SensorSize,
    ) -> Result<Self, RerunError> {
        // When an event was sent to the viewer says nothing about it.
        stream.set_log_time_enabled(false);
        layout::send(&stream, sensor)?;
        Ok(Self { stream, to, sent: Sent::default() })
    }

    /// Sends the next picture and its events.
    ///
    /// # Errors
    /// If the SDK refuses the data. What goes wrong on the way is told by [`finish`](Self::finish).
    pub fn send(&mut self, moment: &Moment<'_>) -> Result<(), RerunError> {
        self.stream.set_time(TIMELINE, TimeCell::from_duration_nanos(moment.t.0 * 1000));
        let picture = EncodedImage::new(moment.picture.to_vec()).with_media_type(MediaType::png());
        self.stream.log(PICTURE, &picture)?;
        let every = moment.events.len().div_ceil(MOST_POINTS).max(1);
        for side in &SIDES {
            let mut count = 0_u64;
            let mut points = Vec::new();
            for (k, event) in moment.events.iter().enumerate() {
                if event.polarity != side.polarity {
                    continue;
                }
                count += 1;
                if k % every == 0 {
                    // Pixel 0 reaches from 0 to 1.
                    points.push((f32::from(event.x) + 0.5, f32::from(event.y) + 0.5));
                }
            }
            self.sent.events += count;
            self.sent.points += points.len() as u64;
            let points = Points2D::update_fields().with_positions(points);
            self.stream.log(side.events, &points)?;
            let per_second = count as f64 / moment.length.as_seconds();
            self.stream.log(side.rate, &Scalars::single(per_second))?;
        }
        Ok(())
    }

    /// Waits until everything has arrived; a file gets its name.
    ///
    /// # Errors
    /// If the file could not be written, or the viewer went away.
    pub fn finish(self) -> Result<Sent, RerunError> {
        self.flush(Duration::MAX)?;
        if let Destination::File(file) = &self.to {
            file.commit()?;
        }
        Ok(self.sent)
    }

    fn flush(&self, timeout: Duration) -> Result<(), RerunError> {
        self.stream.flush_with_timeout(timeout).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: SinkFlushError) -> RerunError {
        match &self.to {
            Destination::File(file) => file.failed(&source),
            Destination::Viewer(address) => RerunError::Viewer { address: address.clone(), source },
        }
    }
}

fn builder(name: &str) -> RecordingStreamBuilder {
    RecordingStreamBuilder::new(APPLICATION)
        .recording_name(name)
        // Whoever asks for a file gets one, whatever the environment says.
        .enabled(true)
        .with_blueprint(layout::blueprint())
}
