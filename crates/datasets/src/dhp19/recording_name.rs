//! The list of recordings, the names of their files, and their known faults.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Subjects, from 1 on.
pub const SUBJECTS: u8 = 17;
/// Movements of each session.
pub const MOVEMENTS: [u8; 5] = [8, 6, 6, 6, 7];
/// Subjects that the authors test on; they train on the others.
///
/// # Source
/// Calabrese et al., *DHP19*, CVPRW 2019, Sec. 4.
pub const TEST_SUBJECTS: [u8; 5] = [13, 14, 15, 16, 17];

/// A movement of a subject. Shown as the files are called: `S1_2_5`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Dhp19Name {
    subject: u8,
    session: u8,
    movement: u8,
}

/// Something that is known to be wrong with recordings or labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnownFault {
    /// Recording that has it; none means all.
    pub recording: Option<Dhp19Name>,
    /// Whether the recording is of no use.
    pub is_fatal: bool,
    /// The fault, and its treatment.
    pub what: &'static str,
}

const fn named(subject: u8, session: u8, movement: u8) -> Dhp19Name {
    Dhp19Name { subject, session, movement }
}

const CORRUPTED: &str = "hundreds of pulses and no movement to be found between them: left out";

const NO_LEFT_HIP: &str = "the marker of the left hip is missing throughout: it is not labelled";

/// Known faults.
///
/// # Source
/// Comments of the published `Generate_DHP19.m`; issues 13 and 23 of its repository, the second of
/// which the authors have not answered; Goyal et al., *MoveEnet*, CVPRW 2023, Sec. 4.1.3.
pub const KNOWN_FAULTS: &[KnownFault] = &[
    KnownFault { recording: Some(named(4, 3, 4)), is_fatal: true, what: CORRUPTED },
    KnownFault { recording: Some(named(4, 3, 6)), is_fatal: true, what: CORRUPTED },
    KnownFault {
        recording: Some(named(14, 1, 1)),
        is_fatal: false,
        what: "the clock of 32 bits runs over; the authors read up to there, here it is unwrapped",
    },
    KnownFault {
        recording: Some(named(14, 5, 3)),
        is_fatal: false,
        what: "no pulse at all: the movement is taken to be the whole recording",
    },
    KnownFault { recording: Some(named(14, 4, 3)), is_fatal: false, what: NO_LEFT_HIP },
    KnownFault { recording: Some(named(14, 4, 4)), is_fatal: false, what: NO_LEFT_HIP },
    KnownFault { recording: Some(named(14, 4, 5)), is_fatal: false, what: NO_LEFT_HIP },
    KnownFault { recording: Some(named(14, 4, 6)), is_fatal: false, what: NO_LEFT_HIP },
    KnownFault {
        recording: Some(named(1, 2, 6)),
        is_fatal: false,
        what: "the left and the right hip seem to be exchanged at times; kept as it is",
    },
    KnownFault {
        recording: Some(named(2, 4, 5)),
        is_fatal: false,
        what: "the right elbow and the right hand seem to be exchanged at times; kept as it is",
    },
    KnownFault {
        recording: None,
        is_fatal: false,
        what: "labels are markers on the skin, that of the head on top of it: they are not the \
               centres of joints that other sets label, and a network of the one is wrong on the other",
    },
    KnownFault {
        recording: None,
        is_fatal: false,
        what: "the published generator of .h5 files writes the right hip before the left one, other \
               programs the left one first; here joints are taken by name",
    },
];

impl Dhp19Name {
    /// The recording of a subject from 1, a session from 1 and a movement from 1, if there is one.
    pub fn new(subject: u8, session: u8, movement: u8) -> Option<Self> {
        let movements = *MOVEMENTS.get(usize::from(session).checked_sub(1)?)?;
        let exists = (1..=SUBJECTS).contains(&subject) && (1..=movements).contains(&movement);
        exists.then_some(Self { subject, session, movement })
    }

    /// All of them, those too that are known to be of no use.
    pub fn all() -> impl Iterator<Item = Self> {
        let movements = MOVEMENTS.iter().zip(1..);
        let of_one = movements.flat_map(|(&last, session)| (1..=last).map(move |m| (session, m)));
        (1..=SUBJECTS).flat_map(move |subject| {
            of_one.clone().map(move |(session, movement)| Self { subject, session, movement })
        })
    }

    /// The person, from 1.
    pub fn subject(self) -> u8 {
        self.subject
    }

    /// Whether the authors test on it.
    pub fn is_test(self) -> bool {
        TEST_SUBJECTS.contains(&self.subject)
    }

    /// Known faults of this recording, or of all.
    pub fn faults(self) -> impl Iterator<Item = &'static KnownFault> {
        KNOWN_FAULTS.iter().filter(move |fault| fault.recording.is_none_or(|of| of == self))
    }

    /// Whether it is of any use.
    pub fn is_usable(self) -> bool {
        !self.faults().any(|fault| fault.is_fatal)
    }

    /// Its movie below the folder of the data set: `DVS_movies/S1/session2/mov5.aedat`.
    pub fn movie(self, root: &Path) -> PathBuf {
        let Self { subject, session, movement } = self;
        root.join(format!("DVS_movies/S{subject}/session{session}/mov{movement}.aedat"))
    }

    /// Its joints below the folder of the data set: `Vicon_data/S1_2_5.mat`.
    pub fn vicon(self, root: &Path) -> PathBuf {
        root.join(format!("Vicon_data/{self}.mat"))
    }
}

impl fmt::Display for Dhp19Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("S{}_{}_{}", self.subject, self.session, self.movement))
    }
}

impl FromStr for Dhp19Name {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = || {
            let mut indices = text.strip_prefix('S')?.split('_').map(|number| number.parse().ok());
            let name = Self::new(indices.next()??, indices.next()??, indices.next()??)?;
            indices.next().is_none().then_some(name)
        };
        parsed().ok_or_else(|| {
            format!("`{text}` is no recording of DHP19: S1_1_1 to S{SUBJECTS}_5_7 are expected")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_33_movements_of_17_subjects_and_two_are_of_no_use() {
        assert_eq!(Dhp19Name::all().count(), 17 * 33);
        let lost: Vec<_> = Dhp19Name::all().filter(|name| !name.is_usable()).collect();
        assert_eq!(lost, [named(4, 3, 4), named(4, 3, 6)]);
        assert_eq!(Dhp19Name::all().filter(|name| name.is_test()).count(), 5 * 33);
        assert!(Dhp19Name::all().all(|name| name.to_string().parse() == Ok(name)));
        assert_eq!(named(1, 1, 1).faults().count(), 2);
    }

    #[test]
    fn files_are_where_the_data_set_has_them() {
        let name: Dhp19Name = "S12_5_7".parse().unwrap();
        let root = Path::new("d");
        assert_eq!(name.movie(root), Path::new("d/DVS_movies/S12/session5/mov7.aedat"));
        assert_eq!(name.vicon(root), Path::new("d/Vicon_data/S12_5_7.mat"));
    }

    #[test]
    fn what_does_not_exist_has_no_name() {
        for text in ["S18_1_1", "S0_1_1", "S1_6_1", "S1_0_1", "S1_2_7", "S1_1", "S1_1_1_1", "1_1_1"]
        {
            assert!(text.parse::<Dhp19Name>().unwrap_err().contains(text), "{text}");
        }
    }
}
