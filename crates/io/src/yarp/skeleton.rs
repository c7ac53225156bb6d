//! Skeletons in a `data.log`.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use evpose_core::{Micros, bytes_without_bom};
use evpose_pose::body::{BodyPoints, network_from_file};

use super::bottle::head_of;
use crate::open::input;
use crate::predictions::detected;
use crate::{Input, IoError};

/// Joints of a skeleton: head, right and left shoulder, right and left elbow, left and right hip,
/// right and left hand, right and left knee, right and left foot.
pub const JOINTS: usize = 13;

/// Maximal length of a line; no line of a skeleton is longer.
const MAX_LINE: u64 = 1 << 16;

/// Joints of a person on the image, as hpe-core logs them.
#[derive(Debug, Clone, PartialEq)]
pub struct YarpSkeleton {
    /// Time stamp.
    pub t: Micros,
    /// Column and row of each of the [`JOINTS`], in pixels. DHP19's logs have row and column:
    /// [`transposed`](Self::transposed) exchanges them.
    pub joints: [[f32; 2]; JOINTS],
    /// Confidence of each joint, 0 to 1, in skeletons that a network detected online.
    pub confidences: Option<[f32; JOINTS]>,
    /// Size of the head in pixels, if it is known.
    pub head_size_px: Option<f32>,
    /// Length from the left hip to the right shoulder in pixels, if it is known.
    pub torso_size_px: Option<f32>,
}

impl YarpSkeleton {
    /// The same with columns and rows exchanged.
    #[must_use]
    pub fn transposed(mut self) -> Self {
        self.joints.iter_mut().for_each(|joint| joint.reverse());
        self
    }

    /// Its joints in the order of networks. Those at (-1, -1) are not known; with confidences,
    /// neither are those at other pairs of negative whole numbers, as decoders write what they do
    /// not find.
    pub fn points_px(&self) -> BodyPoints {
        let is_online = self.confidences.is_some();
        let point = |joint: [f32; 2]| {
            if is_online { detected(joint) } else { (joint != [-1.0; 2]).then(|| joint.into()) }
        };
        network_from_file(&self.joints.map(point))
    }
}

/// Reads the skeletons of a log, or of the `data.log` in a folder: lines such as
/// `7 000.12 SKLT (26 values) -1.0 104.3`, or with 39 values, the last 13 of which are confidences,
/// as MoveEnet sends them online.
///
/// # Errors
/// If the file cannot be read, a line with something on it is no skeleton, or the last one does not
/// end: sizes stand at the ends of lines, where a cut would go unseen.
pub fn read_skeletons(path: impl AsRef<Path>) -> Result<Vec<YarpSkeleton>, IoError> {
    read_skeletons_from(input(path.as_ref())?)
}

/// As [`read_skeletons`], from a file that is open already, or from memory.
///
/// # Errors
/// As [`read_skeletons`].
pub fn read_skeletons_from(input: Input) -> Result<Vec<YarpSkeleton>, IoError> {
    let mut bytes = BufReader::new(input.bytes);
    let (mut skeletons, mut line, mut at) = (Vec::new(), Vec::new(), 0);
    loop {
        line.clear();
        // A file of another kind may have no line break: without a limit it would fill memory.
        let read = (&mut bytes).take(MAX_LINE).read_until(b'\n', &mut line);
        read.map_err(|e| IoError::file(&input.path, "read", e))?;
        if line.is_empty() {
            return Ok(skeletons);
        }
        // Without its line break, a last value of 12 may have been 123.
        let content = if at == 0 { bytes_without_bom(&line) } else { &line };
        if !content.trim_ascii().is_empty() {
            let reason = match (skeleton(content), line.ends_with(b"\n")) {
                (Some(skeleton), true) => {
                    skeletons.push(skeleton);
                    at += line.len() as u64;
                    continue;
                }
                (Some(_), false) => "the file ends in this line, perhaps within a number",
                (None, _) => "a number, a time, SKLT and 26 or 39 values in brackets were expected",
            };
            let (path, events) = (input.path, skeletons.len() as u64);
            return Err(IoError::Damaged { path, byte: at, reason: reason.into(), events });
        }
        at += line.len() as u64;
    }
}

fn skeleton(line: &[u8]) -> Option<YarpSkeleton> {
    let line = str::from_utf8(line).ok()?;
    let (head, rest) = line.split_once('(')?;
    let (inside, behind) = rest.split_once(')')?;
    let (t, name) = head_of(head.as_bytes())?;
    let (values, sizes) = (values(inside)?, values(behind)?);
    let (positions, confidences) = values.split_at_checked(2 * JOINTS)?;
    let joints = positions.as_chunks::<2>().0.try_into().ok().filter(|_| name == "SKLT")?;
    let confidences = match confidences {
        [] => None,
        _ => Some(confidences.try_into().ok()?),
    };
    // Unknown sizes are -1.
    let size = |k: usize| sizes.get(k).copied().filter(|size| *size >= 0.0);
    Some(YarpSkeleton { t, joints, confidences, head_size_px: size(0), torso_size_px: size(1) })
}

fn values(text: &str) -> Option<Vec<f32>> {
    let number = |word: &str| word.parse().ok().filter(|number: &f32| number.is_finite());
    text.split_ascii_whitespace().map(number).collect()
}
