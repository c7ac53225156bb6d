//! A recording on its way to the viewer.

use std::path::Path;

use evpose_core::{EventStream, Micros, SensorSize};
use re_sdk_types::archetypes::{EncodedImage, Points2D, Scalars};
use re_sdk_types::components::MediaType;

use crate::RerunError;
use crate::layout::{self, PICTURE, SIDES};
use crate::outlet::Outlet;

/// Points of one picture, at most: the viewer draws so many without a pause.
const MOST_POINTS: usize = 100_000;

/// Pictures, events and rates over time, on their way to a file or a viewer.
///
/// Dropped before [`finish`](Self::finish), a file does not appear.
pub struct Recording {
    outlet: Outlet,
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

impl Recording {
    /// Begins the file `path`, which appears with [`finish`](Self::finish).
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, name: &str, sensor: SensorSize) -> Result<Self, RerunError> {
        Self::begin(Outlet::create(path, name, layout::of_recordings())?, sensor)
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
        Self::begin(Outlet::connect(address, name, layout::of_recordings())?, sensor)
    }

    fn begin(outlet: Outlet, sensor: SensorSize) -> Result<Self, RerunError> {
        layout::send(&outlet.stream, sensor)?;
        Ok(Self { outlet, sent: Sent::default() })
    }

    /// Sends the next picture and its events.
    ///
    /// # Errors
    /// If the SDK refuses the data. What goes wrong on the way is told by [`finish`](Self::finish).
    pub fn send(&mut self, moment: &Moment<'_>) -> Result<(), RerunError> {
        self.outlet.set_time(moment.t);
        let stream = &self.outlet.stream;
        let picture = EncodedImage::new(moment.picture.to_vec()).with_media_type(MediaType::png());
        stream.log(PICTURE, &picture)?;
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
            stream.log(side.events, &points)?;
            let per_second = count as f64 / moment.length.as_seconds();
            stream.log(side.rate, &Scalars::single(per_second))?;
        }
        Ok(())
    }

    /// Waits until everything has arrived; a file gets its name.
    ///
    /// # Errors
    /// If the file could not be written, or the viewer went away.
    pub fn finish(self) -> Result<Sent, RerunError> {
        self.outlet.finish()?;
        Ok(self.sent)
    }
}
