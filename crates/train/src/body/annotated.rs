//! Images with an annotation file, as other data sets are prepared.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use evpose_core::{Micros, Plane};
use evpose_datasets::{Annotation, read_annotations};
use rayon::prelude::*;

use super::frames::{BodyFrame, BodyFrames};
use crate::TrainError;

/// Names of an annotation file and of the folder of its images in a directory.
const SETS: [(&str, &str); 2] = [("poses.json", "images"), ("train.json", "eros")];

/// The images of an annotation file, or of a directory that holds `poses.json` and `images/` or
/// `train.json` and `eros/`.
///
/// Images of a clip or of a photograph are of one sequence; sequences are numbered as they first
/// come.
pub(super) fn frames(
    data: &Path,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BodyFrames, TrainError> {
    let (annotations, images) = find(data)?;
    let annotations = read_annotations(&annotations)?;
    let frame = |(annotation, sequence): (&Annotation, u64)| {
        let path = images.join(&annotation.image);
        let problem = |message: String| TrainError::Config { path: path.clone(), message };
        let image = image::open(&path).map_err(|error| problem(error.to_string()))?.into_luma8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let image = Plane::from_vec(width, height, image.into_raw())
            .map_err(|error| problem(error.to_string()))?;
        progress(1);
        let t = Micros::from_seconds(annotation.t_s.unwrap_or(0.0));
        Ok(BodyFrame { image, label: annotation.label.clone(), sequence, t, camera: None })
    };
    let mut frames = annotations
        .par_iter()
        .zip(sequences(&annotations))
        .map(frame)
        .collect::<Result<Vec<_>, TrainError>>()?;
    // Evaluation takes runs of one sequence, in the order of time.
    frames.sort_by_key(|frame| (frame.sequence, frame.t));
    Ok(BodyFrames { frames })
}

/// Whether a path is an annotation file or a directory with one, not recordings.
pub fn holds_annotations(data: &Path) -> bool {
    let is_json = data.extension().is_some_and(|ending| ending == "json");
    is_json || SETS.iter().any(|(file, _)| data.join(file).is_file())
}

/// The annotation file and the folder of its images.
fn find(data: &Path) -> Result<(PathBuf, PathBuf), TrainError> {
    let problem = |message: &str| {
        Err(TrainError::Config { path: data.to_owned(), message: message.to_owned() })
    };
    if !data.exists() {
        return problem("there is no such file or directory");
    }
    if data.is_dir() {
        let mut sets = SETS.iter().map(|(file, images)| (data.join(file), data.join(images)));
        return match sets.find(|(file, _)| file.is_file()) {
            Some(found) => Ok(found),
            None => problem(
                "neither poses.json with images/ nor train.json with eros/ is in this directory: \
                 `evpose prepare` makes one",
            ),
        };
    }
    let beside = data.parent().unwrap_or(Path::new(""));
    let mut folders = SETS.iter().map(|(_, images)| beside.join(images));
    match folders.find(|folder| folder.is_dir()) {
        Some(images) => Ok((data.to_owned(), images)),
        None => problem("neither images/ nor eros/ is beside this file"),
    }
}

/// The index of each image's sequence.
fn sequences(annotations: &[Annotation]) -> Vec<u64> {
    let mut known = HashMap::new();
    let indices = annotations.iter().map(|annotation| {
        let next = known.len() as u64;
        *known.entry(annotation.sequence()).or_insert(next)
    });
    indices.collect()
}

#[cfg(test)]
mod tests {
    use evpose_datasets::write_annotations;
    use evpose_pose::body::BodyLabel;

    use super::*;

    fn annotation(image: &str, t_s: f64) -> Annotation {
        Annotation { image: image.to_owned(), t_s: Some(t_s), label: BodyLabel::default() }
    }

    /// Writes a set; every image is as wide as its number, from 1.
    fn write(directory: &Path, file: &str, images: &str, names: &[(&str, f64)]) {
        let folder = directory.join(images);
        std::fs::create_dir_all(&folder).unwrap();
        let annotations: Vec<_> = names.iter().map(|&(name, t_s)| annotation(name, t_s)).collect();
        write_annotations(&directory.join(file), &annotations).unwrap();
        for (width, (name, _)) in (1..).zip(names) {
            image::GrayImage::new(width, 2).save(folder.join(name)).unwrap();
        }
    }

    fn read(data: &Path) -> Vec<(usize, u64, i64)> {
        let frames = frames(data, &|_| {}).unwrap().frames;
        frames.iter().map(|frame| (frame.image.width(), frame.sequence, frame.t.0)).collect()
    }

    const NAMES: [(&str, f64); 5] = [
        ("z_00004.png", 0.08),
        ("a_1_00002.png", 0.04),
        ("z_00002.png", 0.04),
        ("a_2_00002.png", 0.04),
        ("lone.png", 0.0),
    ];
    const WANT: [(usize, u64, i64); 5] =
        [(3, 0, 40_000), (1, 0, 80_000), (2, 1, 40_000), (4, 2, 40_000), (5, 3, 0)];

    #[test]
    fn frames_of_a_clip_are_of_one_sequence_and_clips_are_counted_as_they_come() {
        for (file, images) in SETS {
            let directory = tempfile::tempdir().unwrap();
            write(directory.path(), file, images, &NAMES);
            assert_eq!(read(directory.path()), WANT);
            assert_eq!(read(&directory.path().join(file)), WANT);
        }
    }

    #[test]
    fn any_file_beside_images_can_be_read() {
        let directory = tempfile::tempdir().unwrap();
        write(directory.path(), "test.json", "eros", &NAMES);
        assert_eq!(read(&directory.path().join("test.json")), WANT);
        let failed = frames(directory.path(), &|_| {}).unwrap_err().to_string();
        assert!(failed.contains("train.json") && failed.contains("evpose prepare"), "{failed}");
    }

    #[test]
    fn what_is_missing_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("poses.json");
        let failed = frames(&file, &|_| {}).unwrap_err().to_string();
        assert!(failed.contains("no such file"), "{failed}");
        write_annotations(&file, &[annotation("a_0.png", 0.0)]).unwrap();
        let failed = frames(&file, &|_| {}).unwrap_err().to_string();
        assert!(failed.contains("poses.json") && failed.contains("images/"), "{failed}");
        std::fs::create_dir(directory.path().join("images")).unwrap();
        let failed = frames(&file, &|_| {}).unwrap_err().to_string();
        assert!(failed.contains("a_0.png"), "{failed}");
    }

    #[test]
    fn whole_clips_are_held_back() {
        let directory = tempfile::tempdir().unwrap();
        write(directory.path(), "poses.json", "images", &NAMES);
        let (train, valid) = frames(directory.path(), &|_| {}).unwrap().split(0.5);
        let of = |frames: &BodyFrames| frames.frames.iter().map(|f| f.sequence).collect::<Vec<_>>();
        assert_eq!((of(&train), of(&valid)), (vec![0, 0, 1], vec![2, 3]));
    }
}
