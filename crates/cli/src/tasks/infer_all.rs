//! A recording through the stream of any task.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_core::Micros;
use evpose_io::poses::{PoseKind, TimedPose, write_poses_from};
use evpose_pose::PoseOrigin;
use evpose_pose::stream::{InferenceWorker, RemainingEvents, StreamFrontend};
use evpose_task::{InferredPoses, RecordingStream};

use super::args::{InferArgs, OneRecordingArgs, format_of};
use crate::bad_input::NobodyInView;
use crate::progress::{bar, note, say};

/// Share of the events of a moving edge below which a step has taken most of them.
const FEW: f64 = 0.2;

/// Counts of an inference: they say why it found nobody.
#[derive(Debug, Clone)]
pub struct InferenceCounts {
    /// Events that are left after each step.
    pub events: Vec<RemainingEvents>,
    /// Times without an inference, because too few events had come.
    pub too_few: u64,
    /// Inferred poses, those of nobody included.
    pub inferred: u64,
}

/// Scores of poses and their threshold, of a task that has them.
#[derive(Debug, Clone, Copy)]
pub struct PoseScores {
    /// The highest score; none without a pose.
    pub best: Option<f32>,
    /// Poses of a lower score are of nobody.
    pub min_score: f32,
}

impl InferenceCounts {
    /// Prints how many of the rows in `out` are of nobody because of too few events.
    ///
    /// # Errors
    /// If all rows are of nobody, `nobody` of them for their score: with the counts of each step for the
    /// recording `path`, and what to change.
    pub fn check(
        &self,
        [path, out]: [&Path; 2],
        nobody: u64,
        scores: Option<PoseScores>,
    ) -> Result<()> {
        let times = self.too_few + self.inferred;
        let somebody = self.inferred - nobody;
        if somebody > 0 && self.too_few > 0 {
            let too_few = self.too_few;
            note(format!(
                "note: too few events for a pose at {too_few} of {times} times: rows of nobody"
            ));
        }
        let events = self
            .events
            .iter()
            .map(|left| format!("\n  {} events are left {}", left.events, left.step));
        let mut counts: String = events.collect();
        counts += &format!("\n  {} of {times} times had too few of them", self.too_few);
        if let Some(PoseScores { best, min_score }) = scores {
            let best = best.map_or_else(String::new, |best| format!(", the highest {best:.3}"));
            counts += &format!(
                "\n  {nobody} poses, or all of their joints, scored below the threshold, {min_score:.3}{best}"
            );
        }
        // Where something was inferred, events sufficed: only the threshold was in the way.
        let advice = match scores.filter(|_| self.inferred > 0) {
            Some(_) => "set a lower --min-score, if `evpose view` shows somebody".to_owned(),
            None => self.advice(),
        };
        let found = match times {
            0 => "no window has the events of an input".to_owned(),
            _ => format!("nobody is in view, as the {times} rows of {} say", out.display()),
        };
        if somebody == 0 {
            bail!(NobodyInView(format!(
                "{}: {found}:{counts}
{advice}",
                path.display()
            )));
        }
        Ok(())
    }

    /// The advice of the steps that took most of the events, or that for a recording of few.
    fn advice(&self) -> String {
        let took_most = |pair: &&[RemainingEvents]| {
            let expected = pair[1].edge_share * pair[0].events as f64;
            (pair[1].events as f64) < FEW * expected.max(1.0)
        };
        let taken = self.events.windows(2).filter(took_most).map(|pair| pair[1].advice);
        let advice: Vec<&str> = taken.collect();
        let read = self.events.first().map_or("", |read| read.advice);
        if advice.is_empty() { read.to_owned() } else { advice.join("; ") }
    }
}

/// Takes every input of a recording, which begins and ends at `span`, and hands on its poses, before them the
/// times at which too few events had come; shows the progress, and says what is odd about the file `path`.
///
/// # Errors
/// If the recording cannot be read, or the network fails.
pub fn infer_all<F, W>(
    recording: &mut RecordingStream<F, W>,
    path: &Path,
    [start, end]: [Micros; 2],
    mut take: impl FnMut(&F, InferredPoses<F::Pose>),
) -> Result<InferenceCounts>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let progress = bar("inferring", (end - start).0 as u64 / 1_000, "ms");
    let (mut too_few, mut count) = (0, 0);
    while let Some(inferred) = recording.next().transpose()? {
        too_few += inferred.skipped.len() as u64;
        count += inferred.poses.len() as u64;
        progress.set_position((inferred.t - start).0 as u64 / 1_000);
        take(&recording.stream().frontend, inferred);
    }
    progress.finish_and_clear();
    for warning in recording.warnings() {
        note(format!("warning: {}: {warning}", path.display()));
    }
    Ok(InferenceCounts { events: recording.remaining_events(), too_few, inferred: count })
}

/// The rows of a recording, those of nobody included, and how they came about; `latency_ms` of each from its delay.
///
/// # Errors
/// As [`infer_all`], or if there are no events.
pub(crate) fn infer_rows<F, W>(
    recording: &mut RecordingStream<F, W>,
    path: &Path,
    kind: PoseKind,
    latency_ms: impl Fn(f64) -> Option<f64>,
) -> Result<(Vec<TimedPose>, InferenceCounts)>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let span = recording.span()?.with_context(|| format!("{}: no events", path.display()))?;
    let mut poses = Vec::new();
    let counts = infer_all(recording, path, span, |frontend, inferred| {
        poses.extend(inferred.skipped.iter().map(|t| TimedPose::nobody(kind, *t)));
        poses.extend(inferred.poses.iter().map(|(t, pose)| TimedPose {
            latency_ms: latency_ms(inferred.delay_s),
            ..TimedPose::new(*t, &frontend.estimate(pose)).with_origin(PoseOrigin::Network)
        }));
    })?;
    Ok((poses, counts))
}

/// Runs `evpose infer` of a task without options of its own: writes the rows of its recording.
///
/// # Errors
/// As [`infer_rows`], or if the file cannot be written.
pub(crate) fn write_rows<F, W>(
    recording: &mut RecordingStream<F, W>,
    kind: PoseKind,
    args: &InferArgs,
    own: &OneRecordingArgs,
) -> Result<()>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    // An unknown ending would waste an inference of an hour.
    let format = format_of(own.format, &args.out)?;
    let latency_ms = |delay_s| args.latency_ms(delay_s);
    let (poses, counts) = infer_rows(recording, &own.events, kind, latency_ms)?;
    write_poses_from(&args.out, kind, None, &mut poses.into_iter(), format)?;
    counts.check([&own.events, &args.out], 0, None)?;
    say(format!("{} poses: {}", counts.inferred, args.out.display()));
    Ok(())
}
