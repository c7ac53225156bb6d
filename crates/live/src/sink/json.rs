//! Poses as JSON Lines, to a file, a pipe or a socket: see [`evpose_io::poses`].

use std::io::{self, Write};
use std::path::Path;

use evpose_io::poses::json_line;

use super::Sink;
use super::output::Output;
use crate::{LiveError, LivePose};

/// Writes a line for every pose, with the names of the table.
pub struct JsonLines {
    name: String,
    out: Output,
}

impl JsonLines {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: impl Write + Send + 'static) -> Self {
        Self { name: name.into(), out: Output::Stream(Box::new(out)) }
    }

    /// Writes to a file, to standard output (`-`) or to `tcp://HOST:PORT`. A file has its name when all is written.
    ///
    /// # Errors
    /// If the file cannot be created or nobody listens.
    pub fn open(place: &Path) -> Result<Self, LiveError> {
        Ok(Self { name: place.display().to_string(), out: Output::open(place)? })
    }
}

impl Sink for JsonLines {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.out.write_all(json_line(pose.kind(), &pose.timed()).as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.end()
    }
}
