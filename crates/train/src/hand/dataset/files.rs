//! The sequences of a directory, by their labels.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::TrainError;
use crate::listing::file_names;

/// Ending of labels, with the dot.
const LABELS: &str = ".meta";
/// Ending of the events of EventHands, with the dot.
const EVC: &str = ".evc";

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SequenceFiles {
    /// Path without an ending.
    pub(super) stem: PathBuf,
    /// File of the events: `.evc`, or of any other format.
    pub(super) events: PathBuf,
    /// File of the labels.
    pub(super) labels: PathBuf,
}

/// The sequences of `directory`, in the order of their names: labels in a `.meta` file, with events
/// of any format beside them.
///
/// # Errors
/// If the directory cannot be read or has no labels, or labels have no events or several files of
/// them.
pub(super) fn sequence_files(directory: &Path) -> Result<Vec<SequenceFiles>, TrainError> {
    let names = file_names(directory)?;
    // Events without labels are an error where their format has no other use than to be labelled.
    let stem = |name: &String| {
        let stem = name.strip_suffix(LABELS).or_else(|| name.strip_suffix(EVC))?;
        Some(stem.to_owned())
    };
    let stems: BTreeSet<String> = names.iter().filter_map(stem).collect();
    if stems.is_empty() {
        return Err(TrainError::Config {
            path: directory.to_owned(),
            message: format!(
                "no labels of hands here (0000{LABELS}, with 0000{EVC} or another recording beside it): \
                 record some with `evpose simulate CONFIG --out DIR`"
            ),
        });
    }
    let files = |stem: String| -> Result<SequenceFiles, TrainError> {
        let labels = directory.join(format!("{stem}{LABELS}"));
        let mut recordings: Vec<&str> = evpose_io::recordings_by_stem(&names, &stem).collect();
        // An .evc file wins over copies in other formats.
        if recordings.iter().any(|name| name.ends_with(EVC)) {
            recordings.retain(|name| name.ends_with(EVC));
        }
        let [events] = recordings[..] else {
            let message = match recordings[..] {
                [] => format!("no recording beside it, such as {stem}{EVC} or {stem}.raw"),
                _ => format!("several recordings beside it: keep one of {}", recordings.join(", ")),
            };
            return Err(TrainError::Config { path: labels, message });
        };
        let events = directory.join(events);
        Ok(SequenceFiles { stem: directory.join(stem), events, labels })
    };
    stems.into_iter().map(files).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events_of(names: &[&str]) -> Result<Vec<String>, TrainError> {
        let directory = tempfile::tempdir().unwrap();
        names.iter().for_each(|name| std::fs::write(directory.path().join(name), "").unwrap());
        let files = sequence_files(directory.path())?;
        let name = |files: SequenceFiles| files.events.file_name().unwrap().to_owned();
        Ok(files.into_iter().map(|files| name(files).into_string().unwrap()).collect())
    }

    #[test]
    fn labels_lead_to_events_of_any_format() {
        let names = ["1.meta", "1.raw", "0.evc", "0.meta", "0.toml", "0.sha256", "2.h5", "2.meta"];
        assert_eq!(events_of(&names).unwrap(), ["0.evc", "1.raw", "2.h5"]);
        assert_eq!(events_of(&["0.evc", "0.meta", "0.npz"]).unwrap(), ["0.evc"]);
        assert_eq!(events_of(&["a.b.meta", "a.b.aedat4", "a.raw"]).unwrap(), ["a.b.aedat4"]);
    }

    #[test]
    fn what_is_missing_or_ambiguous_is_named() {
        for (names, want) in [
            (&["0.raw"][..], "no labels of hands"),
            (&["0.meta", "0.toml"], "0.meta: no recording beside it, such as 0.evc"),
            (&["0.meta", "0.h5", "0.raw"], "keep one of 0.h5, 0.raw"),
        ] {
            let message = events_of(names).unwrap_err().to_string();
            assert!(message.contains(want), "{message}");
        }
    }
}
