//! Errors of files and viewers.

use std::io;
use std::path::PathBuf;

use re_sdk::RecordingStreamError;
use re_sdk::external::re_log_encoding::EncodeError;
use re_sdk::sink::SinkFlushError;

/// A recording that could not be written or sent.
#[derive(Debug, thiserror::Error)]
pub enum RerunError {
    /// The file cannot be created or finished.
    #[error("writing {}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A message cannot be written to the file.
    #[error("writing {}", path.display())]
    Encode {
        /// Path of the file.
        path: PathBuf,
        /// Error of the SDK.
        source: EncodeError,
    },
    /// The address is malformed.
    #[error("{address}: expected HOST:PORT or rerun+http://HOST:PORT/proxy")]
    Address {
        /// The address as given.
        address: String,
        /// Error of the SDK.
        source: RecordingStreamError,
    },
    /// No viewer answers, or the connection was lost.
    #[error("the Rerun viewer at {address}")]
    Viewer {
        /// Address of the viewer.
        address: String,
        /// Error of the SDK.
        source: SinkFlushError,
    },
    /// Data that the SDK refuses.
    #[error(transparent)]
    Stream(#[from] RecordingStreamError),
}
