//! Keypoints as COCO's JSON: `images`, `annotations` and, where they differ from COCO's 17, the
//! names of the keypoints in `categories`.
//!
//! An image has a time stamp if it has a field `t_us` or `timestamp_us`. Keypoints of visibility 0
//! are not labelled. The head is the mean of the labelled ones of nose, eyes and ears.
//!
//! # Source
//! <https://cocodataset.org/#format-data>, keypoint detection.

use std::collections::HashMap;
use std::path::Path;

use evpose_core::Micros;
use evpose_pose::body::{BodyPoints, COCO_KEYPOINT_NAMES};
use glam::Vec2;
use serde::Deserialize;

use super::format::{BodyLabelFormat, LabelledImage, first_character, has_ending, json_fault};
use super::joint_names::{Keypoint, joints, keypoint_by_name};
use crate::ImportError;
use crate::clock::ImageTime;

/// The format.
pub(super) static FORMAT: BodyLabelFormat = BodyLabelFormat {
    name: "coco",
    summary: "COCO's JSON of keypoints",
    detect: |path, start| has_ending(path, "json") && first_character(start) == Some(b'{'),
    read,
};

#[derive(Debug, Deserialize)]
struct File {
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    #[serde(default)]
    categories: Vec<Category>,
}

#[derive(Debug, Deserialize)]
struct Image {
    id: i64,
    #[serde(default)]
    file_name: String,
    #[serde(default)]
    width: Option<f32>,
    #[serde(default)]
    height: Option<f32>,
    #[serde(default, alias = "timestamp_us")]
    t_us: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Annotation {
    image_id: i64,
    #[serde(default)]
    category_id: Option<i64>,
    /// `x, y, visibility` of each.
    #[serde(default)]
    keypoints: Vec<f32>,
}

#[derive(Debug, Deserialize)]
struct Category {
    id: i64,
    #[serde(default)]
    keypoints: Vec<String>,
}

fn read(path: &Path) -> Result<Vec<LabelledImage>, ImportError> {
    let text = std::fs::read_to_string(path).map_err(ImportError::io(path, "read"))?;
    let file: File = serde_json::from_str(&text).map_err(json_fault(path))?;
    let standard: Vec<Option<Keypoint>> =
        COCO_KEYPOINT_NAMES.iter().map(|name| keypoint_by_name(name)).collect();
    let named = file.categories.iter().filter(|category| !category.keypoints.is_empty());
    let named: HashMap<i64, Vec<Option<Keypoint>>> = named
        .map(|category| {
            (category.id, category.keypoints.iter().map(|name| keypoint_by_name(name)).collect())
        })
        .collect();
    let mut images = Vec::with_capacity(file.images.len());
    let mut index_of_id = HashMap::new();
    for (index, image) in file.images.into_iter().enumerate() {
        if index_of_id.insert(image.id, index).is_some() {
            let place = format!("images[{index}].id");
            return Err(ImportError::malformed(path, place, format!("{} occurs twice", image.id)));
        }
        let time = match image.t_us {
            Some(t_us) => ImageTime::Stamp(Micros(t_us.round() as i64)),
            None => ImageTime::Name(image.file_name),
        };
        let size_px = image.width.zip(image.height).map(|(width, height)| [width, height]);
        images.push(LabelledImage { time, size_px, persons: Vec::new() });
    }
    for (index, annotation) in file.annotations.iter().enumerate() {
        let fault = |field: &str, reason: String| {
            ImportError::malformed(path, format!("annotations[{index}].{field}"), reason)
        };
        let Some(&image) = index_of_id.get(&annotation.image_id) else {
            let reason = format!("no image has the id {}", annotation.image_id);
            return Err(fault("image_id", reason));
        };
        // Boxes and masks without keypoints are of other tasks.
        if annotation.keypoints.is_empty() {
            continue;
        }
        let names = annotation.category_id.and_then(|id| named.get(&id)).unwrap_or(&standard);
        let points =
            points(&annotation.keypoints, names).map_err(|reason| fault("keypoints", reason))?;
        images[image].persons.push(points);
    }
    Ok(images)
}

/// The joints of an annotation.
fn points(values: &[f32], names: &[Option<Keypoint>]) -> Result<BodyPoints, String> {
    let expected = 3 * names.len();
    if values.len() != expected {
        return Err(format!(
            "{} values, expected {expected}: x, y, visibility of each",
            values.len()
        ));
    }
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(format!("{value} is not a position"));
    }
    let labelled = values.as_chunks::<3>().0.iter().zip(names);
    let labelled = labelled.filter(|([_, _, visibility], _)| *visibility > 0.0);
    Ok(joints(labelled.filter_map(|([x, y, _], name)| Some(((*name)?, Vec2::new(*x, *y))))))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_pose::body::number;

    use super::*;

    fn of(text: &str) -> Result<Vec<LabelledImage>, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("coco.json");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    /// Keypoint `k` at (k, 2 k), visible where `visible` says so.
    fn keypoints(count: usize, visible: impl Fn(usize) -> u8) -> String {
        let triples: Vec<String> =
            (0..count).map(|k| format!("{k},{},{}", 2 * k, visible(k))).collect();
        format!("[{}]", triples.join(","))
    }

    #[test]
    fn seventeen_keypoints_become_thirteen_joints() {
        let keypoints = keypoints(17, |k| if k == 16 || k == 1 { 0 } else { 1 + (k % 2) as u8 });
        let images = of(&format!(
            "{{\"images\":[{{\"id\":7,\"file_name\":\"a_1.png\",\"width\":346,\"height\":260}},\
             {{\"id\":8,\"timestamp_us\":99.0}}],\
             \"annotations\":[{{\"image_id\":7,\"keypoints\":{keypoints}}},{{\"image_id\":8}}]}}"
        ))
        .unwrap();
        assert_eq!(images[0].time, ImageTime::Name("a_1.png".to_owned()));
        assert_eq!(images[0].size_px, Some([346.0, 260.0]));
        let joints_px = images[0].persons[0];
        // The mean of 0, 2, 3 and 4.
        assert_eq!(joints_px[number::HEAD], Some(Vec2::new(2.25, 4.5)));
        assert_eq!(joints_px[number::SHOULDER_L], Some(Vec2::new(5.0, 10.0)));
        assert_eq!(joints_px[number::ANKLE_R], None);
        assert_eq!(images[1].time, ImageTime::Stamp(Micros(99)));
        assert!(images[1].persons.is_empty());
    }

    #[test]
    fn keypoints_may_be_named_by_their_category() {
        let images =
            of("{\"images\":[{\"id\":1}],\"annotations\":[{\"image_id\":1,\"category_id\":3,\
             \"keypoints\":[1,2,2,3,4,2]}],\
             \"categories\":[{\"id\":3,\"keypoints\":[\"tail\",\"wrist_r\"]}]}")
            .unwrap();
        assert_eq!(images[0].persons[0][number::WRIST_R], Some(Vec2::new(3.0, 4.0)));
        assert_eq!(images[0].persons[0].iter().flatten().count(), 1);
    }

    #[test]
    fn faults_name_the_annotation_and_its_field() {
        let file = |annotation: &str| {
            format!("{{\"images\":[{{\"id\":1}}],\"annotations\":[{annotation}]}}")
        };
        for (text, want) in [
            (file("{\"image_id\":2}"), "annotations[0].image_id: no image has the id 2"),
            (
                file("{\"image_id\":1,\"keypoints\":[1,2]}"),
                "annotations[0].keypoints: 2 values, expected 51",
            ),
            (file("{\"id\":1}"), "missing field `image_id`"),
            ("{\"images\":[{\"id\":1},{\"id\":1}],\"annotations\":[]}".to_owned(), "images[1].id"),
            ("{".to_owned(), "line 1 column 1"),
        ] {
            let message = of(&text).unwrap_err().to_string();
            assert!(message.contains("coco.json") && message.contains(want), "{message}");
        }
    }
}
