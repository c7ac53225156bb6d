//! The registry of formats of body labels.

use std::io::Read as _;
use std::path::Path;

use evpose_pose::body::BodyPoints;

use super::{coco, csv, mpii_json, mpii_release};
use crate::ImportError;
use crate::clock::ImageTime;

/// Bytes of a file from which its format is detected.
const SNIFFED_BYTES: u64 = 4096;

/// Labels of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledImage {
    /// Its time.
    pub time: ImageTime,
    /// Width and height of the image that the labels are on, in pixels; none where it is not known.
    pub size_px: Option<[f32; 2]>,
    /// Joints of each person, in pixels; empty for an image without annotations.
    pub persons: Vec<BodyPoints>,
}

/// A format of body labels. Adding one is a file with its `FORMAT` and a line of
/// [`BODY_LABEL_FORMATS`].
#[derive(Debug)]
pub struct BodyLabelFormat {
    /// Name, as `--format` takes it.
    pub name: &'static str,
    /// Content in a few words.
    pub summary: &'static str,
    /// Whether a file is of this format, by its path and its first bytes.
    pub(super) detect: fn(&Path, &[u8]) -> bool,
    /// Reads the labels of a file, in its order.
    pub(super) read: fn(&Path) -> Result<Vec<LabelledImage>, ImportError>,
}

/// The formats of body labels.
pub static BODY_LABEL_FORMATS: &[&BodyLabelFormat] =
    &[&csv::FORMAT, &coco::FORMAT, &mpii_json::FORMAT, &mpii_release::FORMAT];

/// The format called `name`.
pub fn body_label_format_by_name(name: &str) -> Option<&'static BodyLabelFormat> {
    BODY_LABEL_FORMATS.iter().copied().find(|format| format.name == name)
}

/// Reads a label file, in the given format or the detected one.
///
/// # Errors
/// If the file cannot be read, is of no known format, or violates it.
pub fn read_body_labels(
    path: &Path,
    format: Option<&BodyLabelFormat>,
) -> Result<Vec<LabelledImage>, ImportError> {
    match format {
        Some(format) => (format.read)(path),
        None => (detect(path)?.read)(path),
    }
}

fn detect(path: &Path) -> Result<&'static BodyLabelFormat, ImportError> {
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(ImportError::io(path, "open"))?;
    file.take(SNIFFED_BYTES).read_to_end(&mut start).map_err(ImportError::io(path, "read"))?;
    let detected = BODY_LABEL_FORMATS.iter().copied().find(|format| (format.detect)(path, &start));
    detected.ok_or_else(|| {
        let known: Vec<String> = BODY_LABEL_FORMATS
            .iter()
            .map(|format| format!("{} ({})", format.name, format.summary))
            .collect();
        ImportError::UnknownFormat { path: path.to_owned(), known: known.join(", ") }
    })
}

/// Whether a path has an ending, in either case.
pub(super) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

/// The first character of a text that is not white space.
pub(super) fn first_character(start: &[u8]) -> Option<u8> {
    start.iter().copied().find(|byte| !byte.is_ascii_whitespace())
}

/// The error for a fault in a JSON file.
pub(super) fn json_fault(path: &Path) -> impl FnOnce(serde_json::Error) -> ImportError {
    move |error| {
        let place = format!("line {} column {}", error.line(), error.column());
        ImportError::malformed(path, place, error.to_string())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn formats_are_detected_by_ending_and_first_character() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text, want) in [
            ("a.csv", "t_us", Some("csv")),
            ("a.json", " {\"images\"", Some("coco")),
            ("b.json", "\n[{", Some("mpii-json")),
            ("a.mat", "MATLAB", Some("mpii")),
            ("a.xml", "<a>", None),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            match (detect(&path), want) {
                (Ok(format), Some(want)) => assert_eq!(format.name, want),
                (Err(error), None) => {
                    let message = error.to_string();
                    assert!(message.contains("a.xml") && message.contains("coco"), "{message}");
                }
                (detected, want) => panic!("{name}: {detected:?}, {want:?}"),
            }
        }
        assert_eq!(body_label_format_by_name("coco").unwrap().name, "coco");
    }
}
