//! Measures by which systems are compared, and the data sets of published figures.

use serde::{Deserialize, Serialize};

/// Thresholds of the PCK, in percent of the torso's diagonal.
pub(crate) const PERCENTS: [usize; 3] = [40, 60, 80];

/// A measure of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Measure {
    /// Share of joints within 0.4 of the torso's diagonal.
    Pck40,
    /// Within 0.6.
    Pck60,
    /// Within 0.8.
    Pck80,
    /// Area under the curve of shares up to the diagonal.
    Auc,
    /// Mean error of joints, in pixels.
    MpjpePx,
    /// Mean error of joints in space, in millimetres.
    MpjpeMm,
    /// Poses per second of one system on one thread.
    PosesPerS,
}

impl Measure {
    /// All of them.
    pub(crate) const ALL: [Self; 7] = [
        Self::Pck40,
        Self::Pck60,
        Self::Pck80,
        Self::Auc,
        Self::MpjpePx,
        Self::MpjpeMm,
        Self::PosesPerS,
    ];

    /// Heading.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Pck40 => "PCK@0.4",
            Self::Pck60 => "PCK@0.6",
            Self::Pck80 => "PCK@0.8",
            Self::Auc => "AUC",
            Self::MpjpePx => "MPJPE px",
            Self::MpjpeMm => "MPJPE mm",
            Self::PosesPerS => "poses/s",
        }
    }

    /// Digits behind the point.
    pub(crate) fn digits(self) -> usize {
        match self {
            Self::Pck40 | Self::Pck60 | Self::Pck80 | Self::Auc => 3,
            Self::MpjpePx | Self::MpjpeMm => 1,
            Self::PosesPerS => 0,
        }
    }

    /// Whether a system is better by more of it.
    pub(crate) fn is_good_if_large(self) -> bool {
        !matches!(self, Self::MpjpePx | Self::MpjpeMm)
    }
}

/// Source of a published figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) enum DataSet {
    /// Front cameras of DHP19: Table 1.
    #[serde(rename = "DHP19")]
    Dhp19,
    /// Human3.6M as events: Table 2.
    #[serde(rename = "eH3.6M")]
    Eh36m,
    /// Online, with a GeForce RTX 2070.
    #[serde(rename = "online")]
    Online,
}

impl std::fmt::Display for DataSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Dhp19 => "DHP19",
            Self::Eh36m => "eH3.6M",
            Self::Online => "an RTX 2070",
        })
    }
}
