//! The inputs of a network of bodies, and the way to and from them, for runtimes of others.

use std::path::Path;
use std::sync::mpsc::{Sender, channel};

use anyhow::Result;
use evpose_camera::Calibration;
use evpose_core::Micros;
use evpose_infer::onnx::Interface;
use evpose_io::{OpenOptions, Windows};
use evpose_pose::body::{BODY_JOINTS, BodyJoint, JOINT_NAMES};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamError};
use evpose_task::RecordingStream;
use evpose_task::body::{BodyPredictorOptions, BodyViewKind, BodyWorker, ImageBatch, body_stream};

use super::BodyNetwork;
use crate::tasks::hand::{denoise, described};
use crate::tasks::task::NetworkModel as _;

/// Hands on inputs, and finds no joint.
struct InputTap {
    worker: BodyWorker,
    inputs: Sender<Vec<f32>>,
}

impl InferenceWorker for InputTap {
    type Input = ImageBatch;
    type Output = Vec<Vec<BodyJoint>>;

    fn infer(&mut self, batch: &ImageBatch) -> Result<Self::Output, StreamError> {
        // The receiver lives as long as the recording.
        let _ = self.inputs.send(self.worker.first_inputs(batch));
        let nobody = vec![BodyJoint { position: None, score: 0.0 }; BODY_JOINTS];
        Ok(vec![nobody; batch.times().len()])
    }
}

/// As [`NetworkModel::for_each_input`](crate::tasks::NetworkModel::for_each_input).
pub(super) fn for_each(
    model: &BodyNetwork,
    recording: &Path,
    every_ms: Option<u32>,
    opening: &OpenOptions,
    take: &mut dyn FnMut(Micros, &[f32]) -> Result<()>,
) -> Result<Vec<String>> {
    let windows = Windows::open(recording, opening)?;
    let calibration = Calibration::choose(None, windows.sensor())?;
    let predictor = model.predictor(BodyPredictorOptions::default())?;
    let PoseStream { frontend, worker, .. } =
        body_stream(&model.checkpoint, &calibration, None, predictor)?;
    let (sender, inputs) = channel();
    let stream = PoseStream::new(frontend, InputTap { worker, inputs: sender });
    let every_ms = every_ms.unwrap_or(model.checkpoint.config.evaluation.every_ms);
    let schedule = InferenceSchedule::Every(Micros(1_000 * i64::from(every_ms.max(1))));
    let mut stream = RecordingStream::new(windows, stream, schedule);
    while let Some(inferred) = stream.next().transpose()? {
        // Each inference sends its inputs before it returns, so that none has to be waited for.
        for ((t, _), input) in inferred.poses.iter().zip(inputs.try_iter()) {
            take(*t, &input)?;
        }
    }
    Ok(stream.warnings())
}

/// As [`NetworkModel::interface`](crate::tasks::NetworkModel::interface).
pub(super) fn interface(model: &BodyNetwork) -> Interface {
    let config = &model.checkpoint.config;
    let ([channels, rows, columns], image) = (model.input_shape(), &config.image);
    let view = match image.view {
        BodyViewKind::Canonical => {
            "the sensor's, undistorted, pooled by the whole number that brings its width nearest to 346 \
             pixels, and in a border that makes it 4 to 3"
        }
        BodyViewKind::Sensor => "the sensor's",
    };
    let blur = image.blur.map_or_else(
        || "not blurred".to_owned(),
        |blur| format!("blurred by a Gaussian of {blur:?} pixels a side").to_lowercase(),
    );
    // Maps have a quarter of the sides of the input.
    let (decoding, cells) = (&config.decoding, rows / 4);
    let softening = decoding.softening_cells;
    let decode = format!(
        "of {cells}x{cells} cells; heatmaps below {} count as 0: the centre is where centers / (d + {softening}) is largest, d the distance \
         from the middle of the map in cells; a joint is roughly at that cell plus regressions (2n: x, \
         2n + 1: y) there, and its cell is where heatmaps / (d + {softening}) is largest, d the distance from \
         there; its position, 0 to 1, is (cell + offsets there) / {cells}, its score the heatmap there, and \
         of 0 it is not detected{}",
        decoding.confidence,
        // The published decoder's: in place of rounding to the nearest.
        if config.targets.parity { "; cells from regressions are trunc(value + 0.5)" } else { "" }
    );
    let passes = match decoding.second_pass {
        None => "1".to_owned(),
        Some(second) => format!(
            "2: the second sees the square about the joints that the first found, {} times as large as they \
             and at least {} of the image; where the latest events lie in a much smaller rectangle, a square \
             about that is tried too, and the higher score counts{}; see docs/guide/onnx.md",
            second.side,
            second.min_side,
            if second.consensus {
                "; then crops of 5/4 and 4/5 of its side and mirror images of all, unless `infer --consensus \
                 false`"
            } else {
                ""
            }
        ),
    };
    let entries = [
        ("representation", described(&image.representation)),
        ("window_end", "the time of the pose, events at it included".to_owned()),
        ("view", view.to_owned()),
        ("denoise", denoise(image.denoise)),
        (
            "input",
            format!(
                "float32 [batch, {channels}, {rows}, {columns}], the same grey in each channel"
            ),
        ),
        (
            "normalisation",
            format!("grey from 0 to 255, {blur}, resized ({:?})", image.interpolation)
                .to_lowercase(),
        ),
        (
            "outputs",
            format!(
                "heatmaps [batch, {BODY_JOINTS}, {cells}, {cells}], centers of 1 channel, regressions and \
                 offsets of {} channels",
                2 * BODY_JOINTS
            ),
        ),
        ("joints", JOINT_NAMES.join(",")),
        ("decoding", decode),
        ("confidence", decoding.confidence.to_string()),
        ("softening_cells", softening.to_string()),
        ("passes", passes),
    ];
    Interface {
        input: "events".to_owned(),
        outputs: ["heatmaps", "centers", "regressions", "offsets"].map(str::to_owned).to_vec(),
        metadata: entries.map(|(key, value)| (key.to_owned(), value)).to_vec(),
    }
}
