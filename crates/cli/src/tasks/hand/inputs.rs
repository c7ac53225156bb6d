//! The inputs of a network of hands, and the way to and from them, for runtimes of others.

use std::path::Path;
use std::sync::mpsc::{Sender, channel};

use anyhow::Result;
use evpose_clean::Denoise;
use evpose_core::Micros;
use evpose_infer::onnx::Interface;
use evpose_io::{OpenOptions, Windows};
use evpose_nn::{HandHead, JointNet, RotationOutput};
use evpose_pose::stream::InferenceSchedule;
use evpose_pose::{EVALUATION_JOINTS, HandPose, PARAMETER_NAMES};
use evpose_repr::{ChannelOrder, representation_by_name};
use evpose_task::TaskError;
use evpose_task::hand::{NetworkPredictor, Predictor, calibration_for, hand_recording};

use super::HandNetwork;
use crate::tasks::task::NetworkModel as _;

/// Hands on inputs, and predicts nothing.
struct InputTap {
    network: NetworkPredictor,
    inputs: Sender<Vec<f32>>,
}

impl Predictor for InputTap {
    fn predict(
        &mut self,
        inputs: &[f32],
        (height, width): (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        // The receiver lives as long as the recording.
        let _ = self.inputs.send(self.network.first_inputs(inputs));
        Ok(vec![HandPose::default(); inputs.len() / (2 * height * width)])
    }
}

/// As [`NetworkModel::for_each_input`](crate::tasks::NetworkModel::for_each_input).
pub(super) fn for_each(
    model: &HandNetwork,
    recording: &Path,
    every_ms: Option<u32>,
    opening: &OpenOptions,
    take: &mut dyn FnMut(Micros, &[f32]) -> Result<()>,
) -> Result<Vec<String>> {
    let config = &model.checkpoint.config;
    let windows = Windows::open(recording, opening)?;
    let calibration = calibration_for(config, windows.sensor(), None)?;
    let (sender, inputs) = channel();
    let network = model.checkpoint.predictor(model.device.clone())?;
    let tap = InputTap { network, inputs: sender };
    let every = Micros(1_000 * i64::from(every_ms.unwrap_or(1).max(1)));
    let schedule = InferenceSchedule::Every(every);
    let mut stream = hand_recording(config, tap, windows, &calibration, schedule)?;
    let size = model.input_shape().iter().product();
    while let Some(inferred) = stream.next().transpose()? {
        // Those of nobody went through the network as well.
        let of_poses = inferred.poses.iter().map(|(t, _)| *t);
        let mut times: Vec<Micros> = inferred.skipped.into_iter().chain(of_poses).collect();
        times.sort();
        let values: Vec<f32> = inputs.try_iter().flatten().collect();
        for (t, input) in times.into_iter().zip(values.chunks_exact(size)) {
            take(t, input)?;
        }
    }
    Ok(stream.warnings())
}

/// As [`NetworkModel::interface`](crate::tasks::NetworkModel::interface).
pub(super) fn interface(model: &HandNetwork) -> Interface {
    let config = &model.checkpoint.config;
    let ([channels, rows, columns], input) = (model.input_shape(), &config.representation);
    let order = match input.channel_order {
        ChannelOrder::OffFirst => "OFF, ON",
        ChannelOrder::OnFirst => "ON, OFF",
    };
    let network = model.checkpoint.network.config();
    let (rotation, names) = (network.rotation, PARAMETER_NAMES.join(","));
    let is_of_joints = network.head == HandHead::Joints;
    let decoding = match rotation {
        _ if is_of_joints => {
            "the softmax of a heatmap over its cells gives a joint's column and row, and the mean of its depth \
             map, in palms behind the wrist; the parameters are those of the hand that fits"
        }
        RotationOutput::AxisAngle => {
            "the outputs are the parameters: no unit, metres, and an axis times an angle in radians"
        }
        RotationOutput::SixD => {
            "the first nine outputs are the first nine parameters; the other six are two columns of the \
             rotation matrix: x is the first normalised, y the second without its part along x, normalised, \
             z = x cross y; the last three parameters are the axis times the angle of the matrix (x, y, z)"
        }
    };
    let passes = match config.two_pass {
        None => "1".to_owned(),
        Some(_) => "2: the second sees a perspective crop of the view about the hand that the first found, \
                    see docs/guide/onnx.md"
            .to_owned(),
    };
    let hold = config.hold.map_or_else(
        || "none".to_owned(),
        |hold| {
            format!(
                "while an input sums to less than {} the pose before it stays",
                hold.rest_sum_of(config.simulation.image_size())
            )
        },
    );
    let (joints, stride) = (EVALUATION_JOINTS.len(), JointNet::STRIDE);
    let outputs = match is_of_joints {
        false => format!("parameters: float32 [batch, {}]", rotation.outputs()),
        true => format!(
            "heatmaps and depths: float32 [batch, {joints}, {}, {}]; presence, a logit: float32 [batch, 1]",
            rows / stride,
            columns / stride
        ),
    };
    let entries = [
        ("representation", described(&input.name)),
        ("window_ms", input.window_ms.to_string()),
        ("window_end", "the time of the pose, events at it not included".to_owned()),
        (
            "view",
            format!(
                "{} pixels of a vertical field of view of {} degrees",
                config.simulation.image_size(),
                config.simulation.camera.vertical_fov_deg
            ),
        ),
        ("denoise", denoise(input.denoise)),
        ("input", format!("float32 [batch, {channels}, {rows}, {columns}], channels {order}")),
        ("normalisation", "none: the values of the representation, 0 to 1".to_owned()),
        ("outputs", outputs),
        ("parameters", names),
        ("decoding", decoding.to_owned()),
        ("passes", passes),
        ("hold", hold),
    ];
    let names_of_outputs: &[&str] =
        if is_of_joints { &["heatmaps", "depths", "presence"] } else { &["parameters"] };
    Interface {
        input: "events".to_owned(),
        outputs: names_of_outputs.iter().map(|name| (*name).to_owned()).collect(),
        metadata: entries.map(|(key, value)| (key.to_owned(), value)).to_vec(),
    }
}

/// A representation by its name and what it is.
pub(in crate::tasks) fn described(name: &str) -> String {
    let summary = representation_by_name(name).map_or("", |choice| choice.spec().summary);
    format!("{name}: {summary}")
}

/// A filter of events in words.
pub(in crate::tasks) fn denoise(filter: Option<Denoise>) -> String {
    filter.map_or_else(
        || "none".to_owned(),
        |Denoise { tau_ms, neighbours }| {
            format!("events stay that {neighbours} of 8 neighbours confirm within {tau_ms} ms")
        },
    )
}
