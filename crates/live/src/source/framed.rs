//! A framed stream, as anybody writes it: see [`evpose_io::framed`].

use std::io::Read;
use std::time::Instant;

use evpose_core::SensorSize;
use evpose_io::Columns;
use evpose_io::framed::FramedReader;

use super::Source;
use super::wire::Hook;
use crate::LiveError;

/// Events of a framed stream. They happened when they came.
pub struct Framed<R> {
    name: String,
    reader: FramedReader<R>,
    sensor: SensorSize,
    hook: Hook,
}

impl<R: Read + Send + 'static> Framed<R> {
    /// Reads the header of a stream, which messages call `name`.
    ///
    /// # Errors
    /// If it cannot be read, or is none.
    pub fn open(name: impl Into<String>, bytes: R) -> Result<Self, LiveError> {
        let name = name.into();
        let reader = FramedReader::open(&name, bytes)?;
        Ok(Self { name, sensor: reader.sensor(), reader, hook: Hook::default() })
    }

    /// The same of a connection.
    pub(super) fn hooked(self, hook: Hook) -> Self {
        Self { hook, ..self }
    }

    /// The same with the sensor that the user says it is from.
    pub(super) fn of_sensor(self, given: Option<SensorSize>) -> Self {
        Self { sensor: given.unwrap_or(self.sensor), ..self }
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

    fn malformed(&self) -> u64 {
        self.reader.malformed()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        self.hook.waker()
    }
}
