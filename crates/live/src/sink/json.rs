//! Poses as JSON Lines, to a file, a pipe or a socket: see [`evpose_io::poses`].

use std::io::{self, Write};

use evpose_io::poses::json_line;

use super::Sink;
use crate::LivePose;

/// Writes a line for every pose, with the names of the table.
pub struct JsonLines<W> {
    name: String,
    out: W,
}

impl<W: Write> JsonLines<W> {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: W) -> Self {
        Self { name: name.into(), out }
    }
}

impl<W: Write + Send + 'static> Sink for JsonLines<W> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.out.write_all(json_line(pose.kind(), &pose.timed()).as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
