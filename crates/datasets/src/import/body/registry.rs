//! The registry of formats of body labels.

use std::io::Read as _;
use std::path::Path;

use evpose_core::{Registry, registry_entry};

use super::format::{BodyLabelFormat, LabelledImage};
use super::{coco, csv, mpii_json, mpii_release};
use crate::import::ImportError;

/// Bytes of a file from which its format is detected.
const SNIFFED_BYTES: u64 = 4096;

/// The formats of body labels.
pub static BODY_LABEL_FORMATS: Registry<BodyLabelFormat> =
    Registry::new(&[&csv::FORMAT, &coco::FORMAT, &mpii_json::FORMAT, &mpii_release::FORMAT]);

registry_entry!(BodyLabelFormat, "format of body labels");

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

#[cfg(test)]
mod tests {
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
        assert_eq!(BODY_LABEL_FORMATS.find("coco").unwrap().name, "coco");
    }
}
