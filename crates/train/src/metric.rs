//! The numbers shown and logged while a hand network trains.

use std::sync::Arc;

use burn::tensor::TensorReadError;
use burn_train::metric::state::{FormatOptions, NumericMetricState};
use burn_train::metric::{
    Adaptor, ItemLazy, Metric, MetricAttributes, MetricMetadata, MetricName, Numeric,
    NumericAttributes, NumericEntry, SerializedEntry,
};

/// What a batch came to. Plain numbers: the divergence check has read them already.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct StepScalars {
    /// Samples in the batch.
    pub batch_size: usize,
    /// The published loss L (not its logarithm), dimensionless.
    pub loss: f64,
    /// Root mean square error of the six articulation coefficients.
    pub articulation: f64,
    /// Root mean square error of the wrist position, in millimetres.
    pub translation_mm: f64,
    /// Root mean square error of the axis-angle vector, in degrees.
    pub rotation_deg: f64,
}

impl ItemLazy for StepScalars {
    fn sync(self) -> Result<Self, burn::tensor::ExecutionError> {
        Ok(self)
    }
}

/// One field of [`StepScalars`] as a metric.
#[derive(Clone, Copy)]
pub(crate) struct Field {
    /// Its name in the log and on screen.
    pub name: &'static str,
    /// Its unit, empty where it has none.
    pub unit: &'static str,
    get: fn(&StepScalars) -> f64,
}

/// The registry: everything logged per step. The first is what checkpoints are ranked by.
pub(crate) const FIELDS: [Field; 4] = [
    Field { name: "loss", unit: "", get: |s| s.loss },
    Field { name: "articulation", unit: "", get: |s| s.articulation },
    Field { name: "translation", unit: "mm", get: |s| s.translation_mm },
    Field { name: "rotation", unit: "deg", get: |s| s.rotation_deg },
];

/// A running mean of one [`Field`], as Burn wants it.
#[derive(Clone)]
pub(crate) struct FieldMetric {
    field: Field,
    state: NumericMetricState,
}

impl FieldMetric {
    /// The metric of `field`.
    pub(crate) fn new(field: Field) -> Self {
        Self { field, state: NumericMetricState::default() }
    }

    fn format(&self) -> FormatOptions {
        let options = FormatOptions::new(self.name()).precision(3);
        if self.field.unit.is_empty() { options } else { options.unit(self.field.unit) }
    }
}

impl Adaptor<StepScalars> for StepScalars {
    fn adapt(&self) -> StepScalars {
        *self
    }
}

impl Metric for FieldMetric {
    type Input = StepScalars;

    fn name(&self) -> MetricName {
        Arc::new(self.field.name.to_owned())
    }

    fn attributes(&self) -> MetricAttributes {
        let unit = (!self.field.unit.is_empty()).then(|| self.field.unit.to_owned());
        NumericAttributes { unit, higher_is_better: false }.into()
    }

    fn update(
        &mut self,
        item: &StepScalars,
        _: &MetricMetadata,
    ) -> Result<SerializedEntry, TensorReadError> {
        self.state.update((self.field.get)(item), item.batch_size);
        Ok(self.state.compute_update(self.format()))
    }

    fn compute(&mut self) -> Result<SerializedEntry, TensorReadError> {
        Ok(self.state.compute_final(self.format()))
    }

    fn clear(&mut self) {
        self.state.reset();
    }
}

impl Numeric for FieldMetric {
    fn value(&self) -> Option<NumericEntry> {
        Some(self.state.current_value())
    }

    fn running_value(&self) -> Option<NumericEntry> {
        Some(self.state.running_value())
    }

    fn final_value(&self) -> NumericEntry {
        self.state.final_value()
    }
}
