//! Evaluation of the slow-motion mode on sequences with ground truth.

use evpose_core::Micros;
use evpose_pose::metric::HandEvaluation;
use evpose_pose::stream::InferenceSchedule;
use serde::Serialize;

use crate::TrainError;
use crate::hand::dataset::{HandDataset, HandSequence};
use crate::hand::evaluation::{HandPoseTrack, MethodResults, is_scored, score_track};
use evpose_task::hand::{HandConfig, HandEstimate, HandView, Predictor};

/// Scores of the slow-motion mode and its usage of the network.
#[derive(Debug, Clone)]
pub struct SlowMotionResults {
    /// `slow_motion`: each pose counts from the time stamp of its input. `slow_motion_live`: only
    /// from when its batch was full, which is the pose on the screen of a live run.
    pub methods: Vec<MethodResults>,
    /// Usage, summed over all sequences.
    pub usage: SlowMotionUsage,
}

/// Amounts of data and of inference in the slow-motion mode.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct SlowMotionUsage {
    /// Duration of all sequences.
    pub seconds: f64,
    /// Events of all sequences, without those of a scene that is drawn anew.
    pub events: u64,
    /// Representations rendered.
    pub inputs: u64,
    /// Representations that got the predictions of an earlier batch.
    pub repeated: u64,
    /// Poses filtered with the fast settings.
    pub fast: u64,
    /// Sum of the delays from the time stamp of an input until its pose is known, in seconds.
    pub waited_s: f64,
}

impl SlowMotionUsage {
    fn add(&mut self, poses: &[HandEstimate]) {
        let count = |is_counted: fn(&HandEstimate) -> bool| {
            poses.iter().filter(|pose| is_counted(pose)).count() as u64
        };
        self.inputs += poses.len() as u64;
        self.repeated += count(|pose| pose.is_repeated);
        self.fast += count(|pose| pose.is_fast);
        self.waited_s += poses.iter().map(|p| (p.known - p.t).as_seconds()).sum::<f64>();
    }
}

/// Evaluates the slow-motion mode on every sequence of `data`: the poses that `evpose infer` writes of its
/// recording, at the same frames as [`evaluate`](crate::evaluate) from the first pose on. Between two poses, the
/// earlier one stands. `progress` receives milliseconds of the sequences.
///
/// # Errors
/// If a sequence cannot be read or a prediction fails.
pub fn evaluate_slow_motion(
    config: &HandConfig,
    data: &HandDataset,
    predictor: &mut dyn Predictor,
    stride_ms: u32,
    progress: &mut dyn FnMut(u64),
) -> Result<SlowMotionResults, TrainError> {
    let view = HandView::new(config)?;
    let mut methods: Vec<MethodResults> = ["slow_motion", "slow_motion_live"]
        .map(|name| MethodResults {
            name,
            evaluation: HandEvaluation::default(),
            tracks: Vec::new(),
        })
        .into();
    let mut usage = SlowMotionUsage::default();
    for sequence in data.sequences() {
        let poses = track(config, sequence, predictor, &mut usage, progress)?;
        usage.add(&poses);
        // By its own time, and by when a live user knew of it.
        for (method, since) in methods.iter_mut().zip([
            (|pose: &HandEstimate| pose.t) as fn(&HandEstimate) -> Micros,
            |pose: &HandEstimate| pose.known,
        ]) {
            let mut track = HandPoseTrack::default();
            // At the same frames as all other methods.
            let frames = (0..sequence.frames()).step_by(stride_ms.max(1) as usize);
            for frame in frames.filter(|&frame| is_scored(config, sequence, frame)) {
                if let Some(pose) = newest(&poses, frame, since) {
                    track.push(frame, pose.filtered);
                }
            }
            method.evaluation.sequences.push(score_track(&view, sequence, &track)?);
            method.tracks.push(track);
        }
    }
    Ok(SlowMotionResults { methods, usage })
}

/// The newest pose by the end of a frame of 1 ms.
fn newest(
    poses: &[HandEstimate],
    frame: u64,
    since: fn(&HandEstimate) -> Micros,
) -> Option<&HandEstimate> {
    let end = Micros((frame as i64 + 1) * 1_000);
    poses[..poses.partition_point(|pose| since(pose) < end)].last()
}

/// All poses of one sequence.
fn track(
    config: &HandConfig,
    sequence: &HandSequence,
    predictor: &mut dyn Predictor,
    usage: &mut SlowMotionUsage,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<HandEstimate>, TrainError> {
    let mut stream = sequence.stream(config, predictor, InferenceSchedule::Triggered)?;
    let (mut poses, mut done) = (Vec::new(), 0);
    for inferred in &mut stream {
        let inferred = inferred?;
        poses.extend(inferred.poses.into_iter().map(|(_, estimate)| estimate));
        let now = u64::try_from(inferred.t.0 / 1_000).unwrap_or_default().min(sequence.frames());
        progress(now.saturating_sub(done));
        done = done.max(now);
    }
    // The last inference may come before the end of the sequence.
    progress(sequence.frames() - done);
    usage.events += stream.events();
    // A new scene sends a burst of events that no camera would see: it is no work to be counted.
    for frame in (0..sequence.frames()).filter(|&frame| sequence.is_redrawn(frame..frame + 1)) {
        usage.events -= (sequence.events(frame..frame + 1)?.len() as u64).min(usage.events);
    }
    usage.seconds += sequence.frames() as f64 * 1e-3;
    Ok(poses)
}

#[cfg(test)]
mod tests {
    use evpose_sim::{Simulation, record_all};

    use evpose_pose::HandPose;

    use super::*;
    use crate::hand::small_config;
    use crate::{Condition, Method, evaluate};
    use evpose_task::hand::ConstantPose;

    /// Both evaluations of a pose that is always the same.
    fn results(config: &HandConfig) -> (Vec<MethodResults>, SlowMotionResults) {
        let directory = tempfile::tempdir().unwrap();
        let simulation = Simulation::new(&config.simulation, config.seed).unwrap();
        record_all(&simulation, directory.path(), &|_| {}).unwrap();
        let data = HandDataset::open(directory.path(), config).unwrap();
        let mean = data.poses(20).unwrap()[10];
        let mut constant = ConstantPose(mean);
        let mut methods = [Method { name: "mean_pose", predictor: &mut constant, filtered: None }];
        let plain = evaluate(config, &data, &mut methods, 7, &mut |_| {}).unwrap();
        let mut done = 0;
        let mut progress = |ms| done += ms;
        let slow = evaluate_slow_motion(config, &data, &mut constant, 7, &mut progress).unwrap();
        assert_eq!(done, config.simulation.frames());
        (plain, slow)
    }

    #[test]
    fn a_constant_pose_scores_the_same_in_every_mode() {
        let (plain, slow) = results(&small_config(0.2, 0.6));
        let plain = &plain[0].tracks[0];
        for method in &slow.methods {
            let HandPoseTrack { frames, poses } = &method.tracks[0];
            // Strides end with the last event, and the newest pose stands until the last frame.
            let common = frames.len() - 1;
            assert!(common > 50 && plain.frames.ends_with(&frames[..common]), "{}", method.name);
            assert_eq!(poses[..common], plain.poses[..common], "{}", method.name);
        }
    }

    /// Long enough for a whole movement and the rest after it, wherever the sequence begins.
    #[test]
    fn slow_hands_need_fewer_inputs_and_rests_repeat_predictions() {
        let normal = small_config(0.2, 12.0);
        let slow = Condition::load("slow").unwrap().apply(&normal).unwrap();
        let [normal, slow] = [normal, slow].map(|config| results(&config).1.usage);
        assert_eq!((normal.seconds, slow.seconds), (12.0, 12.0));
        assert!(3 * slow.events < normal.events, "{slow:?} {normal:?}");
        assert!(10 * slow.inputs < 9 * normal.inputs, "{slow:?} {normal:?}");
        let share = |usage: &SlowMotionUsage| usage.repeated as f64 / usage.inputs as f64;
        assert!(share(&slow) > 0.02 && share(&slow) > share(&normal), "{slow:?} {normal:?}");
    }

    #[test]
    fn the_newest_pose_is_that_of_the_frame_or_of_one_before() {
        let pose = |t_us, known_us| HandEstimate {
            t: Micros(t_us),
            known: Micros(known_us),
            measured: HandPose::default(),
            filtered: HandPose::default(),
            is_repeated: false,
            is_fast: false,
        };
        let poses = [pose(2_000, 4_500), pose(3_999, 4_500), pose(4_500, 4_500)];
        let at = |frame, since| newest(&poses, frame, since).map(|pose| pose.t.0);
        let by_time = [1, 2, 3, 4, 9].map(|frame| at(frame, |pose| pose.t));
        assert_eq!(by_time, [None, Some(2_000), Some(3_999), Some(4_500), Some(4_500)]);
        let by_known = [2, 3, 4].map(|frame| at(frame, |pose| pose.known));
        assert_eq!(by_known, [None, None, Some(4_500)]);
    }
}
