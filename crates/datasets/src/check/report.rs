//! The report of a check.

use std::fmt;

use serde::Serialize;

/// A fault of a label, certain or suspected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum LabelFault {
    /// A coordinate of a joint is not finite.
    NotFinite,
    /// A joint is not on the image.
    Outside {
        /// Column.
        x: f32,
        /// Row.
        y: f32,
    },
    /// A joint is not labelled in a track that has others; from this frame on.
    Missing {
        /// Count of frames.
        frames: usize,
    },
    /// A limb is much longer or shorter than it is elsewhere; lengths in torsos.
    BoneLength {
        /// Length of the limb in torsos.
        length: f32,
        /// Median of its length.
        median: f32,
        /// Spread of its length.
        spread: f32,
    },
    /// Left and right seem to be exchanged, from this frame on.
    SwappedSides {
        /// Count of frames.
        frames: usize,
    },
    /// A joint is at the very same place while others move, from this frame on.
    FrozenJoint {
        /// Count of frames.
        frames: usize,
    },
    /// All joints are at the very same places, from this frame on.
    FrozenBody {
        /// Count of frames.
        frames: usize,
    },
    /// The frame is not behind the one before it.
    TimeOrder {
        /// Time of the frame before, in seconds.
        before_s: f64,
    },
}

impl LabelFault {
    /// Its name in lists.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NotFinite => "no number",
            Self::Outside { .. } => "outside of the image",
            Self::Missing { .. } => "missing",
            Self::BoneLength { .. } => "length of a limb",
            Self::SwappedSides { .. } => "left and right exchanged",
            Self::FrozenJoint { .. } => "frozen joint",
            Self::FrozenBody { .. } => "frozen body",
            Self::TimeOrder { .. } => "order of time",
        }
    }
}

impl fmt::Display for LabelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite => write!(f, "no number"),
            Self::Outside { x, y } => write!(f, "at ({x:.1}, {y:.1}), outside of the image"),
            Self::Missing { frames } => write!(f, "missing for {frames} frames"),
            Self::BoneLength { length, median, spread } => {
                write!(f, "{length:.2} torsos long, otherwise {median:.2} ± {spread:.2}")
            }
            Self::SwappedSides { frames } => {
                write!(f, "left and right exchanged for {frames} frames?")
            }
            Self::FrozenJoint { frames } => {
                write!(f, "at one place for {frames} frames while others move")
            }
            Self::FrozenBody { frames } => write!(f, "all at one place for {frames} frames"),
            Self::TimeOrder { before_s } => write!(f, "not later than {before_s} s before it"),
        }
    }
}

/// A fault, with its track, frame and joints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelFinding {
    /// Name of the track.
    pub track: String,
    /// The frame, or the first of several.
    pub frame: String,
    /// Its index in the track, from zero.
    pub index: usize,
    /// Its time, in seconds, if that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t_s: Option<f64>,
    /// The joints; none for all of them.
    pub joints: Vec<&'static str>,
    /// Kind of the fault, with its measurements.
    pub fault: LabelFault,
}

impl fmt::Display for LabelFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} #{} ({}", self.track, self.index, self.frame)?;
        if let Some(t_s) = self.t_s {
            write!(f, ", {t_s:.3} s")?;
        }
        write!(f, ")")?;
        if !self.joints.is_empty() {
            write!(f, " {}", self.joints.join(", "))?;
        }
        write!(f, ": {}", self.fault)
    }
}

/// Statistics of the length of a limb over all tracks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimbSummary {
    /// Joints at the ends of the limb.
    pub joints: [&'static str; 2],
    /// Count of frames in which it and the torso are labelled.
    pub frames: usize,
    /// Median of its length, in torsos.
    pub median: f32,
    /// Spread of its length, in torsos: 1.4826 times the median of the differences from the median,
    /// which is the standard deviation of normal ones.
    pub spread: f32,
    /// Count of frames in which it is an outlier.
    pub outliers: usize,
}

/// Counts of the labels of a joint over all tracks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct JointSummary {
    /// Name of the joint.
    pub joint: &'static str,
    /// Frames in which it is labelled.
    pub labelled: usize,
    /// Frames in which it is not.
    pub missing: usize,
    /// Frames in which it is labelled and not on the image.
    pub outside: usize,
    /// Frames in which it is not finite.
    pub not_finite: usize,
}

/// Findings and statistics of some tracks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// Count of tracks.
    pub tracks: usize,
    /// Count of their frames.
    pub frames: usize,
    /// Every joint.
    pub joints: Vec<JointSummary>,
    /// Every limb that is known somewhere.
    pub limbs: Vec<LimbSummary>,
    /// All that is suspected, track by track and in the order of time.
    pub findings: Vec<LabelFinding>,
}

/// Findings of a kind that are shown; all of them are in the report.
const SHOWN: usize = 10;

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tracks, frames, joints, limbs, findings } = self;
        writeln!(f, "{frames} frames of {tracks} tracks, {} findings", findings.len())?;
        let head = ["joint", "labelled", "missing", "outside", "no number"];
        let [joint, labelled, missing, outside, not_finite] = head;
        writeln!(f, "\n{joint:24}{labelled:>10}{missing:>10}{outside:>10}{not_finite:>11}")?;
        for JointSummary { joint, labelled, missing, outside, not_finite } in joints {
            writeln!(f, "{joint:24}{labelled:>10}{missing:>10}{outside:>10}{not_finite:>11}")?;
        }
        let [limb, frames, median, spread, outliers] =
            ["limb (in torsos)", "frames", "median", "spread", "outliers"];
        writeln!(f, "\n{limb:24}{frames:>10}{median:>10}{spread:>10}{outliers:>11}")?;
        for LimbSummary { joints, frames, median, spread, outliers } in limbs {
            let limb = joints.join(" - ");
            writeln!(f, "{limb:24}{frames:>10}{median:>10.3}{spread:>10.3}{outliers:>11}")?;
        }
        let mut names: Vec<&str> = findings.iter().map(|finding| finding.fault.name()).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let of_kind = || findings.iter().filter(|finding| finding.fault.name() == name);
            let count = of_kind().count();
            writeln!(f, "\n{name}: {count}")?;
            for finding in of_kind().take(SHOWN) {
                writeln!(f, "  {finding}")?;
            }
            if count > SHOWN {
                writeln!(f, "  … and {} more", count - SHOWN)?;
            }
        }
        Ok(())
    }
}
