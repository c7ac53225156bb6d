//! The streams of any task, for the online pipeline.

use anyhow::Result;
use burn::tensor::Device;
use evpose_live::page::{HandMesh, Skeleton};
use evpose_live::sink::Sinks;
use evpose_live::source::Source;
use evpose_live::{Control, LiveError, LiveOptions, Report};
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamFrontend};

/// Inputs per inference on devices other than the CPU, as EventHands published.
const DEVICE_BATCH: usize = 16;

/// Inputs per inference: as asked for, or else 1 on the CPU and [`DEVICE_BATCH`] on other devices.
pub(crate) fn batch(asked: Option<u16>, device: &Device) -> usize {
    asked.map_or(if *device == Device::flex() { 1 } else { DEVICE_BATCH }, usize::from)
}

/// A stream from events to poses that the online pipeline can run.
pub trait OnlineStream {
    /// Runs the pipeline, see [`evpose_live::run`].
    ///
    /// # Errors
    /// As [`evpose_live::run`].
    fn run(
        self: Box<Self>,
        source: Box<dyn Source>,
        sinks: &mut Sinks,
        options: &LiveOptions,
        control: &Control,
    ) -> Result<Report, LiveError>;

    /// Propagated poses per second by default.
    fn propagate_hz(&self) -> f64;

    /// Skeleton of the poses.
    fn skeleton(&self) -> Skeleton;

    /// A new mesh of the pose, for tasks that have one.
    ///
    /// # Errors
    /// If the file of its model cannot be read.
    fn mesh(&self) -> Result<Option<HandMesh>>;
}

/// Makes the mesh of a pose.
type MeshMaker = Box<dyn Fn() -> Result<HandMesh>>;

/// A stream with the properties of its task.
pub struct TaskStream<F: StreamFrontend, W> {
    stream: PoseStream<F, W>,
    propagate_hz: f64,
    skeleton: Skeleton,
    mesh: Option<MeshMaker>,
}

impl<F: StreamFrontend, W> TaskStream<F, W> {
    /// A stream whose poses are propagated `propagate_hz` times a second by default, 0 for never.
    pub fn new(stream: PoseStream<F, W>, propagate_hz: f64, skeleton: Skeleton) -> Self {
        Self { stream, propagate_hz, skeleton, mesh: None }
    }

    /// The same, its poses with the meshes that `mesh` makes.
    #[must_use]
    pub(crate) fn with_mesh(self, mesh: impl Fn() -> Result<HandMesh> + 'static) -> Self {
        Self { mesh: Some(Box::new(mesh)), ..self }
    }
}

impl<F, W> OnlineStream for TaskStream<F, W>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    fn run(
        self: Box<Self>,
        source: Box<dyn Source>,
        sinks: &mut Sinks,
        options: &LiveOptions,
        control: &Control,
    ) -> Result<Report, LiveError> {
        evpose_live::run(source, self.stream, sinks, options, control)
    }

    fn propagate_hz(&self) -> f64 {
        self.propagate_hz
    }

    fn skeleton(&self) -> Skeleton {
        self.skeleton
    }

    fn mesh(&self) -> Result<Option<HandMesh>> {
        self.mesh.as_ref().map(|make| make()).transpose()
    }
}
