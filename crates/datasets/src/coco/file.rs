//! The file: `images`, `annotations` and, where they differ from COCO's 17, the names of the
//! keypoints in `categories`.

use std::collections::HashMap;
use std::path::Path;

use evpose_core::bytes_without_bom;
use evpose_pose::body::{BodyPoints, COCO_KEYPOINT_NAMES, Visibility};
use glam::Vec2;
use serde::Deserialize;

use super::keypoint::{NamedKeypoint, joints, keypoint_by_name};
use crate::DatasetError;

/// An image and the persons on it.
#[derive(Debug, Clone, PartialEq)]
pub struct CocoImage {
    /// Its file; empty where the file does not say.
    pub file_name: String,
    /// Width and height in pixels; none where the file does not say.
    pub size_px: Option<[f32; 2]>,
    /// Its time stamp in microseconds, the field `t_us` or `timestamp_us`, which COCO does not have.
    pub t_us: Option<f64>,
    /// Annotations with keypoints, in their order.
    pub persons: Vec<CocoPerson>,
}

/// A person.
#[derive(Debug, Clone, PartialEq)]
pub struct CocoPerson {
    /// Labelled keypoints of known names, in pixels of the image.
    pub keypoints: Vec<(NamedKeypoint, Vec2, Visibility)>,
    /// Whether it is a crowd in one annotation.
    pub is_crowd: bool,
}

impl CocoPerson {
    /// The joints in pixels: the head is the mean of the labelled points of the face.
    pub fn joints_px(&self) -> BodyPoints {
        joints(self.keypoints.iter().map(|&(name, at_px, _)| (name, at_px)))
    }
}

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
    #[serde(default)]
    iscrowd: u8,
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

/// Reads the file at `path`.
///
/// # Errors
/// If it cannot be read, or violates the format: the message names the annotation and its field.
pub fn read_keypoints(path: &Path) -> Result<Vec<CocoImage>, DatasetError> {
    parse(path, &std::fs::read(path).map_err(DatasetError::io(path, "read it"))?)
}

/// Reads the bytes of the file at `path`.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<CocoImage>, DatasetError> {
    let bytes = bytes_without_bom(bytes);
    let file: File = serde_json::from_slice(bytes).map_err(DatasetError::json(path))?;
    let keypoints = |names: &mut dyn Iterator<Item = &str>| names.map(keypoint_by_name).collect();
    // Files without categories have COCO's own names.
    let standard: Vec<_> = keypoints(&mut COCO_KEYPOINT_NAMES.iter().copied());
    let named = file.categories.iter().filter(|category| !category.keypoints.is_empty());
    let named: HashMap<i64, Vec<Option<NamedKeypoint>>> = named
        .map(|category| {
            (category.id, keypoints(&mut category.keypoints.iter().map(String::as_str)))
        })
        .collect();
    let mut images = Vec::with_capacity(file.images.len());
    // Annotations name images by id, in any order.
    let mut index_of_id = HashMap::new();
    for (index, image) in file.images.into_iter().enumerate() {
        if index_of_id.insert(image.id, index).is_some() {
            let place = format!("images[{index}].id");
            return Err(DatasetError::malformed(path, place, format!("{} occurs twice", image.id)));
        }
        let size_px = image.width.zip(image.height).map(|(width, height)| [width, height]);
        let Image { file_name, t_us, .. } = image;
        images.push(CocoImage { file_name, size_px, t_us, persons: Vec::new() });
    }
    for (index, annotation) in file.annotations.iter().enumerate() {
        let fault = |field: &str, reason: String| {
            DatasetError::malformed(path, format!("annotations[{index}].{field}"), reason)
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
        let of_values = |reason| fault("keypoints", reason);
        let keypoints = labelled(&annotation.keypoints, names, of_values)?;
        images[image].persons.push(CocoPerson { keypoints, is_crowd: annotation.iscrowd != 0 });
    }
    Ok(images)
}

/// The labelled keypoints of an annotation: those of visibility 0 are not. `fault` names its place.
fn labelled(
    values: &[f32],
    names: &[Option<NamedKeypoint>],
    fault: impl Fn(String) -> DatasetError,
) -> Result<Vec<(NamedKeypoint, Vec2, Visibility)>, DatasetError> {
    let expected = 3 * names.len();
    if values.len() != expected {
        let count = values.len();
        return Err(fault(format!(
            "{count} values, expected {expected}: x, y, visibility of each"
        )));
    }
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(fault(format!("{value} is not a position")));
    }
    let triples = values.as_chunks::<3>().0.iter().zip(names);
    // COCO's codes: 0 is not labelled, 1 hidden, 2 visible.
    // Keypoints that have no name here are left out.
    let keypoint = |(&[x, y, visibility], name): (&[f32; 3], &Option<NamedKeypoint>)| {
        let seen = if visibility >= 2.0 { Visibility::Visible } else { Visibility::Hidden };
        (visibility > 0.0).then_some(((*name)?, Vec2::new(x, y), seen))
    };
    Ok(triples.filter_map(keypoint).collect())
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::number;

    use super::*;

    fn of(text: &str) -> Result<Vec<CocoImage>, DatasetError> {
        parse(Path::new("coco.json"), text.as_bytes())
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
        assert_eq!(images[0].file_name, "a_1.png");
        assert_eq!(images[0].size_px, Some([346.0, 260.0]));
        let joints_px = images[0].persons[0].joints_px();
        // The mean of 0, 2, 3 and 4.
        assert_eq!(joints_px[number::HEAD], Some(Vec2::new(2.25, 4.5)));
        assert_eq!(joints_px[number::SHOULDER_L], Some(Vec2::new(5.0, 10.0)));
        assert_eq!(joints_px[number::ANKLE_R], None);
        assert_eq!(images[1].t_us, Some(99.0));
        assert!(images[1].persons.is_empty());
    }

    #[test]
    fn keypoints_may_be_named_by_their_category() {
        let images =
            of("{\"images\":[{\"id\":1}],\"annotations\":[{\"image_id\":1,\"category_id\":3,\
             \"keypoints\":[1,2,2,3,4,2]}],\
             \"categories\":[{\"id\":3,\"keypoints\":[\"tail\",\"wrist_r\"]}]}")
            .unwrap();
        assert_eq!(images[0].persons[0].joints_px()[number::WRIST_R], Some(Vec2::new(3.0, 4.0)));
        assert_eq!(images[0].persons[0].keypoints.len(), 1);
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
