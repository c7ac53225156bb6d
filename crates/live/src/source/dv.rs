//! A source of iniVation's DV streams: see [`Aedat4Stream`].

use std::io::Read;
use std::time::Instant;

use evpose_core::SensorSize;
use evpose_io::aedat4::Aedat4Stream;
use evpose_io::{Columns, OpenOptions};

use super::connection::ShutdownHandle;
use super::{Source, check_sensor};
use crate::LiveError;

/// Events from dv-processing's `NetworkWriter`, or a piped AEDAT 4.0 file; their host time is that
/// of arrival.
pub struct Dv<R> {
    name: String,
    stream: Aedat4Stream<R>,
    sensor: SensorSize,
    shutdown: ShutdownHandle,
    is_lossless: bool,
}

impl<R: Read + Send + 'static> Dv<R> {
    /// Reads the header of a stream, which messages refer to as `name`. Of the options, the camera
    /// and the sensor are used.
    ///
    /// # Errors
    /// If the header is unreadable or invalid, lacks the camera, or lacks its sensor or states
    /// another than the options.
    pub fn open(
        name: impl Into<String>,
        bytes: R,
        options: &OpenOptions,
    ) -> Result<Self, LiveError> {
        let name = name.into();
        let stream = Aedat4Stream::open(&name, bytes, options.camera.unwrap_or(0))?;
        if let Some(stated) = stream.sensor() {
            check_sensor(&name, options.sensor, stated)?;
        }
        let sensor = options.sensor.or(stream.sensor()).ok_or_else(|| LiveError::Source {
            name: name.clone(),
            reason: "the stream does not state its sensor: give it, as 346x260".to_owned(),
        })?;
        Ok(Self { name, stream, sensor, shutdown: ShutdownHandle::default(), is_lossless: false })
    }

    /// The same source, which waits for the pipeline if `is_lossless`.
    pub(super) fn with_waiting(self, is_lossless: bool) -> Self {
        Self { is_lossless, ..self }
    }

    /// The same source with a handle that unblocks it.
    pub(super) fn with_shutdown_handle(self, shutdown: ShutdownHandle) -> Self {
        Self { shutdown, ..self }
    }
}

impl<R: Read + Send + 'static> Source for Dv<R> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn sensor(&self) -> SensorSize {
        self.sensor
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        Ok(self.stream.next(columns)?.then(Instant::now))
    }

    fn pace(&self) -> Option<f64> {
        (!self.is_lossless).then_some(1.0)
    }

    fn is_lossless(&self) -> bool {
        self.is_lossless
    }

    fn malformed(&self) -> u64 {
        self.stream.malformed()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        self.shutdown.waker()
    }
}
