//! A recording of a hand with its labels.

use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_body::ShapedBody;
use evpose_camera::{Calibration, CanonicalView, ViewAdaptor};
use evpose_core::{EventStream, SensorSize};
use evpose_io::{JointsReader, MetaReader, OpenOptions, Windows};
use evpose_pose::metric::HandPoints;
use evpose_pose::stream::InferenceSchedule;
use evpose_pose::{HandParams, HandSide};
use evpose_sim::SequenceInfo;
use evpose_task::RecordingStream;
use evpose_task::hand::{
    HandConfig, HandFrontend, HandView, HandWorker, Predictor, calibration_for, hand_recording,
};
use glam::Vec3;

use super::files::SequenceFiles;
use crate::TrainError;
use crate::hand::sequence_events::{RecordedEvents, SequenceEvents};

/// Labels of a recording: the pose at every millisecond.
#[derive(Debug)]
pub struct HandLabelTrack {
    labels: MetaReader,
    info: SequenceInfo,
}

impl HandLabelTrack {
    /// Opens `STEM.meta`, and `STEM.toml` where there is one. Nothing but the labels is read, so the
    /// recording may be missing.
    ///
    /// # Errors
    /// If a file cannot be read or is damaged.
    pub fn open(labels: &Path) -> Result<Self, TrainError> {
        let stem = labels.with_extension("");
        let labels = MetaReader::open(labels)?;
        let info = SequenceInfo::beside(&stem)?;
        // Of an unknown sensor, which no label depends on.
        let info =
            info.unwrap_or_else(|| SequenceInfo::foreign(SensorSize::DAVIS240C, labels.records()));
        Ok(Self { labels, info })
    }

    /// The labelled hand.
    pub fn hand(&self) -> HandSide {
        self.info.hand
    }

    /// Count of labels, one each millisecond.
    pub fn frames(&self) -> u64 {
        self.labels.records()
    }

    /// The pose of a frame.
    ///
    /// # Errors
    /// If the label cannot be read.
    pub fn pose(&self, frame: u64) -> Result<HandParams, TrainError> {
        Ok(self.labels.read_hand(frame)?)
    }

    /// Shape of the hand in a frame; empty where it is not known.
    pub fn betas_at(&self, frame: u64) -> &[f32] {
        self.info.betas(self.info.episode_of(frame))
    }
}

/// One recording with its labels.
#[derive(Debug)]
pub struct HandSequence {
    name: String,
    /// The file of events, and the camera that recorded it.
    path: PathBuf,
    calibration: Calibration,
    pub(super) events: SequenceEvents,
    pub(super) labels: MetaReader,
    /// The points of the hand, where they were recorded: labels say the nearest of the twelve parameters.
    pub(crate) joints: Option<JointsReader>,
    pub(super) info: SequenceInfo,
    pub(super) frames: u64,
}

impl HandSequence {
    /// Opens a sequence. Where the sensor is not that of `view`, or a camera is given, its events are
    /// seen by the camera of `view`, before which `calibration` of the sensor describes the own one.
    ///
    /// # Errors
    /// If a file cannot be read or is damaged, or the camera is not known.
    pub(super) fn open(
        files: &SequenceFiles,
        config: &HandConfig,
        view: &CanonicalView,
        calibration: &mut dyn FnMut(SensorSize) -> Result<Option<Calibration>, TrainError>,
    ) -> Result<Self, TrainError> {
        let info = SequenceInfo::beside(&files.stem)?;
        let labels = MetaReader::open(&files.labels)?;
        let is_evc = files.events.extension().is_some_and(|ending| ending == "evc");
        // A published .evc file does not say how large its sensor is.
        let usual = is_evc.then(|| config.simulation.image_size());
        // What is written beside the recording comes before what is usual.
        let known = info.as_ref().map(|info| info.sensor).or(usual);
        let events = RecordedEvents::open(&files.events, known)?;
        let sensor = events.sensor();
        let joints = JointsReader::path_of(&files.stem);
        let joints = joints.exists().then(|| JointsReader::open(&joints)).transpose()?;
        // The shortest of all: one of them may be cut.
        let labelled = joints.as_ref().map_or(u64::MAX, JointsReader::frames).min(labels.records());
        let frames = events.frames().unwrap_or(u64::MAX).min(labelled);
        // Of other formats, no episodes are known.
        let of_episodes = if is_evc { frames } else { 0 };
        let mut info = info.unwrap_or_else(|| SequenceInfo::foreign(sensor, of_episodes));
        let own = calibration(sensor)?;
        let adaptor = own.as_ref().map(|calibration| ViewAdaptor::new(calibration, view));
        // From here on events are those of the view.
        if adaptor.is_some() {
            info.sensor = view.sensor;
        }
        let calibration = own.map_or_else(|| calibration_for(config, sensor, None), Ok)?;
        let events = events.into_sequence(frames, adaptor)?;
        let (name, path) = (name_of(&files.stem), files.events.clone());
        Ok(Self { name, path, calibration, events, labels, joints, info, frames })
    }

    /// The recording through the stream of a network, as `evpose infer` reads it.
    ///
    /// # Errors
    /// If it cannot be read, or the stream not be made.
    pub fn stream<P: Predictor>(
        &self,
        config: &HandConfig,
        predictor: P,
        schedule: InferenceSchedule,
    ) -> Result<RecordingStream<HandFrontend, HandWorker<P>>, TrainError> {
        let sensor = Some(self.calibration.sensor);
        let options = OpenOptions { sensor, ..OpenOptions::default() };
        let windows = Windows::open(&self.path, &options)?;
        Ok(hand_recording(config, predictor, windows, &self.calibration, schedule)?)
    }

    /// Name of its files without extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size of the sensor it was recorded with.
    pub fn sensor(&self) -> SensorSize {
        self.info.sensor
    }

    /// The hand in the image.
    pub fn hand(&self) -> HandSide {
        self.info.hand
    }

    /// Frames of 1 ms that have both events and a label.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// The pose at the end of a frame.
    ///
    /// # Errors
    /// If the label cannot be read.
    pub fn pose(&self, frame: u64) -> Result<HandParams, TrainError> {
        Ok(self.labels.read_hand(frame)?)
    }

    /// The evaluated points at the end of a frame: as recorded, or those of the label's pose of a hand that is `shaped`.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn points(
        &self,
        view: &HandView,
        frame: u64,
        shaped: &ShapedBody,
    ) -> Result<HandPoints, TrainError> {
        if let Some(joints) = &self.joints {
            let camera_m = joints.read(frame)?.map(Vec3::from_array);
            return Ok(view.imaged(view.world_points(&camera_m)));
        }
        Ok(view.points_of(self.hand(), &self.pose(frame)?, shaped))
    }

    /// The events of `frames`, those of frame `k` at `k` milliseconds.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn events(&self, frames: Range<u64>) -> Result<EventStream, TrainError> {
        Ok(self.events.stream(frames)?)
    }

    /// Whether the scene is drawn anew in some of `frames`, so that its events are a burst.
    pub fn is_redrawn(&self, frames: Range<u64>) -> bool {
        self.info.last_redraw(frames).is_some()
    }

    /// Index of the episode of a frame: a stretch of constant shape, texture and background.
    pub fn episode_of(&self, frame: u64) -> usize {
        self.info.episode_of(frame)
    }

    /// Shape of the hand in an episode; empty where it is not known.
    pub fn betas(&self, episode: usize) -> &[f32] {
        self.info.betas(episode)
    }
}

fn name_of(stem: &Path) -> String {
    stem.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use evpose_io::FORMATS;
    use evpose_sim::{Simulation, record_all};

    use super::*;
    use crate::HandDataset;
    use crate::hand::small_config;

    fn small() -> HandConfig {
        let mut config = small_config(0.2, 0.3);
        config.simulation.sequences = 2;
        config
    }

    /// The data set of a config whose events are in `format`.
    fn recorded(config: &HandConfig, format: &str) -> tempfile::TempDir {
        let directory = tempfile::tempdir().unwrap();
        let mut simulation = config.simulation.clone();
        simulation.format = Some(format.to_owned());
        let simulation = Simulation::new(&simulation, config.seed).unwrap();
        record_all(&simulation, directory.path(), &|_| {}).unwrap();
        assert!(directory.path().join(format!("0001.{format}")).exists());
        directory
    }

    /// Events of this sensor are at whole milliseconds, so frames are the same in every format.
    #[test]
    fn sequences_of_every_format_give_the_same_samples() {
        let config = small();
        // The view of this config is another one, so that events are seen through its camera.
        let mut other = config.clone();
        other.simulation.image_scale = 0.15;
        let of = |format: &str| {
            let directory = recorded(&config, format);
            [&config, &other].map(|config| {
                let data = HandDataset::open(directory.path(), config).unwrap();
                let samples: Vec<_> = (0..40)
                    .map(|at| data.training_sample(at).unwrap())
                    .chain([0, 299, 300].map(|index| data.plain_sample(index).unwrap()))
                    .collect();
                let streams = [0, 1].map(|k| data.sequences()[k].events(90..300).unwrap());
                (data.memory_bytes(), samples, streams)
            })
        };
        let [evc, seen] = of("evc");
        assert_eq!(evc.0, 0, "read from the files");
        assert!(seen.0 > 2 * 300 * 8, "{} bytes", seen.0);
        for format in ["raw", "aedat4", "npz", "csv"] {
            let [own, own_seen] = of(format);
            assert!(own.0 > 2 * 300 * 8, "{format}");
            assert!(own.1 == evc.1 && own.2 == evc.2, "{format}");
            assert!(own_seen.1 == seen.1 && own_seen.2 == seen.2, "{format}, seen");
        }
    }

    #[test]
    fn events_of_another_clock_than_the_labels_are_refused() {
        let config = small();
        let directory = recorded(&config, "raw");
        let path = directory.path().join("0000.raw");
        let recording = evpose_io::open(&path).unwrap().stream;
        let late = recording.iter().map(|mut event| {
            event.t.0 += 5_000_000;
            event
        });
        let late = EventStream::from_events(recording.sensor(), late).unwrap();
        FORMATS.find("evt3").unwrap().write(&path, &late).unwrap();
        let message = HandDataset::open(directory.path(), &config).unwrap_err().to_string();
        assert!(message.contains("0000.raw") && message.contains("--zero-time"), "{message}");
    }

    #[test]
    fn labels_are_read_without_their_recording() {
        let config = small();
        let directory = recorded(&config, "raw");
        let data = HandDataset::open(directory.path(), &config).unwrap();
        std::fs::remove_file(directory.path().join("0001.raw")).unwrap();
        let track = HandLabelTrack::open(&directory.path().join("0001.meta")).unwrap();
        let sequence = &data.sequences()[1];
        assert_eq!((track.frames(), track.hand()), (300, HandSide::Right));
        assert_eq!(track.pose(17).unwrap(), sequence.pose(17).unwrap());
        assert_eq!(track.betas_at(17), sequence.betas(sequence.episode_of(17)));
    }
}
