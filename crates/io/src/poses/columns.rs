//! Lines of a table of poses.

use std::fmt::Write as _;
use std::path::Path;

use evpose_pose::{JointFrame, PARAMETER_NAMES};

use super::format::{PoseIterator, write_lines};
use super::{PoseKind, TimedPose};
use crate::IoError;

/// Suffixes of the columns of a joint.
pub(super) const PIXELS: [&str; 2] = ["_u_px", "_v_px"];
pub(super) const SCORE: &str = "_score";
pub(super) const METRES: [&str; 3] = ["_x_m", "_y_m", "_z_m"];

/// The columns of a table, in the order in which they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PoseColumns {
    kind: PoseKind,
    has_params: bool,
    /// Frame of positions in metres; without one there are no such columns.
    frame: Option<JointFrame>,
}

impl PoseColumns {
    /// All columns of a kind of poses.
    pub fn of(kind: PoseKind) -> Self {
        let (has_params, frame) = match kind {
            PoseKind::Body | PoseKind::Values(_) => (false, None),
            PoseKind::Hand => (true, Some(JointFrame::Camera)),
        };
        Self { kind, has_params, frame }
    }

    /// All columns of poses with positions in a frame: of people, those in metres are there if there is one.
    pub fn of_frame(kind: PoseKind, frame: Option<JointFrame>) -> Self {
        let own = Self::of(kind);
        Self { frame: frame.or(own.frame), ..own }
    }

    /// The same without parameters of hands: joints alone.
    #[must_use]
    pub fn without_params(self) -> Self {
        Self { has_params: false, ..self }
    }

    /// Writes a table.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(self, path: &Path, poses: PoseIterator<'_>) -> Result<(), IoError> {
        let line = |pose| {
            let mut line = String::new();
            self.push_line(&mut line, &pose);
            line
        };
        write_lines(path, std::iter::once(self.header()).chain(poses.map(line)))
    }

    /// The header line, with its end.
    pub fn header(self) -> String {
        let mut line = "t_us,origin,latency_ms,score".to_owned();
        if self.frame.is_some() {
            line.push_str(",frame");
        }
        for name in PARAMETER_NAMES.iter().filter(|_| self.has_params) {
            let _ = write!(line, ",{name}");
        }
        for name in self.kind.value_names() {
            let _ = write!(line, ",{name}");
        }
        for joint in self.kind.joint_names() {
            for suffix in PIXELS {
                let _ = write!(line, ",{joint}{suffix}");
            }
            if self.kind == PoseKind::Body {
                let _ = write!(line, ",{joint}{SCORE}");
            }
            for suffix in METRES.iter().filter(|_| self.frame.is_some()) {
                let _ = write!(line, ",{joint}{suffix}");
            }
        }
        line + "\n"
    }

    /// Appends the line of a pose, with its end.
    pub fn push_line(self, text: &mut String, pose: &TimedPose) {
        let _ = write!(text, "{}", pose.t.0);
        text.push(',');
        text.push_str(pose.origin.map_or("", |origin| origin.name()));
        push(text, pose.latency_ms.map(|ms| format!("{ms:.3}")));
        push(text, score(pose.score));
        if let Some(frame) = self.frame {
            push(text, Some(frame.name().to_owned()));
        }
        if self.has_params {
            let values = pose.params.map(|params| params.to_array());
            for k in 0..PARAMETER_NAMES.len() {
                push(text, values.map(|values| values[k].to_string()));
            }
        }
        for k in 0..self.kind.value_names().len() {
            let value = pose.values.as_ref().map(|values| values[k]);
            push(text, value.filter(|value| value.is_finite()).map(|value| value.to_string()));
        }
        for joint in &pose.joints {
            // CSV has no form of NaN and infinities: an empty cell is read as no value.
            let at = joint.image_px.filter(|at| at.is_finite());
            push(text, at.map(|at| format!("{:.3}", at.x)));
            push(text, at.map(|at| format!("{:.3}", at.y)));
            if self.kind == PoseKind::Body {
                push(text, score(joint.score));
            }
            if self.frame.is_some() {
                let at = joint.position_m.filter(|at| at.is_finite());
                for k in 0..METRES.len() {
                    // Five decimals are 10 um, far below the error of any tracker.
                    push(text, at.map(|at| format!("{:.5}", at[k])));
                }
            }
        }
        text.push('\n');
    }
}

fn score(score: Option<f32>) -> Option<String> {
    score.filter(|score| score.is_finite()).map(|score| format!("{score:.4}"))
}

fn push(text: &mut String, cell: Option<String>) {
    text.push(',');
    text.push_str(&cell.unwrap_or_default());
}
