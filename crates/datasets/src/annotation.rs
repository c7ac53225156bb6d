//! The annotation file of the published training: a JSON array on one line.

use std::path::Path;

use evpose_core::{atomic_write, bytes_without_bom};
use evpose_pose::body::{BodyLabel, Keypoint, Visibility};
use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::DatasetError;

/// An image and the person on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// File of the image, relative to the folder of images.
    pub image: String,
    /// When it was taken, in seconds, if that is known.
    pub t_s: Option<f64>,
    /// Joints of the person on it, in its pixels.
    pub label: BodyLabel,
}

impl Annotation {
    /// The photograph or the clip that the image is of: its name without `_`, digits and an ending
    /// behind it, or all of its name.
    pub fn sequence(&self) -> &str {
        let name = &self.image;
        let stem = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem);
        match stem.rsplit_once('_') {
            Some((sequence, number))
                if !sequence.is_empty()
                    && !number.is_empty()
                    && number.bytes().all(|byte| byte.is_ascii_digit()) =>
            {
                sequence
            }
            _ => name,
        }
    }
}

/// A size, or the empty list that published annotations have where it is not known.
fn size<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<f32>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Size {
        Known(f32),
        Unknown([f32; 0]),
    }
    Ok(match Option::<Size>::deserialize(deserializer)? {
        Some(Size::Known(size)) => Some(size),
        Some(Size::Unknown([])) | None => None,
    })
}

/// An entry as written.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Entry {
    img_name: String,
    keypoints: Vec<f32>,
    center: [f32; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ts: Option<f64>,
    #[serde(default, deserialize_with = "size", skip_serializing_if = "Option::is_none")]
    head_size: Option<f32>,
    #[serde(default, deserialize_with = "size", skip_serializing_if = "Option::is_none")]
    head_size_scaled: Option<f32>,
    #[serde(default, deserialize_with = "size", skip_serializing_if = "Option::is_none")]
    torso_size: Option<f32>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    other_centers: Vec<[f32; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    other_keypoints: Vec<Vec<[f32; 2]>>,
}

/// Reads an annotation file. Fields it does not know are passed over.
///
/// # Errors
/// If it cannot be read, is no JSON of this form (the message says where), or a joint is not of
/// three values, the last of which is 0, 1 or 2.
pub fn read_annotations(path: &Path) -> Result<Vec<Annotation>, DatasetError> {
    let bytes = std::fs::read(path).map_err(DatasetError::io(path, "read it"))?;
    let entries: Vec<Entry> =
        serde_json::from_slice(bytes_without_bom(&bytes)).map_err(DatasetError::json(path))?;
    entries.into_iter().enumerate().map(|(index, entry)| from_entry(path, index, entry)).collect()
}

/// Writes an annotation file: one line, as published readers take it. It appears when it is
/// complete.
///
/// # Errors
/// If it cannot be written.
pub fn write_annotations(path: &Path, annotations: &[Annotation]) -> Result<(), DatasetError> {
    let entries: Vec<Entry> = annotations.iter().map(to_entry).collect();
    let bytes = serde_json::to_vec(&entries)
        .map_err(|error| DatasetError::malformed(path, "annotations", error.to_string()))?;
    atomic_write(path, &bytes).map_err(DatasetError::io(path, "write it"))
}

fn from_entry(path: &Path, index: usize, entry: Entry) -> Result<Annotation, DatasetError> {
    let place = |field: &str| format!("entry {index} ({}), `{field}`", entry.img_name);
    let (joints, rest) = entry.keypoints.as_chunks::<3>();
    // Values that are left over belong to a joint that was cut off.
    if !rest.is_empty() {
        let reason = format!("{} values: three a joint are expected", entry.keypoints.len());
        return Err(DatasetError::malformed(path, place("keypoints"), reason));
    }
    let keypoints = joints
        .iter()
        .map(|&[x, y, z]| {
            // Numbered as COCO does.
            let visibility = match z {
                0.0 => Visibility::Unlabelled,
                1.0 => Visibility::Hidden,
                2.0 => Visibility::Visible,
                _ => {
                    let reason = format!("a visibility of {z}: it is 0, 1 or 2");
                    return Err(DatasetError::malformed(path, place("keypoints"), reason));
                }
            };
            Ok(Keypoint { position: Vec2::new(x, y), visibility })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let points = |points: &[[f32; 2]]| points.iter().map(|&point| Vec2::from(point)).collect();
    let label = BodyLabel {
        keypoints,
        center: entry.center.into(),
        head_size: entry.head_size,
        head_size_scaled: entry.head_size_scaled,
        torso_size: entry.torso_size,
        other_centers: points(&entry.other_centers),
        other_keypoints: entry.other_keypoints.iter().map(|joint| points(joint)).collect(),
    };
    Ok(Annotation { image: entry.img_name, t_s: entry.ts, label })
}

fn to_entry(annotation: &Annotation) -> Entry {
    let label = &annotation.label;
    let keypoint = |keypoint: &Keypoint| {
        // These are the values of COCO.
        let visibility = match keypoint.visibility {
            Visibility::Unlabelled => 0.0,
            Visibility::Hidden => 1.0,
            Visibility::Visible => 2.0,
        };
        [keypoint.position.x, keypoint.position.y, visibility]
    };
    let points = |points: &[Vec2]| points.iter().map(Vec2::to_array).collect();
    Entry {
        img_name: annotation.image.clone(),
        keypoints: label.keypoints.iter().flat_map(keypoint).collect(),
        center: label.center.into(),
        ts: annotation.t_s,
        head_size: label.head_size,
        head_size_scaled: label.head_size_scaled,
        torso_size: label.torso_size,
        other_centers: points(&label.other_centers),
        other_keypoints: label.other_keypoints.iter().map(|joint| points(joint)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn annotation() -> Annotation {
        let keypoint = |i: usize| Keypoint {
            position: Vec2::new(0.05 * i as f32, 1.0 - 0.05 * i as f32),
            visibility: [Visibility::Visible, Visibility::Hidden, Visibility::Unlabelled][i % 3],
        };
        let label = BodyLabel {
            keypoints: (0..13).map(keypoint).collect(),
            center: Vec2::new(0.5, 0.25),
            torso_size: Some(0.3),
            other_centers: vec![Vec2::new(0.125, 0.75)],
            ..BodyLabel::default()
        };
        Annotation { image: "a/b_00001.png".to_owned(), t_s: Some(0.02), label }
    }

    #[test]
    fn what_was_written_is_read_back_from_one_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("poses.json");
        write_annotations(&path, &[annotation(), annotation()]).unwrap();
        assert_eq!(read_annotations(&path).unwrap(), [annotation(), annotation()]);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), 1);
        // Editors add a mark of byte order.
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        assert_eq!(read_annotations(&path).unwrap(), [annotation(), annotation()]);
    }

    #[test]
    fn the_name_of_an_image_contains_its_sequence() {
        for (image, want) in [
            ("cam2_S9_Walking_1_00002.png", "cam2_S9_Walking_1"),
            ("b.b_0.png", "b.b"),
            ("clips/S1_2_5_ch3_00010.jpg", "clips/S1_2_5_ch3"),
            ("015601864.jpg", "015601864.jpg"),
            ("left_hand.png", "left_hand.png"),
            ("a_.png", "a_.png"),
            ("_7.png", "_7.png"),
            ("", ""),
        ] {
            let annotation = Annotation { image: image.to_owned(), ..annotation() };
            assert_eq!(annotation.sequence(), want);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("poses.json");
        let complaint = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_annotations(&path).unwrap_err().to_string()
        };
        let message = complaint(r#"[{"img_name":"x.png","keypoints":[0.1,0.2],"center":[0,0]}]"#);
        assert!(message.contains("x.png") && message.contains("keypoints"), "{message}");
        let message = complaint(r#"[{"img_name":"x.png","keypoints":[0,0,3],"center":[0,0]}]"#);
        assert!(message.contains("visibility of 3"), "{message}");
        assert!(complaint("[{\"img_name\": 3}]").contains("column"));
    }
}
