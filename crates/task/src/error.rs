//! Errors of tasks.

use std::path::PathBuf;

/// A config, a checkpoint or a stream that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TaskError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A network that cannot be compiled.
    #[error(transparent)]
    Engine(#[from] evpose_infer::InferError),
    /// A precision that only our engine computes in.
    #[error(
        "--precision {precision} is for our engine, on --device flex: other devices compute in f32"
    )]
    Precision {
        /// Precision that was asked for.
        precision: evpose_infer::Precision,
    },
    /// A config or a checkpoint that cannot be read.
    #[error("{}: {message}", path.display())]
    Config {
        /// The config or checkpoint.
        path: PathBuf,
        /// The field, and the values it may have.
        message: String,
    },
    /// A config whose values contradict each other or the data.
    #[error("config field `{field}`: {message}")]
    Field {
        /// Dotted name of the field.
        field: &'static str,
        /// The fault and the remedy.
        message: String,
    },
    /// A number of a config that is outside of its range.
    #[error("config field `{field}`: {value} is not from {min} to {max}")]
    Range {
        /// Dotted name of the field.
        field: String,
        /// Value that was given.
        value: f64,
        /// The least that it may be.
        min: f64,
        /// The most that it may be.
        max: f64,
    },
    /// Event or label files.
    #[error(transparent)]
    Data(#[from] evpose_io::IoError),
    /// Representations.
    #[error(transparent)]
    Representation(#[from] evpose_repr::ReprError),
    /// The camera of a recording.
    #[error(transparent)]
    Camera(#[from] evpose_camera::CalibrationError),
    /// Filters and decoders.
    #[error(transparent)]
    Pose(#[from] evpose_pose::PoseError),
    /// Simulation settings, body models.
    #[error(transparent)]
    Simulation(#[from] evpose_sim::SimError),
    /// Networks and weight files.
    #[error(transparent)]
    Network(#[from] evpose_nn::NnError),
    /// A stage of a stream.
    #[error(transparent)]
    Stream(#[from] evpose_pose::stream::StreamError),
    /// A layer whose values int8 cannot represent.
    #[error(
        "layer `{layer}`: no finite values of it on {windows} inputs, and int8 needs their range: \
         calibrate on other data, or use --precision f32"
    )]
    NoRange {
        /// Path of the layer.
        layer: String,
        /// Number of inputs observed.
        windows: u64,
    },
    /// A network that predicts values that are not finite.
    #[error("the network predicted {value}: the checkpoint is damaged or diverged")]
    NotFinite {
        /// The first such value.
        value: f32,
    },
}

impl From<TaskError> for evpose_pose::stream::StreamError {
    fn from(error: TaskError) -> Self {
        Self::new(error)
    }
}
