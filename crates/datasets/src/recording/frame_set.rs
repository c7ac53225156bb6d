//! Frames of many recordings as the set that a network is trained and tested on.

use std::path::{Path, PathBuf};

use super::{ErosFrameOptions, LabelledRecording, write_eros_frames};
use crate::{Annotation, DatasetError, write_annotations};

/// A set of frames: images in `eros`, what is on them in `train.json` and `test.json`.
#[derive(Debug)]
pub struct FrameSet {
    folder: PathBuf,
    options: ErosFrameOptions,
    train: Vec<Annotation>,
    test: Vec<Annotation>,
}

impl FrameSet {
    /// A set in `folder`, which is made if need be.
    pub fn new(folder: &Path, options: ErosFrameOptions) -> Self {
        Self { folder: folder.to_owned(), options, train: Vec::new(), test: Vec::new() }
    }

    /// Writes the frames of a recording; returns what is on them, for [`add`](Self::add). Several
    /// recordings may be drawn at a time.
    ///
    /// # Errors
    /// As [`write_eros_frames`].
    pub fn draw(&self, recording: &LabelledRecording) -> Result<Vec<Annotation>, DatasetError> {
        write_eros_frames(recording, &self.options, &self.folder.join("eros"))
    }

    /// Takes frames in that were drawn, to train or to test on.
    pub fn add(&mut self, frames: Vec<Annotation>, is_test: bool) {
        if is_test { &mut self.test } else { &mut self.train }.extend(frames);
    }

    /// Writes what is on all frames; returns how many are trained and tested on.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(self) -> Result<[usize; 2], DatasetError> {
        write_annotations(&self.folder.join("train.json"), &self.train)?;
        write_annotations(&self.folder.join("test.json"), &self.test)?;
        Ok([self.train.len(), self.test.len()])
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, Micros, SensorSize};
    use glam::Vec2;

    use super::*;
    use crate::{TimedBody, read_annotations};

    #[test]
    fn frames_are_where_annotations_say() {
        let directory = tempfile::tempdir().unwrap();
        let mut set = FrameSet::new(directory.path(), ErosFrameOptions::default());
        for (name, bodies, is_test) in [("a", 5, false), ("b", 4, true), ("c", 3, false)] {
            let body = |k| TimedBody { t: Micros(k), points_px: [Some(Vec2::ONE); 13] };
            let recording = LabelledRecording {
                name: name.to_owned(),
                events: EventStream::empty(SensorSize { width: 8, height: 6 }),
                bodies: (0..bodies).map(body).collect(),
            };
            let frames = set.draw(&recording).unwrap();
            // By default the first two instants have no image.
            assert_eq!(frames.len(), bodies as usize - 2);
            set.add(frames, is_test);
        }
        assert_eq!(set.finish().unwrap(), [4, 2]);
        for (file, want) in [("train.json", 4), ("test.json", 2)] {
            let found = read_annotations(&directory.path().join(file)).unwrap();
            assert_eq!(found.len(), want);
            let is_there = |a: &Annotation| directory.path().join("eros").join(&a.image).is_file();
            assert!(found.iter().all(is_there));
        }
    }
}
