//! What can go wrong online.

use std::io;

/// Why a pipeline cannot begin, or ended before its source did.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A recording or a stream is damaged, or cannot be read.
    #[error(transparent)]
    Io(#[from] evpose_io::IoError),
    /// A connection failed.
    #[error("{what}: {source}")]
    Connection {
        /// What was connected to, or listened on.
        what: String,
        /// The reason.
        source: io::Error,
    },
    /// A setting that makes no sense.
    #[error("{what} is {value}: {rule}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// What it was.
        value: String,
        /// What it may be.
        rule: &'static str,
    },
    /// A source that says it is something else than it is, or that ended for a reason of its own.
    #[error("{what}: {reason}")]
    Source {
        /// Which source.
        what: String,
        /// The reason, and what to do.
        reason: String,
    },
    /// A stage of the stream failed.
    #[error("{0}")]
    Task(Box<dyn std::error::Error + Send + Sync>),
    /// Poses cannot be written any more.
    #[error("{sink}: {source}")]
    Sink {
        /// Which sink.
        sink: String,
        /// The reason.
        source: io::Error,
    },
}

impl From<evpose_pose::stream::StreamError> for LiveError {
    fn from(error: evpose_pose::stream::StreamError) -> Self {
        Self::Task(error.0)
    }
}
