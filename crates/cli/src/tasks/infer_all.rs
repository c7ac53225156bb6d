//! A recording through the stream of any task.

use std::path::Path;

use anyhow::Result;
use evpose_core::Micros;
use evpose_pose::stream::{InferenceWorker, StreamFrontend};
use evpose_task::{InferredPoses, RecordingStream};

use crate::progress::{bar, note};

/// Takes every input of a recording, which begins and ends at `span`, and hands on its poses; shows the
/// progress, and says what is odd about the file `path`.
///
/// # Errors
/// If the recording cannot be read, or the network fails.
pub fn infer_all<F, W>(
    recording: &mut RecordingStream<F, W>,
    path: &Path,
    [start, end]: [Micros; 2],
    mut take: impl FnMut(&F, InferredPoses<F::Pose>),
) -> Result<()>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let progress = bar("inferring", (end - start).0 as u64 / 1_000, "ms");
    while let Some(inferred) = recording.next().transpose()? {
        progress.set_position((inferred.t - start).0 as u64 / 1_000);
        take(&recording.stream().frontend, inferred);
    }
    progress.finish_and_clear();
    for warning in recording.warnings() {
        note(format!("warning: {}: {warning}", path.display()));
    }
    Ok(())
}
