//! A source of a stream of packets: iniVation's (see [`Aedat4Stream`]) or a framed one (see
//! [`evpose_io::framed`]).

use std::io::Read;
use std::time::Instant;

use evpose_core::SensorSize;
use evpose_io::aedat4::Aedat4Stream;
use evpose_io::framed::FramedReader;
use evpose_io::{Columns, IoError, OpenOptions};

use super::connection::ShutdownHandle;
use super::{Source, check_sensor};
use crate::LiveError;

/// A reader of packets of either kind.
trait Packets: Send {
    /// Appends events; false at the end.
    fn next(&mut self, columns: &mut Columns) -> Result<bool, IoError>;
    fn malformed(&self) -> u64;
}

impl<R: Read + Send> Packets for Aedat4Stream<R> {
    fn next(&mut self, columns: &mut Columns) -> Result<bool, IoError> {
        self.next(columns)
    }

    fn malformed(&self) -> u64 {
        self.malformed()
    }
}

impl<R: Read + Send> Packets for FramedReader<R> {
    fn next(&mut self, columns: &mut Columns) -> Result<bool, IoError> {
        self.next(columns)
    }

    fn malformed(&self) -> u64 {
        self.malformed()
    }
}

/// Events of a stream; their host time is that of arrival.
pub struct StreamSource {
    name: String,
    packets: Box<dyn Packets>,
    sensor: SensorSize,
    shutdown: ShutdownHandle,
    is_lossless: bool,
}

impl StreamSource {
    /// Reads the header of what dv-processing's `NetworkWriter` sends, or of a piped AEDAT 4.0 file.
    /// Messages refer to it as `name`; of the options, the camera and the sensor are used.
    ///
    /// # Errors
    /// If the header is unreadable or invalid, lacks the camera, or lacks its sensor or states
    /// another than the options.
    pub fn dv(
        name: &str,
        bytes: impl Read + Send + 'static,
        options: &OpenOptions,
    ) -> Result<Self, LiveError> {
        let stream = Aedat4Stream::open(name, bytes, options.camera.unwrap_or(0))?;
        if let Some(stated) = stream.sensor() {
            check_sensor(name, options.sensor, stated)?;
        }
        let sensor = options.sensor.or(stream.sensor()).ok_or_else(|| LiveError::Source {
            name: name.to_owned(),
            reason: "the stream does not state its sensor: give it, as 346x260".to_owned(),
        })?;
        Ok(Self::new(name, Box::new(stream), sensor))
    }

    /// Reads the header of a framed stream, which messages refer to as `name`.
    ///
    /// # Errors
    /// If it cannot be read, is none, or states another sensor than the one that is given.
    pub fn framed(
        name: &str,
        bytes: impl Read + Send + 'static,
        sensor: Option<SensorSize>,
    ) -> Result<Self, LiveError> {
        let reader = FramedReader::open(name, bytes)?;
        let stated = reader.sensor();
        check_sensor(name, sensor, stated)?;
        Ok(Self::new(name, Box::new(reader), stated))
    }

    fn new(name: &str, packets: Box<dyn Packets>, sensor: SensorSize) -> Self {
        let (name, shutdown) = (name.to_owned(), ShutdownHandle::default());
        Self { name, packets, sensor, shutdown, is_lossless: false }
    }

    /// The same source with a handle that unblocks it; it waits for the pipeline if `is_lossless`.
    pub(super) fn with(self, shutdown: ShutdownHandle, is_lossless: bool) -> Self {
        Self { shutdown, is_lossless, ..self }
    }
}

impl Source for StreamSource {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn sensor(&self) -> SensorSize {
        self.sensor
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        Ok(self.packets.next(columns)?.then(Instant::now))
    }

    fn pace(&self) -> Option<f64> {
        (!self.is_lossless).then_some(1.0)
    }

    fn is_lossless(&self) -> bool {
        self.is_lossless
    }

    fn malformed(&self) -> u64 {
        self.packets.malformed()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        self.shutdown.waker()
    }
}
