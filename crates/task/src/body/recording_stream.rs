//! A recording's events through the body's stream.

use std::path::Path;
use std::time::Instant;

use evpose_core::{EventStream, Micros, Rejected, SensorSize, TimeWindow};
use evpose_io::{OpenOptions, Windows};
use evpose_pose::PoseEstimate;
use evpose_pose::body::BodyPoints;
use evpose_pose::filter::BodyFilterConfig;
use evpose_pose::metric::body::BodyPrediction;
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamFrontend};

use super::checkpoint::BodyCheckpoint;
use super::frontend::{BodyFrontend, BodyWorker, body_stream};
use super::predictor::BodyPredictor;
use super::propagation::PropagationConfig;
use crate::TaskError;
use evpose_camera::Calibration;

/// Poses with their time stamps.
pub type TimedEstimates = Vec<(Micros, PoseEstimate)>;

/// A recording, read forwards in time through the stream from events to poses.
pub struct BodyRecordingStream {
    windows: Windows,
    stream: PoseStream<BodyFrontend, BodyWorker>,
    events: EventStream,
    read_to: Option<Micros>,
}

impl BodyRecordingStream {
    /// Opens a recording of a camera: see [`Calibration::choose`], which guesses without one. Joints
    /// are propagated only with `propagation`.
    ///
    /// # Errors
    /// As [`Self::of_camera`], or if the camera is not known.
    pub fn open(
        path: &Path,
        camera: Option<&str>,
        checkpoint: &BodyCheckpoint,
        propagation: Option<&PropagationConfig>,
        predictor: BodyPredictor,
    ) -> Result<Self, TaskError> {
        let windows = Windows::open(path, &OpenOptions::default())?;
        let calibration = Calibration::choose(camera, windows.sensor())?;
        Self::of_camera(windows, &calibration, checkpoint, propagation, predictor)
    }

    /// The stream of a recording of a camera. Joints are propagated only with `propagation`.
    ///
    /// # Errors
    /// If the recording cannot be read, or the stream not be made for its sensor.
    pub fn of_camera(
        windows: Windows,
        calibration: &Calibration,
        checkpoint: &BodyCheckpoint,
        propagation: Option<&PropagationConfig>,
        predictor: BodyPredictor,
    ) -> Result<Self, TaskError> {
        let sensor = calibration.sensor;
        let stream = body_stream(checkpoint, calibration, propagation, predictor)?;
        Ok(Self { windows, stream, events: EventStream::empty(sensor), read_to: None })
    }

    /// The same with a minimum score of poses and joints: see [`BodyFrontend::with_min_score`].
    #[must_use]
    pub fn with_min_score(mut self, min_score: f32) -> Self {
        self.stream.frontend = self.stream.frontend.with_min_score(min_score);
        self
    }

    /// The same with `batch` images per call of the network: see [`Self::poses`].
    #[must_use]
    pub fn with_batch(mut self, batch: usize) -> Self {
        self.stream.frontend = self.stream.frontend.with_batch(batch);
        self
    }

    /// The same with a temporal filter: see [`BodyFrontend::with_filter`].
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn with_filter(mut self, config: BodyFilterConfig) -> Result<Self, TaskError> {
        self.stream.frontend = self.stream.frontend.with_filter(config)?;
        Ok(self)
    }

    /// The sensor.
    pub fn sensor(&self) -> SensorSize {
        self.windows.sensor()
    }

    /// Remarks on the content read so far, in sentences without a full stop.
    pub fn warnings(&self) -> Vec<String> {
        let Rejected { outside_sensor, out_of_order } = self.windows.rejected();
        let rejected = (outside_sensor + out_of_order > 0).then(|| {
            format!(
                "left out {outside_sensor} events outside the sensor and {out_of_order} out of order"
            )
        });
        let lost = self.stream.frontend.has_lost_polarities().then(|| {
            "polarities say nothing: events are pooled to the network's view without them"
                .to_owned()
        });
        rejected.into_iter().chain(lost).chain(self.windows.remarks()).collect()
    }

    /// When the recording begins; none if it is empty.
    pub fn start(&self) -> Option<Micros> {
        self.windows.start()
    }

    /// When it ends.
    ///
    /// # Errors
    /// If it cannot be read to its end.
    pub fn end(&mut self) -> Result<Micros, TaskError> {
        Ok(self.windows.end()?)
    }

    /// Pushes the events up to and including `t` into the stream. `t` is not before the last one.
    ///
    /// # Errors
    /// If the recording cannot be read up to there.
    pub fn advance(&mut self, t: Micros) -> Result<(), TaskError> {
        let begin = self.read_to.or(self.windows.start()).unwrap_or(t);
        let end = t + Micros(1);
        if begin < end {
            self.windows.read(TimeWindow { start: begin, end }, &mut self.events)?;
            self.read_to = Some(end);
            self.stream.frontend.push(&self.events)?;
        }
        Ok(())
    }

    /// The pose at `t`, which is not before the last one, and how long it took from the events to
    /// the pose.
    ///
    /// # Errors
    /// If the recording cannot be read up to there, or the network fails.
    pub fn predict(&mut self, t: Micros) -> Result<BodyPrediction, TaskError> {
        let (estimate, delay_s) = self.pose(t)?;
        let joints_px = match estimate {
            Some(PoseEstimate::Body { joints_px, .. }) => joints_px,
            _ => BodyPoints::default(),
        };
        Ok(BodyPrediction { t_s: t.as_seconds(), delay_s, joints_px })
    }

    /// As [`Self::predict`], with scores: the pose, none before the recording has shown enough events,
    /// and how long it took in seconds.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn pose(&mut self, t: Micros) -> Result<(Option<PoseEstimate>, f64), TaskError> {
        let (poses, delay_s) = self.poses(t)?;
        Ok((poses.into_iter().next().map(|(_, estimate)| estimate), delay_s))
    }

    /// Takes the image at `t`, which is not before the last one. Returns the poses that became known
    /// with their time stamps, none while a batch is not full, and how long they took in seconds.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn poses(&mut self, t: Micros) -> Result<(TimedEstimates, f64), TaskError> {
        self.advance(t)?;
        let begin = Instant::now();
        self.stream.frontend.stride(t);
        let poses = self.stream.infer(t)?;
        Ok((self.estimates(&poses), begin.elapsed().as_secs_f64()))
    }

    /// The poses of the last batch, which is not full, and how long they took in seconds.
    ///
    /// # Errors
    /// If the network fails.
    pub fn rest(&mut self) -> Result<(TimedEstimates, f64), TaskError> {
        let begin = Instant::now();
        let PoseStream { frontend, worker, .. } = &mut self.stream;
        let Some(batch) = frontend.rest() else { return Ok((Vec::new(), 0.0)) };
        let output = worker.infer(&batch)?;
        let last = batch.times().last().copied().unwrap_or_default();
        let poses = frontend.accept(last, &batch, output, last);
        Ok((self.estimates(&poses), begin.elapsed().as_secs_f64()))
    }

    fn estimates(
        &self,
        poses: &[(Micros, <BodyFrontend as StreamFrontend>::Pose)],
    ) -> TimedEstimates {
        poses.iter().map(|(t, pose)| (*t, self.stream.frontend.estimate(pose))).collect()
    }

    /// The stream, at the last time it was advanced to: for schedules of the caller.
    pub fn stream(&mut self) -> &mut PoseStream<BodyFrontend, BodyWorker> {
        &mut self.stream
    }
}
