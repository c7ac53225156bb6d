//! The body network with its loss: training and validation steps for Burn.

use burn::module::Module;
use burn::tensor::Tensor;
use burn_train::metric::{Adaptor, ItemLazy};
use burn_train::{InferenceStep, TrainOutput, TrainStep};
use evpose_nn::{BodyLoss, BodyLossParts, MoveEnet};
use evpose_pose::body::{BodyDecoder, BodyLabel, BodyMaps, DEFAULT_THRESHOLD};

use super::accuracy::{BodyAccuracy, BodyAccuracyConfig};
use super::loader::BodyItem;
use crate::guard::Guard;
use crate::metric::{Field, LOSS, LoggedValue, Scalars};

/// The logged values of a batch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct BodyScalars {
    batch_size: usize,
    loss: f64,
    heatmap: f64,
    bone: f64,
    center: f64,
    regs: f64,
    offsets: f64,
    /// Joints at most a fifth of the torso from where they should be: the published accuracy.
    accuracy: f64,
}

impl ItemLazy for BodyScalars {
    fn sync(self) -> Result<Self, burn::tensor::ExecutionError> {
        Ok(self)
    }
}

impl Adaptor<Self> for BodyScalars {
    fn adapt(&self) -> Self {
        *self
    }
}

impl Scalars for BodyScalars {
    fn batch_size(&self) -> usize {
        self.batch_size
    }
}

/// The values logged per step.
pub(super) const BODY_FIELDS: [Field<BodyScalars>; 7] = [
    field(LOSS, false, |s| s.loss),
    field("heatmap", false, |s| s.heatmap),
    field("bone", false, |s| s.bone),
    field("center", false, |s| s.center),
    field("regs", false, |s| s.regs),
    field("offsets", false, |s| s.offsets),
    field("accuracy", true, |s| s.accuracy),
];

/// The values that trainings of bodies log for each batch, the loss first.
pub fn body_values() -> Vec<LoggedValue> {
    BODY_FIELDS.iter().map(Field::logged).collect()
}

const fn field(
    name: &'static str,
    higher_is_better: bool,
    get: fn(&BodyScalars) -> f64,
) -> Field<BodyScalars> {
    Field { name, unit: "", higher_is_better, get }
}

/// The network with its loss.
#[derive(Module, Debug)]
pub(super) struct BodyLearner {
    pub(super) network: MoveEnet,
    #[module(skip)]
    loss: BodyLoss,
    #[module(skip)]
    guard: Guard,
}

impl BodyLearner {
    pub(super) fn new(network: MoveEnet, loss: BodyLoss, guard: Guard) -> Self {
        Self { network, loss, guard }
    }

    fn measure(&self, item: BodyItem) -> (BodyLossParts, BodyScalars) {
        let maps = self.network.forward(item.images);
        let accuracy = accuracy(&maps, &item.labels);
        let parts = self.loss.forward(maps, item.targets);
        let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
        let scalars = BodyScalars {
            batch_size: item.labels.len(),
            loss: read(&parts.total),
            heatmap: read(&parts.heatmap),
            bone: read(&parts.bone),
            center: read(&parts.center),
            regs: read(&parts.regs),
            offsets: read(&parts.offsets),
            accuracy,
        };
        (parts, scalars)
    }
}

/// The share of correctly detected joints.
fn accuracy(maps: &BodyMaps<Tensor<4>>, labels: &[BodyLabel]) -> f64 {
    let [batch, joints, rows, columns] = maps.heatmaps.dims();
    let decoder = BodyDecoder::new([rows, columns], DEFAULT_THRESHOLD);
    let values = |map: &Tensor<4>| -> Vec<f32> { map.clone().into_data().iter().collect() };
    let all = [&maps.heatmaps, &maps.centers, &maps.regs, &maps.offsets].map(values);
    let mut counts = BodyAccuracy::new(joints);
    for (sample, label) in labels.iter().enumerate() {
        let of = |map: &'_ [f32]| {
            let size = map.len() / batch;
            sample * size..(sample + 1) * size
        };
        let maps =
            BodyMaps::from_array([&all[0], &all[1], &all[2], &all[3]].map(|map| &map[of(map)]));
        counts.push(BodyAccuracyConfig::default(), &decoder.decode(&maps), label);
    }
    counts.mean().unwrap_or(0.0)
}

impl TrainStep for BodyLearner {
    type Input = BodyItem;
    type Output = BodyScalars;

    fn step(&self, item: BodyItem) -> TrainOutput<BodyScalars> {
        let step = item.step;
        let (parts, measured) = self.measure(item);
        self.guard.check(measured.loss, step);
        TrainOutput::new(self, parts.total.backward(), measured)
    }
}

impl InferenceStep for BodyLearner {
    type Input = BodyItem;
    type Output = BodyScalars;

    fn step(&self, item: BodyItem) -> BodyScalars {
        self.measure(item).1
    }
}
