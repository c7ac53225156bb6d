//! Names of clips, and the paths of their files.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Indices and serials of the cameras.
pub(super) const SERIALS: [(u8, &str); 4] =
    [(1, "54138969"), (2, "55011271"), (3, "58860488"), (4, "60457274")];
/// Cameras in front of the person, which the set is made of.
pub const FRONT_CAMERAS: [u8; 2] = [2, 4];
/// Subjects with labels.
pub const SUBJECTS: [u8; 7] = [1, 5, 6, 7, 8, 9, 11];
/// Those that are tested on; networks are trained on the others.
pub const TEST_SUBJECTS: [u8; 2] = [9, 11];

/// A clip of one camera. Shown as its folder is called: `cam2_S9_Walking_1`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipName {
    camera: u8,
    subject: u8,
    action: String,
}

impl ClipName {
    /// A clip of a camera from 1 to 4. Blanks in the name of the action become `_`.
    pub fn new(camera: u8, subject: u8, action: &str) -> Option<Self> {
        let is_camera = SERIALS.iter().any(|(number, _)| *number == camera);
        // The name becomes that of a directory, and must not lead out of its parent.
        let is_action = !action.is_empty() && !action.contains(['/', '\\', '.']);
        let action = action.replace(' ', "_");
        (is_camera && SUBJECTS.contains(&subject) && is_action).then_some(Self {
            camera,
            subject,
            action,
        })
    }

    /// The camera, from 1.
    pub fn camera(&self) -> u8 {
        self.camera
    }

    /// Number of the subject, as in `S9`.
    pub fn subject(&self) -> u8 {
        self.subject
    }

    /// Whether networks are tested on it.
    pub fn is_test(&self) -> bool {
        TEST_SUBJECTS.contains(&self.subject)
    }

    /// Poses of the original data set, below its folder:
    /// `S9/Poses_D2_Positions/Walking 1.55011271.cdf`.
    pub fn poses(&self, root: &Path) -> PathBuf {
        root.join(format!("S{}/Poses_D2_Positions/{}.cdf", self.subject, self.original()))
    }

    /// Folder of the frames of its video, below a given one: those of `S9/Videos/Walking
    /// 1.55011271.mp4` are in `S9/Videos/Walking 1.55011271`.
    pub fn frames(&self, root: &Path) -> PathBuf {
        root.join(format!("S{}/Videos/{}", self.subject, self.original()))
    }

    /// Name of its files in the original data set, without an extension.
    fn original(&self) -> String {
        let serial = SERIALS.iter().find(|(number, _)| *number == self.camera);
        let serial = serial.map_or("", |(_, serial)| serial);
        format!("{}.{serial}", self.action.replace('_', " "))
    }

    /// The folder of events in that of a published clip.
    pub(super) fn events_folder(clip: &Path) -> PathBuf {
        clip.join("ch0dvs")
    }

    /// Name of the folder of labels in that of a published clip.
    pub(super) fn labels_channel(&self) -> String {
        format!("ch{}GT50Hzskeleton", self.camera)
    }
}

impl fmt::Display for ClipName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("cam{}_S{}_{}", self.camera, self.subject, self.action))
    }
}

impl FromStr for ClipName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = || {
            let (camera, rest) = text.strip_prefix("cam")?.split_once("_S")?;
            let (subject, action) = rest.split_once('_')?;
            Self::new(camera.parse().ok()?, subject.parse().ok()?, action)
        };
        let expected = "cam2_S9_Walking_1 or the like is expected, of cameras 1 to 4 and subjects";
        parsed().ok_or_else(|| format!("`{text}` is no clip: {expected} {SUBJECTS:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_consists_of_camera_subject_and_action() {
        for text in ["cam2_S9_Walking_1", "cam4_S11_Directions"] {
            assert_eq!(text.parse::<ClipName>().unwrap().to_string(), text);
        }
        let name = ClipName::new(2, 9, "Walking 1").unwrap();
        assert_eq!(name.to_string(), "cam2_S9_Walking_1");
        assert!(name.is_test() && !ClipName::new(4, 1, "Eating").unwrap().is_test());
        let poses = name.poses(Path::new("h"));
        assert_eq!(poses, Path::new("h/S9/Poses_D2_Positions/Walking 1.55011271.cdf"));
        let frames = name.frames(Path::new("h"));
        assert_eq!(frames, Path::new("h/S9/Videos/Walking 1.55011271"));
    }

    #[test]
    fn other_names_are_refused() {
        for text in ["cam5_S9_Walking", "cam2_S2_Walking", "cam2_S9_", "cam2_S9_../x", "S9_Walking"]
        {
            assert!(text.parse::<ClipName>().unwrap_err().contains(text), "{text}");
        }
    }
}
