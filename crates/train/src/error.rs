//! Errors of training and evaluation.

use std::path::PathBuf;

use evpose_task::FieldDifference;

/// A training or evaluation that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
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
    /// A config that cannot be read.
    #[error("{}: {message}", path.display())]
    Config {
        /// The config or checkpoint.
        path: PathBuf,
        /// The field, and the values it may have.
        message: String,
    },
    /// A directory that was made with another config than the one given.
    #[error(
        "{}: the directory was made with another config:{}\nGive the same config, or another --out",
        path.display(),
        fields.iter().map(|field| format!("\n  {field}")).collect::<String>()
    )]
    ConfigDiffers {
        /// The config of the directory.
        path: PathBuf,
        /// The fields that differ.
        fields: Vec<FieldDifference>,
    },
    /// A config whose values contradict each other or the data.
    #[error("config field `{field}`: {message}")]
    Field {
        /// Dotted name of the field.
        field: &'static str,
        /// The fault and the remedy.
        message: String,
    },
    /// Event or label files.
    #[error(transparent)]
    Data(#[from] evpose_io::IoError),
    /// Representations.
    #[error(transparent)]
    Representation(#[from] evpose_repr::ReprError),
    /// The camera of recordings.
    #[error(transparent)]
    Camera(#[from] evpose_camera::CalibrationError),
    /// Filters and metrics.
    #[error(transparent)]
    Pose(#[from] evpose_pose::PoseError),
    /// Simulation.
    #[error(transparent)]
    Simulation(#[from] evpose_sim::SimError),
    /// Networks and weight files.
    #[error(transparent)]
    Network(#[from] evpose_nn::NnError),
    /// Configs, checkpoints, predictors.
    #[error(transparent)]
    Task(#[from] evpose_task::TaskError),
    /// Annotations of images.
    #[error(transparent)]
    Annotations(#[from] evpose_datasets::DatasetError),
    /// A loss that is not finite.
    #[error(
        "the {}loss became {loss} at step {step}; training stopped. The last good checkpoint is {}. \
         Lower `training.learning_rate` or look at the data around that step, then --resume",
        if *is_validation { "validation " } else { "" },
        checkpoint.as_ref().map_or("none: no validation was reached yet".to_owned(),
            |path| path.display().to_string())
    )]
    Diverged {
        /// The value seen.
        loss: f64,
        /// Optimiser step, counted from the start of the run.
        step: u64,
        /// Whether the loss is that of the validation after the step.
        is_validation: bool,
        /// Weights saved last.
        checkpoint: Option<PathBuf>,
    },
    /// Burn stopped for another reason.
    #[error("training stopped: {0}")]
    Stopped(String),
    /// A directory that another process trains in.
    #[error(
        "{}: process {process} trains there: wait until it has ended, or choose another --out",
        path.display()
    )]
    InUse {
        /// The run directory.
        path: PathBuf,
        /// Id of the process.
        process: String,
    },
    /// A new run in the directory of another, which nobody asked to continue.
    #[error(
        "{} already holds a training: choose another --out, or add --resume to \
         continue that training", path.display()
    )]
    HoldsTraining {
        /// The run directory.
        path: PathBuf,
    },
}
