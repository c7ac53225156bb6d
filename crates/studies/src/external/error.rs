//! Errors of running networks of others.

use std::path::PathBuf;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExternalError {
    /// The program has no runtime.
    #[error(
        "{}: this program was built without the runtime of ONNX files: build it with \
         `cargo build --release --features onnx`", path.display()
    )]
    NotBuilt {
        /// The network file.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// File that was refused.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file is no network that the runtime takes.
    #[error("{}: no ONNX network that tract runs: {reason}", path.display())]
    Unreadable {
        /// The weight file.
        path: PathBuf,
        /// The runtime's message.
        reason: String,
    },
    /// A network takes something else than one image of three channels.
    #[error("{}: its input is {shape}; one image of three channels is needed, [1, 3, height, width] or [1, height, width, 3]", path.display())]
    Input {
        /// The network file.
        path: PathBuf,
        /// Its input, in words.
        shape: String,
    },
    /// A network outputs something else than its kind does.
    #[error("{}: no network of {system}: its outputs are {shape}; needed: {needed}", path.display())]
    Output {
        /// The network file.
        path: PathBuf,
        /// The kind of network.
        system: &'static str,
        /// Shapes of its outputs, in words.
        shape: String,
        /// Shapes of the outputs of this kind, in words.
        needed: &'static str,
    },
    /// The network failed.
    #[error("{}: running it: {reason}", path.display())]
    Run {
        /// The network file.
        path: PathBuf,
        /// The runtime's message.
        reason: String,
    },
}
