//! Predictions of bodies as a table, as MoveEnet's programs write and evaluate them.
//!
//! A line is `t delay x0 y0 … x12 y12`: when in seconds, how long it took, and column and row of
//! thirteen joints in pixels of the image, in the order of files. Values are separated by spaces;
//! commas, as the online program writes them, are read too, and so are empty lines and comments
//! behind `#`.
//!
//! * **Delays** are in seconds, as where the training program evaluates.
//! * **Joints that were not found** have no place in the format. They are written as `-1 -1`; the
//!   published program writes minus the width and the height of the image, which is what it makes of -1. Any pair of negative whole numbers is read as such. A found joint that lies at
//!   exactly such a pair is moved by the least step of a 32-bit number.
//!
//! # Source
//! hpe-core's `write_output`, `write_results` and `evaluate_hpe`.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, bytes_without_bom};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, file_from_network, network_from_file};
use evpose_pose::metric::body::BodyPrediction;
use glam::Vec2;

use crate::{Input, IoError};

/// Values of a line.
const COLUMNS: usize = 2 + 2 * BODY_JOINTS;
/// No line is longer.
const LONGEST_LINE: u64 = 1 << 16;

/// Reads a table of predictions.
///
/// # Errors
/// If the file cannot be read, a line holds anything but 28 finite values, or the last one does not
/// end, as a cut number would go unseen.
pub(crate) fn predictions_of(input: Input) -> Result<Vec<BodyPrediction>, IoError> {
    let mut bytes = BufReader::new(input.bytes);
    let (mut rows, mut text, mut byte, mut line) = (Vec::new(), Vec::new(), 0, 0);
    loop {
        text.clear();
        // A file without line breaks must not be read as one line into memory.
        let read = (&mut bytes).take(LONGEST_LINE).read_until(b'\n', &mut text);
        read.map_err(|e| IoError::file(&input.path, "read", e))?;
        if text.is_empty() {
            return Ok(rows);
        }
        line += 1;
        match row(if line == 1 { bytes_without_bom(&text) } else { &text }) {
            Ok(row) => rows.extend(row),
            Err(reason) => {
                let (reason, rows) = (reason.to_string(), rows.len() as u64);
                return Err(IoError::Row { path: input.path, line, byte, reason, rows });
            }
        }
        byte += text.len() as u64;
    }
}

/// A line that is no prediction.
#[derive(Debug, thiserror::Error)]
enum LineFault {
    #[error("it is not text")]
    NoText,
    #[error("column {0} is {1:?}, no finite number")]
    NoNumber(usize, String),
    #[error("the file ends in it, perhaps within a number")]
    NoEnd,
    #[error("{COLUMNS} values were expected, {0} found")]
    Values(usize),
}

/// Parses a line; none for an empty one.
fn row(line: &[u8]) -> Result<Option<BodyPrediction>, LineFault> {
    let text = str::from_utf8(line).map_err(|_| LineFault::NoText)?;
    // Comments are allowed anywhere in a line.
    let text = text.split('#').next().unwrap_or_default();
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    let number = |(column, word): (usize, &str)| {
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| LineFault::NoNumber(column + 1, word.to_owned()))
    };
    let values = words.enumerate().map(number).collect::<Result<Vec<_>, _>>()?;
    if values.is_empty() {
        return Ok(None);
    }
    // A number that is cut is a number as well, and a wrong one.
    if !line.ends_with(b"\n") {
        return Err(LineFault::NoEnd);
    }
    // Two values stand before the positions: time and delay.
    let Ok([t_s, delay_s, positions @ ..]) = <[f64; COLUMNS]>::try_from(values.as_slice()) else {
        return Err(LineFault::Values(values.len()));
    };
    let joint = |joint: usize| detected([0, 1].map(|axis| positions[2 * joint + axis] as f32));
    let joints_px = network_from_file(&std::array::from_fn(joint));
    Ok(Some(BodyPrediction { t_s, delay_s, joints_px }))
}

/// Position of a joint, unless the pair of values stands for a joint without a detection.
pub(crate) fn detected(joint: [f32; 2]) -> Option<Vec2> {
    (!stands_for_none(joint)).then(|| joint.into())
}

fn stands_for_none(joint: [f32; 2]) -> bool {
    joint.iter().all(|number| *number < 0.0 && number.fract() == 0.0)
}

/// Writes a table of predictions line by line. Dropped before [`finish`](Self::finish), it leaves
/// no file.
#[derive(Debug)]
pub(crate) struct PredictionWriter {
    path: PathBuf,
    file: AtomicFile,
    line: String,
    rows: u64,
}

impl PredictionWriter {
    /// Begins a file.
    ///
    /// # Errors
    /// If it cannot be created.
    pub(crate) fn create(path: &Path) -> Result<Self, IoError> {
        let path = path.to_owned();
        let file = AtomicFile::create(&path).map_err(|e| IoError::file(&path, "create", e))?;
        Ok(Self { path, file, line: String::new(), rows: 0 })
    }

    /// Writes a line.
    ///
    /// # Errors
    /// If a number is not finite, or cannot be written.
    pub(crate) fn write(&mut self, prediction: &BodyPrediction) -> Result<(), IoError> {
        let BodyPrediction { t_s, delay_s, joints_px } = prediction;
        let are_finite = joints_px.iter().flatten().all(|joint| joint.is_finite());
        if !(are_finite && t_s.is_finite() && delay_s.is_finite()) {
            let reason = format!("prediction {} holds a number that is not finite", self.rows);
            return Err(IoError::unwritable(&self.path, reason));
        }
        self.line.clear();
        // Text takes all that is written to it.
        let _ = write!(self.line, "{t_s} {delay_s}");
        for [x, y] in pairs(joints_px) {
            let _ = write!(self.line, " {x} {y}");
        }
        self.line.push('\n');
        self.rows += 1;
        let written = self.file.write_all(self.line.as_bytes());
        written.map_err(|e| IoError::file(&self.path, "write", e))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If what is left cannot be written.
    pub(crate) fn finish(self) -> Result<(), IoError> {
        self.file.commit().map_err(|e| IoError::file(&self.path, "write", e))
    }
}

/// In the order of files.
fn pairs(joints_px: &BodyPoints) -> [[f32; 2]; BODY_JOINTS] {
    file_from_network(joints_px).map(|joint| match joint.map(<[f32; 2]>::from) {
        Some([x, y]) if stands_for_none([x, y]) => [x.next_up(), y],
        Some(joint) => joint,
        None => [-1.0; 2],
    })
}

#[cfg(test)]
mod tests;
