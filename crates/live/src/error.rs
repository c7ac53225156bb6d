//! Errors of the online pipeline.

use std::io;

/// A failure to start a pipeline, or one that ended it before its source did.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A recording or a stream is damaged, or cannot be read.
    #[error(transparent)]
    Io(#[from] evpose_io::IoError),
    /// A connection failed.
    #[error("{endpoint}: {source}")]
    Connection {
        /// Address that was connected to or listened on.
        endpoint: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A setting outside its valid range.
    #[error("{setting} is {value}: {rule}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value that was given.
        value: String,
        /// Its valid range.
        rule: &'static str,
    },
    /// A source with an unknown format, or one that failed.
    #[error("{name}: {reason}")]
    Source {
        /// Name of the source.
        name: String,
        /// The reason, and how to fix it.
        reason: String,
    },
    /// A stage of the stream failed.
    #[error("{0}")]
    Task(Box<dyn std::error::Error + Send + Sync>),
    /// A sink failed to write poses.
    #[error("{sink}: {source}")]
    Sink {
        /// Name of the sink.
        sink: String,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl From<evpose_pose::stream::StreamError> for LiveError {
    fn from(error: evpose_pose::stream::StreamError) -> Self {
        Self::Task(error.0)
    }
}
