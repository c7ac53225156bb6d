//! Joints as the JSON into which programs convert MPII's annotations: a list of `image`, `joints`
//! (16 positions) and `joints_vis`.
//!
//! A joint of visibility 0, or at a negative position, is not labelled. The head is the middle
//! between upper neck and top of the head, where MPII's box has its middle.
//!
//! # Source
//! The annotation files of Xiao, Wu, Wei: *Simple Baselines for Human Pose Estimation and
//! Tracking*, ECCV 2018, which other programs adopted.

use std::path::Path;

use crate::DatasetError;
use evpose_core::{Micros, without_bom};

use crate::mpii::MPII_INDEX;
use evpose_pose::body::{BODY_JOINTS, BodyPoints, number};
use glam::Vec2;
use serde::Deserialize;

use super::format::{BodyLabelFormat, LabelledImage, first_character, has_ending};
use crate::import::ImportError;
use crate::import::clock::ImageTime;

pub(super) static FORMAT: BodyLabelFormat = BodyLabelFormat {
    name: "mpii-json",
    summary: "a JSON list of image, joints and joints_vis in MPII's order",
    detect: |path, start| has_ending(path, "json") && first_character(start) == Some(b'['),
    read,
};

/// MPII's joints.
const MPII_JOINTS: usize = 16;
/// MPII's indices of upper neck and top of the head.
const HEAD: [usize; 2] = [8, 9];

#[derive(Debug, Deserialize)]
struct Entry {
    image: String,
    joints: Vec<[f32; 2]>,
    #[serde(default)]
    joints_vis: Option<Vec<f32>>,
    #[serde(default, alias = "timestamp_us")]
    t_us: Option<f64>,
}

fn read(path: &Path) -> Result<Vec<LabelledImage>, ImportError> {
    let text = std::fs::read_to_string(path).map_err(ImportError::io(path, "read"))?;
    let entries: Vec<Entry> =
        serde_json::from_str(without_bom(&text)).map_err(DatasetError::json(path))?;
    let mut images: Vec<(String, LabelledImage)> = Vec::new();
    for (index, entry) in entries.into_iter().enumerate() {
        let points = points(&entry).map_err(|(field, reason)| {
            ImportError::malformed(path, format!("[{index}].{field}"), reason)
        })?;
        // Persons of one image follow each other.
        match images.last_mut().filter(|(image, _)| *image == entry.image) {
            Some((_, image)) => image.persons.push(points),
            None => {
                let time = match entry.t_us {
                    Some(t_us) => ImageTime::Stamp(Micros(t_us.round() as i64)),
                    None => ImageTime::Name(entry.image.clone()),
                };
                let image = LabelledImage { time, size_px: None, persons: vec![points] };
                images.push((entry.image, image));
            }
        }
    }
    Ok(images.into_iter().map(|(_, image)| image).collect())
}

/// The joints of an entry, or the field at fault and the reason.
fn points(entry: &Entry) -> Result<BodyPoints, (&'static str, String)> {
    let fault =
        |field, length: usize| Err((field, format!("{length} joints, expected {MPII_JOINTS}")));
    if entry.joints.len() != MPII_JOINTS {
        return fault("joints", entry.joints.len());
    }
    if let Some(visible) = entry.joints_vis.as_ref().filter(|visible| visible.len() != MPII_JOINTS)
    {
        return fault("joints_vis", visible.len());
    }
    let at = |index: usize| {
        let at_px = Vec2::from(entry.joints[index]);
        // Converters write negative positions for joints that are not known.
        let is_visible = entry.joints_vis.as_ref().is_none_or(|visible| visible[index] > 0.0);
        (is_visible && at_px.min_element() >= 0.0).then_some(at_px)
    };
    let mut joints_px = [None; BODY_JOINTS];
    // The middle of neck and top is what other sets call the head.
    joints_px[number::HEAD] = at(HEAD[0]).zip(at(HEAD[1])).map(|(neck, top)| (neck + top) / 2.0);
    for (joint, index) in (1..).zip(MPII_INDEX) {
        joints_px[joint] = at(index);
    }
    Ok(joints_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Vec<LabelledImage>, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("valid.json");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    fn joints() -> String {
        let joints: Vec<String> = (0..16).map(|k| format!("[{k},{}]", 10 * k)).collect();
        format!("[{}]", joints.join(","))
    }

    #[test]
    fn sixteen_joints_become_thirteen_and_persons_share_an_image() {
        let visible = "[0,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1]";
        let images = of(&format!(
            "[{{\"image\":\"f1.jpg\",\"joints\":{joints},\"joints_vis\":{visible}}},\
             {{\"image\":\"f1.jpg\",\"joints\":{joints}}},\
             {{\"image\":\"f2.jpg\",\"joints\":{joints},\"t_us\":5}}]",
            joints = joints()
        ))
        .unwrap();
        assert_eq!(images.len(), 2);
        let [hidden, seen] = [images[0].persons[0], images[0].persons[1]];
        assert_eq!(hidden[number::ANKLE_R], None);
        assert_eq!(seen[number::ANKLE_R], Some(Vec2::ZERO));
        assert_eq!(seen[number::HEAD], Some(Vec2::new(8.5, 85.0)));
        assert_eq!(seen[number::WRIST_L], Some(Vec2::new(15.0, 150.0)));
        assert_eq!(images[1].time, ImageTime::Stamp(Micros(5)));
    }

    #[test]
    fn a_mark_of_byte_order_is_no_content() {
        let text = format!("\u{feff}[{{\"image\":\"f1.jpg\",\"joints\":{}}}]", joints());
        assert_eq!(of(&text).unwrap().len(), 1);
        assert!((FORMAT.detect)(Path::new("valid.json"), text.as_bytes()));
    }

    #[test]
    fn faults_name_the_entry_and_its_field() {
        let message = of("[{\"image\":\"a\",\"joints\":[[1,2]]}]").unwrap_err().to_string();
        assert!(message.contains("valid.json: [0].joints: 1 joints, expected 16"), "{message}");
        let message = of("[{\"image_id\":1,\"keypoints\":[]}]").unwrap_err().to_string();
        assert!(message.contains("missing field"), "{message}");
    }
}
