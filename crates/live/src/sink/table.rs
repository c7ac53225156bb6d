//! Poses as a table: see [`evpose_io::poses`].

use std::io::{self, Write};
use std::path::Path;

use evpose_io::poses::PoseColumns;

use super::Sink;
use super::output::Output;
use crate::{LiveError, LivePose};

/// Writes a header, and a line for every pose.
pub struct PoseCsv {
    name: String,
    out: Output,
    columns: Option<PoseColumns>,
    line: String,
}

impl PoseCsv {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: impl Write + Send + 'static) -> Self {
        Self::to(name.into(), Output::Stream(Box::new(out)))
    }

    /// Writes to a file, to standard output (`-`) or to `tcp://HOST:PORT`. A file has its name when all is written.
    ///
    /// # Errors
    /// If the file cannot be created or nobody listens.
    pub fn open(place: &Path) -> Result<Self, LiveError> {
        Ok(Self::to(place.display().to_string(), Output::open(place)?))
    }

    fn to(name: String, out: Output) -> Self {
        Self { name, out, columns: None, line: String::new() }
    }
}

impl Sink for PoseCsv {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.line.clear();
        // The header follows from the first pose, since the kind of poses is not known before.
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
    fn finish(&mut self) -> io::Result<()> {
        self.out.end()
    }
}
