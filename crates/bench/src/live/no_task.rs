//! A stream that infers nothing: the cost of the input alone.

use anyhow::Result;
use evpose_cli::tasks::online::OnlineStream;
use evpose_core::{EventStream, Micros};
use evpose_live::page::{HandMesh, Skeleton};
use evpose_live::sink::Sinks;
use evpose_live::source::Source;
use evpose_live::{Control, LiveError, LiveOptions, Report};
use evpose_pose::PoseEstimate;
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};

/// Takes events and drops them.
pub(super) struct NoTask;

impl OnlineStream for NoTask {
    fn run(
        self: Box<Self>,
        source: Box<dyn Source>,
        sinks: &mut Sinks,
        options: &LiveOptions,
        control: &Control,
    ) -> Result<Report, LiveError> {
        evpose_live::run(source, PoseStream::new(Self, Self), sinks, options, control)
    }

    fn propagate_hz(&self) -> f64 {
        0.0
    }

    fn skeleton(&self) -> Skeleton {
        Skeleton::Body
    }

    fn mesh(&self) -> Result<Option<HandMesh>> {
        Ok(None)
    }
}

impl StreamFrontend for NoTask {
    type Input = ();
    type Output = ();
    type Pose = PoseEstimate;

    fn push(&mut self, _: &EventStream) -> Result<(), StreamError> {
        Ok(())
    }

    fn input(&mut self, _: Micros, _: Option<()>) -> Option<()> {
        None
    }

    fn accept(&mut self, _: Micros, (): &(), (): (), _: Micros) -> Vec<(Micros, PoseEstimate)> {
        Vec::new()
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, _: Micros) -> Option<PoseEstimate> {
        None
    }

    fn reset(&mut self) {}
}

impl InferenceWorker for NoTask {
    type Input = ();
    type Output = ();

    fn infer(&mut self, (): &()) -> Result<(), StreamError> {
        Ok(())
    }
}
