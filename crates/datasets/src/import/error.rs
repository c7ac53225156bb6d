//! Errors of importing recordings and labels.

use std::path::PathBuf;

use crate::DatasetError;
use evpose_core::Micros;
use evpose_io::IoError;
use evpose_sim::SimError;
use evpose_task::TaskError;

/// Error of importing a recording with its labels.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A label file of none of the known formats.
    #[error("{}: labels of no known format: expected {known}", path.display())]
    UnknownFormat {
        /// The label file.
        path: PathBuf,
        /// Names and descriptions of the formats.
        known: String,
    },
    /// Labels without a time stamp.
    #[error(
        "{}: {place}: no time stamp: give the frame rate of the images (--fps), or their time as the \
         field `t_us`", path.display()
    )]
    NoTime {
        /// The label file.
        path: PathBuf,
        /// Name or index of the image in it.
        place: String,
    },
    /// No label has a time stamp within the recording.
    #[error(
        "{}: labels from {} s to {} s, but the recording has events from {} s to {} s: are both of the \
         same clock? (--start-us)",
        path.display(), labels[0].as_seconds(), labels[1].as_seconds(),
        events[0].as_seconds(), events[1].as_seconds()
    )]
    Apart {
        /// The label file.
        path: PathBuf,
        /// Time stamps of the first and the last label.
        labels: [Micros; 2],
        /// Time stamps of the first and the last event.
        events: [Micros; 2],
    },
    /// A recording without events, or a label file without labels.
    #[error("{}: no {content}", path.display())]
    Empty {
        /// File that lacks it.
        path: PathBuf,
        /// The missing content, a plural.
        content: &'static str,
    },
    /// A file that an import would overwrite.
    #[error("{}: exists already: choose another --out, or remove it", path.display())]
    Exists {
        /// File that is there already.
        path: PathBuf,
    },
    /// A recording cannot be read or written.
    #[error(transparent)]
    Recording(#[from] IoError),
    /// A table of poses or the description of a sequence cannot be written.
    #[error(transparent)]
    Sequence(#[from] SimError),
    /// The hand model of a config cannot be read.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// A file cannot be read or written, or violates its format.
    #[error(transparent)]
    DataSet(#[from] DatasetError),
}

impl ImportError {
    /// As [`DatasetError::io`].
    pub(crate) fn io(
        path: impl Into<PathBuf>,
        action: &'static str,
    ) -> impl FnOnce(std::io::Error) -> Self {
        let error = DatasetError::io(path, action);
        move |source| error(source).into()
    }

    /// As [`DatasetError::malformed`].
    pub(crate) fn malformed(
        path: impl Into<PathBuf>,
        place: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        DatasetError::malformed(path, place, reason).into()
    }
}
