//! Writes a stream to whatever takes bytes.

use std::io::Write;
use std::path::PathBuf;

use evpose_core::{EventStream, SensorSize};

use super::layout::{EVENT, HEAD, Head, LONGEST_US, MAX_ROWS, encode, header};
use crate::IoError;

/// Events of a packet, at most: readers give them at once.
const EVENTS: usize = 1 << 14;

/// A framed stream that is being written.
pub struct FramedWriter<W> {
    name: PathBuf,
    out: W,
    sensor: SensorSize,
    packet: Vec<u8>,
}

impl<W: Write> FramedWriter<W> {
    /// Writes the header of a stream, which messages call `name`.
    ///
    /// # Errors
    /// If the sensor has no pixels or more than 32,768 rows, or if writing fails.
    pub fn begin(
        name: impl Into<PathBuf>,
        mut out: W,
        sensor: SensorSize,
    ) -> Result<Self, IoError> {
        let name = name.into();
        if sensor.pixels() == 0 || sensor.height > MAX_ROWS {
            let reason = format!("a sensor of {sensor}, and there is room for 1 to 32768 rows");
            return Err(IoError::unwritable(&name, reason));
        }
        let written = out.write_all(&header(sensor)).and_then(|()| out.flush());
        written.map_err(|e| IoError::file(&name, "write", e))?;
        Ok(Self { name, out, sensor, packet: Vec::new() })
    }

    /// Sends events, in one packet or more.
    ///
    /// # Errors
    /// If an event lies outside of the sensor or its time beyond what the format holds, or if
    /// writing fails.
    pub fn push(&mut self, events: &EventStream) -> Result<(), IoError> {
        let (t, x, y) = (events.t(), events.x(), events.y());
        let mut from = 0;
        while let Some(&base) = t.get(from) {
            // A packet spans 71 minutes at most.
            let span = &t[from..t.len().min(from + EVENTS)];
            let fits = |since: i64| u32::try_from(since).is_ok();
            let count = span.partition_point(|t| t.0.checked_sub(base.0).is_some_and(fits));
            let range = from..from + count;
            if base.0.abs_diff(0) > LONGEST_US as u64 {
                return Err(self.unwritable(format!("an event at {base}")));
            }
            self.packet.clear();
            self.packet.extend(Head { count: count as u32, base }.bytes());
            self.packet.reserve(count * EVENT);
            for index in range {
                let (x, y) = (x[index], y[index]);
                if !self.sensor.contains(x, y) {
                    return Err(self.unwritable(format!("event at ({x}, {y}) of {}", self.sensor)));
                }
                let since = (t[index].0 - base.0) as u32;
                self.packet.extend(encode(since, x, y, events.polarity()[index]));
            }
            assert_eq!(self.packet.len(), HEAD + count * EVENT);
            self.out.write_all(&self.packet).map_err(|e| IoError::file(&self.name, "write", e))?;
            from += count;
        }
        // A packet that waits in a buffer is late at the other side.
        self.out.flush().map_err(|e| IoError::file(&self.name, "write", e))
    }

    /// Writer of the stream.
    pub fn into_inner(self) -> W {
        self.out
    }

    fn unwritable(&self, reason: String) -> IoError {
        IoError::unwritable(&self.name, reason)
    }
}
