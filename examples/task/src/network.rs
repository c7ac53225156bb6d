//! The network, its training and its file.

use std::path::Path;

use anyhow::Result;
use burn::module::Module;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::nn::{Linear, LinearConfig, PaddingConfig2d};
use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::activation::relu;
use burn::tensor::{Device, Tensor};
use evpose_cli::tasks::values::{ValueModel as _, mean_values};
use evpose_core::seed_for;
use evpose_nn::NnError;
use evpose_nn::backbone::{Initializer, seeded};
use evpose_nn::weights::{self, StoredNetwork};
use evpose_task::schedule::Schedule;
use evpose_train::training::{
    self, MeanSquareError, PlaneNetwork, PlaneSamples, TrainingData, TrainingTask,
};
use evpose_train::{LOSS, LoggedValue, TrainError, TrainOptions, TrainSummary};
use serde::{Deserialize, Serialize};

use crate::config::BlobConfig;
use crate::stream::Blob;

/// Convolutions that halve the image, and a fully connected layer.
#[derive(Module, Debug)]
pub(crate) struct BlobNetwork {
    convolutions: Vec<Conv2d>,
    head: Linear,
}

impl PlaneNetwork for BlobNetwork {
    fn forward(&self, planes: Tensor<4>) -> Tensor<2> {
        let features = self.convolutions.iter().fold(planes, |x, layer| relu(layer.forward(x)));
        self.head.forward(features.flatten(1, 3))
    }
}

/// The card of a weight file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct BlobCard {
    /// Mean of the labels, which outputs of the network are relative to.
    pub(crate) mean: Blob,
    pub(crate) config: BlobConfig,
}

impl BlobCard {
    fn scale_px(&self) -> f32 {
        f32::from(self.config.sensor.width)
    }

    pub(crate) fn blob(&self, output: &[f32]) -> Blob {
        std::array::from_fn(|k| self.mean[k] + self.scale_px() * output[k])
    }

    fn output(&self, blob: &[f32]) -> Vec<f32> {
        (0..3).map(|k| (blob[k] - self.mean[k]) / self.scale_px()).collect()
    }
}

impl StoredNetwork for BlobNetwork {
    type Card = BlobCard;

    const KEY: &'static str = "evpose.blob";

    fn of_card(card: &BlobCard, device: &Device) -> Result<Self, NnError> {
        let [_, mut rows, mut columns] = card.config.shape();
        let channels = &card.config.channels;
        let convolution = |pair: &[usize]| {
            (rows, columns) = (rows.div_ceil(2), columns.div_ceil(2));
            let config = Conv2dConfig::new([pair[0], pair[1]], [3, 3]).with_stride([2, 2]);
            config.with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1)).init(device)
        };
        let convolutions = channels.windows(2).map(convolution).collect();
        let features = channels[channels.len() - 1] * rows * columns;
        let network = Self { convolutions, head: LinearConfig::new(features, 3).init(device) };
        Ok(seeded(network, seed_for(card.config.seed, "weights", 0), |slot| match slot.name() {
            "bias" => Initializer::Constant(0.0),
            _ if slot.is_linear_weight() => Initializer::torch_default(features),
            _ => Initializer::kaiming_fan_in(&slot.shape),
        }))
    }
}

/// A network on its device with everything that is needed to use it.
#[derive(Debug, Clone)]
pub(crate) struct BlobModel {
    pub(crate) network: BlobNetwork,
    pub(crate) card: BlobCard,
    pub(crate) device: Device,
}

struct BlobTraining(BlobCard);

impl TrainingTask for BlobTraining {
    type Network = BlobNetwork;
    type Loss = MeanSquareError;
    type Checkpoint = (BlobNetwork, BlobCard);

    const VALUES: &'static [LoggedValue] =
        &[LoggedValue::error(LOSS, ""), LoggedValue::error("error", "px")];

    fn untrained(&self, device: &Device) -> Result<BlobNetwork, TrainError> {
        Ok(BlobNetwork::of_card(&self.0, device)?)
    }

    fn loss(&self) -> MeanSquareError {
        MeanSquareError { scale: self.0.scale_px().into() }
    }

    fn learning_rate(&self) -> ModuleLrScheduler {
        let config = &self.0.config;
        let schedule = Schedule { cosine: true, ..Schedule::constant() };
        schedule.rate(config.learning_rate, config.training.steps).into()
    }

    fn checkpoint(&self, network: BlobNetwork) -> Self::Checkpoint {
        (network, self.0.clone())
    }

    fn save((network, card): &Self::Checkpoint, path: &Path) -> Result<(), TrainError> {
        Ok(weights::save(path, network, card)?)
    }
}

/// Trains on the recordings in `data`.
pub(crate) fn train_blob(
    config: &BlobConfig,
    data: &Path,
    run: &Path,
    options: &TrainOptions,
) -> Result<Result<TrainSummary<(BlobNetwork, BlobCard)>, TrainError>> {
    let device = options.device.resolve()?;
    let mut card = BlobCard { mean: [0.0; 3], config: config.clone() };
    // Inputs do not depend on the weights.
    let network = BlobNetwork::of_card(&card, &device)?;
    let model = BlobModel { network, card: card.clone(), device };
    let parts = model.samples(data)?;
    card.mean = mean_values(&parts[0]);
    let validation_samples = parts[1].len() as u64;
    let [train, valid] = parts.map(|samples| {
        let samples = samples.into_iter().map(|(input, blob)| (input, card.output(&blob)));
        PlaneSamples::new(config.shape(), samples.collect(), seed_for(config.seed, "order", 0))
    });
    let data = TrainingData { train, valid, validation_samples };
    Ok(training::train(&BlobTraining(card), config, config.training, data, run, options))
}
