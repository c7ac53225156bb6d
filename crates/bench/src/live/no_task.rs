//! A stream that infers nothing: the cost of the input alone.

use evpose_cli::tasks::TaskStream;
use evpose_cli::tasks::online::OnlineStream;
use evpose_core::{EventStream, Micros};
use evpose_live::page::Skeleton;
use evpose_pose::PoseEstimate;
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};

/// Takes events and drops them.
struct NoTask;

pub(super) fn no_task() -> Box<dyn OnlineStream> {
    Box::new(TaskStream::new(PoseStream::new(NoTask, NoTask), 0.0, Skeleton::Body))
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
