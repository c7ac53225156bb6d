//! A source of a framed stream: see [`evpose_io::framed`].

use std::io::Read;
use std::time::Instant;

use evpose_core::SensorSize;
use evpose_io::Columns;
use evpose_io::framed::FramedReader;

use super::connection::ShutdownHandle;
use super::{Source, check_sensor};
use crate::LiveError;

/// Events of a framed stream; their host time is that of arrival.
pub struct Framed<R> {
    name: String,
    reader: FramedReader<R>,
    sensor: SensorSize,
    shutdown: ShutdownHandle,
    is_lossless: bool,
}

impl<R: Read + Send + 'static> Framed<R> {
    /// Reads the header of a stream, which messages refer to as `name`.
    ///
    /// # Errors
    /// If it cannot be read, or is none.
    pub fn open(name: impl Into<String>, bytes: R) -> Result<Self, LiveError> {
        let name = name.into();
        let reader = FramedReader::open(&name, bytes)?;
        Ok(Self {
            name,
            sensor: reader.sensor(),
            reader,
            shutdown: ShutdownHandle::default(),
            is_lossless: false,
        })
    }

    /// The same source, which waits for the pipeline if `is_lossless`.
    pub(super) fn with_waiting(self, is_lossless: bool) -> Self {
        Self { is_lossless, ..self }
    }

    /// The same source with a handle that unblocks it.
    pub(super) fn with_shutdown_handle(self, shutdown: ShutdownHandle) -> Self {
        Self { shutdown, ..self }
    }

    /// The same source, of which the user gives the size of the sensor.
    ///
    /// # Errors
    /// If the stream states another.
    pub(super) fn of_sensor(self, given: Option<SensorSize>) -> Result<Self, LiveError> {
        check_sensor(&self.name, given, self.sensor)?;
        Ok(self)
    }
}

impl<R: Read + Send + 'static> Source for Framed<R> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn sensor(&self) -> SensorSize {
        self.sensor
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        Ok(self.reader.next(columns)?.then(Instant::now))
    }

    fn pace(&self) -> Option<f64> {
        (!self.is_lossless).then_some(1.0)
    }

    fn is_lossless(&self) -> bool {
        self.is_lossless
    }

    fn malformed(&self) -> u64 {
        self.reader.malformed()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        self.shutdown.waker()
    }
}
