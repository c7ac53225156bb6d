//! Poses as a table: see [`evpose_io::poses`].

use std::io::{self, Write};

use evpose_io::poses::PoseColumns;

use super::Sink;
use crate::LivePose;

/// Writes a header, and a line for every pose.
pub struct PoseCsv<W> {
    name: String,
    out: W,
    columns: Option<PoseColumns>,
    line: String,
}

impl<W: Write> PoseCsv<W> {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: W) -> Self {
        Self { name: name.into(), out, columns: None, line: String::new() }
    }
}

impl<W: Write + Send + 'static> Sink for PoseCsv<W> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.line.clear();
        let columns = match self.columns {
            Some(columns) => columns,
            None => {
                let columns = *self.columns.insert(PoseColumns::of(pose.kind()));
                self.line = columns.header();
                columns
            }
        };
        columns.push_line(&mut self.line, &pose.timed());
        self.out.write_all(self.line.as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
