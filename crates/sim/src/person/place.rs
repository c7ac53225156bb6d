//! The camera of a recording, out of the metadata beside it.

use std::path::Path;

use evpose_core::PlacedCamera;
use serde::Deserialize;

use crate::SimError;

/// Key by which a camera in metadata is recognised: other programs have a `camera` as well.
const PLACE: &str = "opencv_camera_from_world";

/// The scene of a recording and its camera in the world.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RecordingPlace {
    /// The scene, where several cameras see it.
    pub scene: Option<u64>,
    /// The camera; none where it moves or is not known.
    pub camera: Option<PlacedCamera>,
}

#[derive(Deserialize)]
struct Metadata {
    scene: Option<toml::Value>,
    camera: Option<toml::Value>,
}

impl RecordingPlace {
    /// Reads the metadata of a recording, `0007.toml`, and passes over all else in it. A file that
    /// does not exist, or has no place, gives the default.
    ///
    /// # Errors
    /// If the file cannot be read, is no TOML, or has a camera that is none.
    pub fn read(path: &Path) -> Result<Self, SimError> {
        if !path.is_file() {
            return Ok(Self::default());
        }
        let malformed = |reason: String| SimError::SequenceInfo { path: path.to_owned(), reason };
        let text =
            std::fs::read_to_string(path).map_err(|source| SimError::file(path, "read", source))?;
        let Metadata { scene, camera } =
            toml::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        // Other metadata may have a `camera` too, a serial number for example; a place has a
        // position.
        let camera = camera.filter(|camera| camera.get(PLACE).is_some());
        Ok(Self {
            scene: scene
                .and_then(|scene| scene.as_integer())
                .and_then(|scene| scene.try_into().ok()),
            camera: camera
                .map(|camera| camera.try_into())
                .transpose()
                .map_err(|error: toml::de::Error| malformed(format!("camera: {error}")))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<RecordingPlace, SimError> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("0000.toml");
        std::fs::write(&path, text).unwrap();
        RecordingPlace::read(&path)
    }

    #[test]
    fn other_keys_are_passed_over_and_a_damaged_camera_is_an_error() {
        let camera = "[camera]\nfocal_px = [300.0, 300.0]\nprincipal_px = [173.0, 130.0]\n\
            opencv_camera_from_world = [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.0], [0.0, 0.0, -1.0, 3.0]]\n";
        let place = read(&format!("mesh = \"other\"\nscene = 3\n{camera}")).unwrap();
        assert_eq!((place.scene, place.camera.is_some()), (Some(3), true));
        let none = RecordingPlace::default();
        assert_eq!(read("camera = \"static\"\nscene = \"a hall\"\n").unwrap(), none);
        assert_eq!(RecordingPlace::read(Path::new("nowhere.toml")).unwrap(), none);
        let message = read(&camera.replace("300.0, 300.0", "0.0, 300.0")).unwrap_err().to_string();
        assert!(message.contains("camera") && message.contains("focal_px"), "{message}");
    }
}
