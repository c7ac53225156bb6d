//! The registry of formats of hand labels.

use std::path::Path;

use evpose_core::{Registry, registry_entry};

use super::format::{HandLabelFormat, HandLabels, LabelChoice};
use super::{joints, parameters};
use crate::import::ImportError;
use crate::import::table::{Table, listed};

/// The formats of hand labels.
pub static HAND_LABEL_FORMATS: Registry<HandLabelFormat> =
    Registry::new(&[&parameters::FORMAT, &joints::FORMAT]);

registry_entry!(HandLabelFormat, "format of hand labels");

/// Reads a label file: a CSV with a column `t_us` or `t_s`.
///
/// # Errors
/// If the file cannot be read, is of no known format, or violates it.
pub fn read_hand_labels(path: &Path, choice: LabelChoice) -> Result<HandLabels, ImportError> {
    let table = Table::read(path)?;
    let mut formats = HAND_LABEL_FORMATS.iter();
    let Some(format) = formats.find(|format| (format.detect)(table.columns())) else {
        let known: Vec<String> = HAND_LABEL_FORMATS
            .iter()
            .map(|format| format!("{} ({})", format.name, format.summary))
            .collect();
        let known = format!("{}; its columns are {}", known.join(", "), listed(table.columns()));
        return Err(ImportError::UnknownFormat { path: path.to_owned(), known });
    };
    (format.read)(&table, choice)
}
