//! A stream of iniVation's DV: see [`Aedat4Stream`].

use std::io::Read;
use std::time::Instant;

use evpose_core::SensorSize;
use evpose_io::aedat4::Aedat4Stream;
use evpose_io::{Columns, OpenOptions};

use super::Source;
use super::wire::Hook;
use crate::LiveError;

/// Events that dv-processing's `NetworkWriter` sends, or an AEDAT 4.0 file that is piped. They happened
/// when they came.
pub struct Dv<R> {
    name: String,
    stream: Aedat4Stream<R>,
    sensor: SensorSize,
    hook: Hook,
}

impl<R: Read + Send + 'static> Dv<R> {
    /// Reads the header of a stream, which messages call `name`. Of the options, the camera and the sensor
    /// are heeded.
    ///
    /// # Errors
    /// If the header cannot be read, is none, does not name the camera, or not its sensor.
    pub fn open(
        name: impl Into<String>,
        bytes: R,
        options: &OpenOptions,
    ) -> Result<Self, LiveError> {
        let name = name.into();
        let stream = Aedat4Stream::open(&name, bytes, options.camera.unwrap_or(0))?;
        let sensor = options.sensor.or(stream.sensor()).ok_or_else(|| LiveError::Source {
            what: name.clone(),
            reason: "the stream does not state its sensor: give it, as 346x260".to_owned(),
        })?;
        Ok(Self { name, stream, sensor, hook: Hook::default() })
    }

    /// The same of a connection.
    pub(super) fn hooked(self, hook: Hook) -> Self {
        Self { hook, ..self }
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

    fn malformed(&self) -> u64 {
        self.stream.malformed()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        self.hook.waker()
    }
}
