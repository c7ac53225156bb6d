//! Size of a sensor as the file beside a recording states it.

use std::path::{Path, PathBuf};

use evpose_core::SensorSize;
use evpose_sim::SequenceInfo;
use serde::Deserialize;

/// The part of the file of `evpose events` that is read.
#[derive(Deserialize)]
struct EventsInfo {
    frames: FrameSize,
}

#[derive(Deserialize)]
struct FrameSize {
    width: u16,
    height: u16,
}

/// The file beside a recording that states the size of its sensor, and this size: `NAME.toml` of a
/// simulation, or `NAME.EXTENSION.toml` of `evpose events`. None if there is no such file.
pub fn sensor_beside(recording: &Path) -> Option<(PathBuf, SensorSize)> {
    let stem = recording.with_extension("");
    // A file of this name may be anything: one that is not of a simulation is none.
    if let Ok(Some(info)) = SequenceInfo::beside(&stem) {
        return Some((recording.with_extension("toml"), info.sensor));
    }
    let mut path = recording.to_path_buf().into_os_string();
    path.push(".toml");
    let text = std::fs::read_to_string(&path).ok()?;
    let EventsInfo { frames: FrameSize { width, height } } = toml::from_str(&text).ok()?;
    Some((path.into(), SensorSize { width, height }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_simulations_and_of_frames_state_the_sensor_and_others_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("rec.evc");
        let beside = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            sensor_beside(&recording).map(|(path, sensor)| {
                (path.file_name().unwrap().to_string_lossy().into_owned(), sensor.to_string())
            })
        };
        let found = |name: &str, size: &str| Some((name.to_owned(), size.to_owned()));
        assert_eq!(beside("rec.toml", "focal_px = 300"), None, "a calibration");
        let frames = "seed = 0\n[frames]\ncount = 9\nwidth = 32\nheight = 24\n";
        assert_eq!(beside("rec.evc.toml", frames), found("rec.evc.toml", "32x24"));
        let sensor = "[sensor]\nwidth = 240\nheight = 180\n";
        assert_eq!(beside("rec.toml", sensor), found("rec.toml", "240x180"));
    }
}
