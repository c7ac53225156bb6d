//! What can go wrong between a recording and the viewer.

use std::io;
use std::path::PathBuf;

use re_sdk::RecordingStreamError;
use re_sdk::external::re_log_encoding::EncodeError;
use re_sdk::sink::SinkFlushError;

/// A recording that could not be written or sent.
#[derive(Debug, thiserror::Error)]
pub enum RerunError {
    /// The file cannot be begun or finished.
    #[error("writing {}", path.display())]
    File {
        /// Its name.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A message cannot be written to the file.
    #[error("writing {}", path.display())]
    Encode {
        /// Its name.
        path: PathBuf,
        /// What the SDK says.
        source: EncodeError,
    },
    /// The address is no viewer's.
    #[error("{address}: expected HOST:PORT or rerun+http://HOST:PORT/proxy")]
    Address {
        /// As it was given.
        address: String,
        /// What the SDK says.
        source: RecordingStreamError,
    },
    /// No viewer answers, or it went away.
    #[error("the Rerun viewer at {address}")]
    Viewer {
        /// Where it should be.
        address: String,
        /// What the SDK says.
        source: SinkFlushError,
    },
    /// Data that the SDK refuses.
    #[error(transparent)]
    Stream(#[from] RecordingStreamError),
}
