//! Recorded sequences as training samples and as evaluation windows.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use evpose_core::SensorSize;
use evpose_nn::RotationOutput;
use evpose_pose::{HandParams, HandSide, PARAMETERS};
use evpose_repr::{
    ChannelOrder, FrameWindow, RepresentationChoice, WindowAugmentation, representation_by_name,
};
use evpose_sim::raster::Camera;

use crate::TrainError;
use crate::hand::camera_turn::CameraTurn;
use crate::hand::joints::{JointLabel, JointLabeller, scramble};
use crate::hand::sequence_events::keep_confirmed;
use crate::order::SampleOrder;
use evpose_camera::Calibration;
use evpose_clean::Denoise;
use evpose_task::Experiment as _;
use evpose_task::hand::{CameraTurnConfig, HandConfig, PerspectiveCrop, TwoPass, canonical_view};

mod files;
mod sequence;
mod split;

pub use sequence::{HandLabelTrack, HandSequence};
pub(crate) use split::HandSplit;

/// Input channels of the network.
const CHANNELS: usize = 2;
/// Draws of a training sample until one shows its hand.
const MAX_DRAWS: u64 = 5;
/// Passes between these draws.
const PASSES_APART: u64 = 1 << 20;

/// Why a sample could not be read.
pub(crate) type SampleError = evpose_io::IoError;

/// A window of events and the pose at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// `[2, height, width]`, row by row.
    pub input: Vec<f32>,
    /// The 12 parameters.
    pub pose: [f32; PARAMETERS],
    /// The joints in the image, for networks of joints.
    pub joints: Option<Box<JointLabel>>,
}

/// Sequences of a directory, or a part of each of them.
#[derive(Debug, Clone)]
pub struct HandDataset {
    sequences: Arc<Vec<HandSequence>>,
    /// The frames of each sequence that are samples.
    parts: Vec<Range<u64>>,
    /// `starts[i]` samples come before those of sequence `i`.
    starts: Vec<u64>,
    order: SampleOrder,
    representation: RepresentationChoice,
    channel_order: ChannelOrder,
    augmentation: WindowAugmentation,
    window_frames: u32,
    seed: u64,
    sensor: SensorSize,
    rotation: RotationOutput,
    camera: Camera,
    camera_turns: CameraTurnConfig,
    two_pass: Option<Arc<TwoPass>>,
    labeller: Option<Arc<JointLabeller>>,
    denoise: Option<Denoise>,
    note: Option<String>,
}

impl HandDataset {
    /// Opens every sequence of `directory`, in the order of their names: labels (`0000.meta`) with
    /// events of any format beside them (`0000.evc`, `0000.raw`, …). Those of another camera than that
    /// of the config are seen through it: see [`Self::open_of_camera`].
    ///
    /// # Errors
    /// If there is none, or one is damaged.
    pub fn open(directory: &Path, config: &HandConfig) -> Result<Self, TrainError> {
        Self::open_of_camera(directory, config, None)
    }

    /// As [`Self::open`], of recordings of a camera: see [`Calibration::choose`]. Without one, it is
    /// that of the simulation's config in the directory, or a guess.
    ///
    /// # Errors
    /// As [`Self::open`], or if the camera is not known.
    ///
    /// # Memory
    /// Windows of `.evc` files of the view's sensor are read when they are needed. All other events
    /// are held, at [`Self::memory_bytes`].
    pub fn open_of_camera(
        directory: &Path,
        config: &HandConfig,
        camera: Option<&str>,
    ) -> Result<Self, TrainError> {
        let files = files::sequence_files(directory)?;
        let view = canonical_view(config);
        let mut note = None;
        let mut calibration = |sensor: SensorSize| -> Result<Option<Calibration>, TrainError> {
            // Recordings of the view's own sensor need no camera.
            if camera.is_none() && sensor == view.sensor {
                return Ok(None);
            }
            let calibration = calibration_of(directory, sensor, camera)?;
            // One note stands for all recordings.
            note = note.take().or_else(|| calibration.note.clone());
            Ok(Some(calibration))
        };
        let sequences: Vec<HandSequence> = files
            .iter()
            .map(|files| HandSequence::open(files, config, &view, &mut calibration))
            .collect::<Result<_, _>>()?;
        let parts = sequences.iter().map(|sequence| 0..sequence.frames).collect();
        let data = Self::from_parts(Arc::new(sequences), parts, config, view.sensor)?;
        Ok(Self { note, ..data })
    }

    fn from_parts(
        sequences: Arc<Vec<HandSequence>>,
        parts: Vec<Range<u64>>,
        config: &HandConfig,
        sensor: SensorSize,
    ) -> Result<Self, TrainError> {
        // Samples are counted through all parts.
        let mut starts = vec![0];
        for part in &parts {
            // A part may be empty, but never of negative length.
            starts.push(starts[starts.len() - 1] + part.end.saturating_sub(part.start));
        }
        let samples = starts[starts.len() - 1];
        if samples == 0 {
            return Err(TrainError::Field {
                field: "training.validation_s",
                message: "leaves no frames in one of the two parts of the data".into(),
            });
        }
        Ok(Self {
            sequences,
            parts,
            starts,
            order: SampleOrder::new(samples, config.seed),
            representation: representation_by_name(&config.representation.name)?,
            channel_order: config.representation.channel_order,
            augmentation: config.augmentation,
            window_frames: config.representation.window_ms,
            seed: config.seed,
            sensor,
            rotation: config.network.rotation,
            camera: config.simulation.camera(),
            camera_turns: config.camera_turns,
            two_pass: TwoPass::new(config)?.map(Arc::new),
            labeller: JointLabeller::new(config)?.map(Arc::new),
            denoise: config.representation.denoise,
            note: None,
        })
    }

    /// All sequences, whole.
    pub fn sequences(&self) -> &[HandSequence] {
        &self.sequences
    }

    /// Bytes of the events in memory: 4 an event and 8 a millisecond of the sequences that are not read
    /// from `.evc` files as they are.
    pub fn memory_bytes(&self) -> u64 {
        self.sequences.iter().map(|sequence| sequence.events.bytes()).sum()
    }

    /// Assumptions about the camera, for the user.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Number of samples: one for each frame.
    pub fn len(&self) -> u64 {
        self.starts[self.starts.len() - 1]
    }

    /// Never: an empty data set is an error at [`Self::open`].
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How the network's outputs express rotations.
    pub(crate) fn rotation(&self) -> RotationOutput {
        self.rotation
    }

    /// `(height, width)` of the canonical view, whose windows are evaluated.
    pub fn image_size(&self) -> (usize, usize) {
        (usize::from(self.sensor.height), usize::from(self.sensor.width))
    }

    /// `(height, width)` of the network's images: of samples.
    pub fn sample_size(&self) -> (usize, usize) {
        let size = self.two_pass.as_ref().map_or(self.sensor, |two_pass| two_pass.size());
        (usize::from(size.height), usize::from(size.width))
    }

    /// The sequence and frame of sample `index`.
    fn locate(&self, index: u64) -> (&HandSequence, u64) {
        let sequence = self.starts.partition_point(|&start| start <= index) - 1;
        (&self.sequences[sequence], self.parts[sequence].start + index - self.starts[sequence])
    }

    /// The sample at position `position` of the endless shuffled sequence of training samples,
    /// augmented; a pure function of the seed and the position.
    /// Of a network of joints, windows in which the hand rests are drawn again: heatmaps that are taught what no
    /// image shows learn to be wide.
    pub(crate) fn training_sample(&self, position: u64) -> Result<Sample, SampleError> {
        let mut sample = self.drawn_sample(position)?;
        for draw in 1..MAX_DRAWS {
            let size = self.two_pass.as_ref().map_or(self.sensor, |two_pass| two_pass.size());
            let is_instructive = |label: &JointLabel| label.is_instructive(&sample.input, size);
            if sample.joints.as_deref().is_none_or(is_instructive) {
                break;
            }
            // Of a pass that no training comes to.
            sample = self.drawn_sample(position + draw * PASSES_APART * self.len())?;
        }
        Ok(sample)
    }

    fn drawn_sample(&self, position: u64) -> Result<Sample, SampleError> {
        let (sequence, frame) = self.locate(self.order.at(position));
        let draw = self.augmentation.draw(self.seed, position);
        // Left hands are recorded through a mirror, in which turns would go the other way.
        let turn = CameraTurn::draw(&self.camera_turns, &self.camera, self.seed, position)
            .filter(|_| self.two_pass.is_none() && sequence.hand() == HandSide::Right);
        let mut input = self.turned_window(sequence, frame, draw.frames, turn.as_ref())?;
        draw.swap_channels(&mut input, CHANNELS);
        let pose = sequence.labels.read_hand(frame)?;
        if self.two_pass.is_some() {
            return self.cropped((sequence, frame), input, &pose, (self.seed, position));
        }
        let crop = turn.as_ref().map_or(PerspectiveCrop::WHOLE, CameraTurn::crop);
        let joints = self.joints(sequence, frame, &pose, &crop)?;
        let pose = turn.map_or(pose, |turn| turn.pose(&pose)).to_array();
        Ok(Sample { input, pose, joints })
    }

    /// The joints of a frame in a crop, for networks of joints.
    fn joints(
        &self,
        sequence: &HandSequence,
        frame: u64,
        pose: &HandParams,
        crop: &PerspectiveCrop,
    ) -> Result<Option<Box<JointLabel>>, SampleError> {
        let Some(labeller) = &self.labeller else { return Ok(None) };
        let points_m = labeller.points_m(sequence, frame, pose)?;
        Ok(Some(Box::new(labeller.label(&points_m, crop))))
    }

    /// A crop of a frame, or the whole of it for the first pass: a function of `seed` and `number`.
    fn cropped(
        &self,
        (sequence, frame): (&HandSequence, u64),
        input: Vec<f32>,
        pose: &HandParams,
        (seed, number): (u64, u64),
    ) -> Result<Sample, SampleError> {
        let Some(two_pass) = &self.two_pass else {
            let joints = self.joints(sequence, frame, pose, &PerspectiveCrop::WHOLE)?;
            return Ok(Sample { input, pose: pose.to_array(), joints });
        };
        let mut seen = vec![0.0; CHANNELS * two_pass.size().pixels()];
        let Some(labeller) = &self.labeller else {
            let crop = match sequence.hand() {
                HandSide::Left => PerspectiveCrop::WHOLE,
                HandSide::Right => two_pass.draw(pose, seed, number),
            };
            two_pass.fill(&crop, &input, &mut seen);
            let pose = crop.crop_from_view(two_pass.camera(), pose).to_array();
            return Ok(Sample { input: seen, pose, joints: None });
        };
        let points_m = labeller.points_m(sequence, frame, pose)?;
        let view = two_pass.draw_view(&points_m, seed, number);
        two_pass.fill(&view.crop, &input, &mut seen);
        let mut label = labeller.label(&points_m, &view.crop).as_seen(&seen);
        if sequence.info.another_hand {
            // What lies beside the labelled hand may be the other one.
            label.presence = label.presence.filter(|is_present| *is_present);
        }
        if view.is_scrambled {
            scramble(&mut seen, two_pass.size(), seed, number);
            label = label.without_hand();
        }
        let pose = view.crop.crop_from_view(two_pass.camera(), pose).to_array();
        Ok(Sample { input: seen, pose, joints: Some(Box::new(label)) })
    }

    /// The input of sample `index`, not augmented.
    ///
    /// # Errors
    /// If the recording cannot be read.
    pub fn plain_input(&self, index: u64) -> Result<Vec<f32>, TrainError> {
        Ok(self.plain_sample(index)?.input)
    }

    /// Sample `index` in order of recording, not augmented but for its crop.
    pub(crate) fn plain_sample(&self, index: u64) -> Result<Sample, SampleError> {
        let (sequence, frame) = self.locate(index);
        let input = self.window(sequence, frame, self.window_frames)?;
        let pose = sequence.labels.read_hand(frame)?;
        // Another seed than in training, whose crops validation must not repeat.
        self.cropped((sequence, frame), input, &pose, (!self.seed, index))
    }

    /// The representation of the `length` frames that end with `frame`. Frames before the start of
    /// the recording count as frames without events.
    fn window(
        &self,
        sequence: &HandSequence,
        frame: u64,
        length: u32,
    ) -> Result<Vec<f32>, SampleError> {
        self.turned_window(sequence, frame, length, None)
    }

    /// The same as a turned camera sees it.
    fn turned_window(
        &self,
        sequence: &HandSequence,
        frame: u64,
        length: u32,
        turn: Option<&CameraTurn<'_>>,
    ) -> Result<Vec<f32>, SampleError> {
        let first = (frame + 1).saturating_sub(u64::from(length));
        let missing = length - (frame + 1 - first) as u32;
        let mut events = sequence.events.frame_events(first..frame + 1)?;
        // Before the turn, since noise has no neighbours among the pixels of its own sensor.
        if let Some(denoise) = &self.denoise {
            keep_confirmed(&mut events, denoise, self.sensor);
        }
        events.iter_mut().for_each(|event| event.frame += missing);
        if let Some(turn) = turn {
            turn.apply(&mut events);
        }
        let mut window = FrameWindow::new(self.sensor, length, self.channel_order);
        // A redraw of the scene makes a burst that no motion explains: it hides itself and all
        // that was before.
        if let Some(redraw) = sequence.info.last_redraw(first..frame + 1) {
            window.visible_from = missing + (redraw - first) as u32 + 1;
        }
        let mut input = vec![0.0; self.representation.channels() * self.sensor.pixels()];
        self.representation.fill(&window, &events, &mut input);
        // The network has two input channels: a representation of one fills both.
        if self.representation.channels() == 1 {
            input.extend_from_within(..);
        }
        Ok(input)
    }

    /// The input of the evaluation window that ends with `frame`.
    ///
    /// # Errors
    /// If the events cannot be read.
    pub fn evaluation_input(
        &self,
        sequence: &HandSequence,
        frame: u64,
    ) -> Result<Vec<f32>, TrainError> {
        Ok(self.window(sequence, frame, self.window_frames)?)
    }

    /// The labels of at most `samples` samples, spread evenly.
    ///
    /// # Errors
    /// If a label cannot be read.
    pub fn poses(&self, samples: u64) -> Result<Vec<HandParams>, TrainError> {
        let samples = samples.min(self.len());
        (0..samples)
            .map(|i| {
                let (sequence, frame) = self.locate(i * self.len() / samples);
                sequence.pose(frame)
            })
            .collect()
    }
}

/// The camera of the recordings of a directory.
fn calibration_of(
    directory: &Path,
    sensor: SensorSize,
    camera: Option<&str>,
) -> Result<Calibration, TrainError> {
    let config = directory.join("config.toml");
    match camera {
        // A simulation says exactly what its camera was.
        None if config.exists() => {
            let made_with = HandConfig::read(&config)?;
            let fov_deg = f64::from(made_with.simulation.camera.vertical_fov_deg);
            Ok(Calibration::from_vertical_fov(sensor, fov_deg))
        }
        _ => Ok(Calibration::choose(camera, sensor)?),
    }
}
