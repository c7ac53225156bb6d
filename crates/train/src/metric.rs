//! The values that are shown and logged while a network trains.

use std::sync::Arc;

use burn::tensor::TensorReadError;
use burn_train::metric::state::{FormatOptions, NumericMetricState};
use burn_train::metric::{
    Adaptor, ItemLazy, Metric, MetricAttributes, MetricMetadata, MetricName, Numeric,
    NumericAttributes, NumericEntry, SerializedEntry,
};

/// The logged value that checkpoints are ranked by, the first of all.
pub const LOSS: &str = "loss";

/// A value that a training logs for each batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoggedValue {
    /// Its name in `metrics.jsonl`.
    pub name: &'static str,
    /// Its unit, empty where it has none.
    pub unit: &'static str,
    /// Whether more of it is better.
    pub higher_is_better: bool,
}

/// The logged values of a batch, on the host.
pub(crate) trait Scalars: ItemLazy + Adaptor<Self> + Copy + Send + Sync + 'static {
    /// Samples in the batch.
    fn batch_size(&self) -> usize;
}

/// One value of [`Scalars`] as a metric.
#[derive(Clone, Copy)]
pub(crate) struct Field<S> {
    /// Its name in the log and on screen.
    pub name: &'static str,
    /// Its unit, empty where it has none.
    pub unit: &'static str,
    /// Whether more of it is better.
    pub higher_is_better: bool,
    /// Reads the value.
    pub get: fn(&S) -> f64,
}

impl<S> Field<S> {
    /// Its description, for studies that read the log.
    pub(crate) fn logged(&self) -> LoggedValue {
        let Self { name, unit, higher_is_better, .. } = *self;
        LoggedValue { name, unit, higher_is_better }
    }
}

/// A running mean of one [`Field`], as Burn wants it.
#[derive(Clone)]
pub(crate) struct FieldMetric<S> {
    field: Field<S>,
    state: NumericMetricState,
}

impl<S: Scalars> FieldMetric<S> {
    /// The metric of `field`.
    pub(crate) fn new(field: Field<S>) -> Self {
        Self { field, state: NumericMetricState::default() }
    }

    fn format(&self) -> FormatOptions {
        let options = FormatOptions::new(self.name()).precision(3);
        if self.field.unit.is_empty() { options } else { options.unit(self.field.unit) }
    }
}

impl<S: Scalars> Metric for FieldMetric<S> {
    type Input = S;

    fn name(&self) -> MetricName {
        Arc::new(self.field.name.to_owned())
    }

    fn attributes(&self) -> MetricAttributes {
        let unit = (!self.field.unit.is_empty()).then(|| self.field.unit.to_owned());
        NumericAttributes { unit, higher_is_better: self.field.higher_is_better }.into()
    }

    fn update(&mut self, item: &S, _: &MetricMetadata) -> Result<SerializedEntry, TensorReadError> {
        self.state.update((self.field.get)(item), item.batch_size());
        Ok(self.state.compute_update(self.format()))
    }

    fn compute(&mut self) -> Result<SerializedEntry, TensorReadError> {
        Ok(self.state.compute_final(self.format()))
    }

    fn clear(&mut self) {
        self.state.reset();
    }
}

impl<S: Scalars> Numeric for FieldMetric<S> {
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
