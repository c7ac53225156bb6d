//! The report of converted and skipped persons.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

/// Reason for skipping a photograph or a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SkipReason {
    /// Nobody is annotated on the photograph.
    NoPersons,
    /// The folder has no such file.
    NoImage,
    /// The file is no image that can be read.
    UnreadableImage,
    /// The name of the file is no plain name, or another photograph has it.
    BadName,
    /// A field of the person is not what it should be.
    BadField,
    /// The person has no points.
    NoPoints,
    /// All points of the person are at one place.
    NoExtent,
    /// A point is far outside of the photograph, or is no number.
    PointsOutside,
    /// It is a crowd, annotated as one.
    Crowd,
    /// The person has too few joints.
    FewJoints,
    /// The person is too small on the photograph.
    Small,
    /// Left and right of the person seem to be exchanged.
    SidesExchanged,
    /// The person has no box of the head.
    NoHeadBox,
    /// The person has no middle.
    NoCenter,
    /// With parity: somebody else on the photograph lacks points, a head or a middle.
    IncompleteCompanion,
    /// With parity: it is not said of a point whether it can be seen.
    NoVisibility,
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoPersons => "nobody is annotated",
            Self::NoImage => "no such image",
            Self::UnreadableImage => "no readable image",
            Self::BadName => "no plain file name of its own",
            Self::BadField => "a field of another kind",
            Self::NoPoints => "no points",
            Self::NoExtent => "all points at one place",
            Self::PointsOutside => "points far outside of the image",
            Self::Crowd => "a crowd",
            Self::FewJoints => "too few joints",
            Self::Small => "too small",
            Self::SidesExchanged => "left and right seem to be exchanged",
            Self::NoHeadBox => "no box of the head",
            Self::NoCenter => "no middle",
            Self::IncompleteCompanion => "somebody else is incomplete (parity)",
            Self::NoVisibility => "unknown whether a point is visible (parity)",
        })
    }
}

/// A photograph or a person that was skipped.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// File of the photograph.
    pub image: String,
    /// Index of the person on it, from zero; none for the whole photograph.
    pub person: Option<usize>,
    /// Rule by which it was skipped.
    pub reason: SkipReason,
    /// Details of the fault, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
}

/// Counts of a conversion.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Converted {
    /// Photographs from which somebody was taken.
    pub images: usize,
    /// Persons, each with an image.
    pub persons: usize,
    /// Photographs that are not for training: their joints are not published.
    pub not_for_training: usize,
    /// How often each joint is labelled, of all persons.
    pub labelled: BTreeMap<&'static str, usize>,
    /// All else, in the order of the annotations.
    pub skipped: Vec<Skipped>,
}

impl Converted {
    /// Counts of skipped persons and photographs by reason.
    pub fn skipped_by_reason(&self) -> BTreeMap<SkipReason, usize> {
        let mut counts = BTreeMap::new();
        for skipped in &self.skipped {
            *counts.entry(skipped.reason).or_default() += 1;
        }
        counts
    }
}

impl fmt::Display for Converted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} persons of {} photographs", self.persons, self.images)?;
        write!(f, "; not for training: {}", self.not_for_training)?;
        for (reason, count) in self.skipped_by_reason() {
            write!(f, "; {reason}: {count}")?;
        }
        Ok(())
    }
}
