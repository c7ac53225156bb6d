//! Events to inputs of the network, and its outputs to poses: offline and online.

use anyhow::{Result, ensure};
use burn::tensor::{Tensor, TensorData};
use evpose_cli::tasks::values::ValueModel;
use evpose_core::{EventStream, Micros, SensorSize};
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};
use evpose_pose::{PoseEstimate, PoseLayout};
use evpose_repr::{ChannelOrder, Representation, StreamWindow, representation_by_name};
use evpose_task::TaskError;
use evpose_train::training::PlaneNetwork as _;

use crate::network::BlobModel;

/// Column and row of the centre, and the diameter, in pixels.
pub(crate) type Blob = [f32; 3];

pub(crate) static LAYOUT: PoseLayout =
    PoseLayout { name: "blob", values: &["centre_u_px", "centre_v_px", "size_px"] };

pub(crate) fn estimate(blob: &Blob) -> PoseEstimate {
    PoseEstimate::Values { layout: &LAYOUT, values: blob.to_vec() }
}

impl ValueModel for BlobModel {
    type Frontend = BlobFrontend;
    type Worker = Self;

    fn layout(&self) -> &'static PoseLayout {
        &LAYOUT
    }

    fn every(&self) -> Micros {
        Micros(1_000 * i64::from(self.card.config.every_ms.get()))
    }

    fn open_stream(&self, sensor: SensorSize) -> Result<PoseStream<BlobFrontend, Self>> {
        let config = &self.card.config;
        ensure!(sensor == config.sensor, "the network was trained before {}", config.sensor);
        let length = Micros(1_000 * i64::from(config.window_ms));
        let window = StreamWindow::new(sensor, length, ChannelOrder::OffFirst)?;
        let representation = representation_by_name(&config.representation)?.start(window);
        let planes = representation.channels();
        ensure!(planes == config.channels[0], "channels: the representation has {planes} planes");
        let frontend = BlobFrontend { representation, values: planes * sensor.pixels() };
        Ok(PoseStream::new(frontend, self.clone()))
    }
}

pub(crate) struct BlobFrontend {
    representation: Box<dyn Representation>,
    values: usize,
}

impl StreamFrontend for BlobFrontend {
    type Input = Vec<f32>;
    type Output = Blob;
    type Pose = Blob;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        self.representation.push(events);
        Ok(())
    }

    fn input(&mut self, t: Micros, memory: Option<Vec<f32>>) -> Option<Vec<f32>> {
        self.representation.advance(t);
        let mut planes = memory.unwrap_or_else(|| vec![0.0; self.values]);
        self.representation.render(&mut planes);
        Some(planes)
    }

    fn accept(&mut self, t: Micros, _: &Vec<f32>, blob: Blob, _: Micros) -> Vec<(Micros, Blob)> {
        vec![(t, blob)]
    }

    fn estimate(&self, blob: &Blob) -> PoseEstimate {
        estimate(blob)
    }

    fn propagate(&mut self, _: Micros) -> Option<PoseEstimate> {
        None
    }

    fn reset(&mut self) {
        self.representation.reset();
    }
}

impl InferenceWorker for BlobModel {
    type Input = Vec<f32>;
    type Output = Blob;

    fn infer(&mut self, planes: &Vec<f32>) -> Result<Blob, StreamError> {
        let [channels, height, width] = self.card.config.shape();
        let planes = TensorData::new(planes.clone(), [1, channels, height, width]);
        let output = self.network.forward(Tensor::from_data(planes, &self.device));
        let values: Vec<f32> = output.into_data().iter().collect();
        match values.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(StreamError::new(TaskError::NotFinite { value })),
            None => Ok(self.card.blob(&values)),
        }
    }
}
