//! The values that are shown and logged while a network trains.

use std::sync::Arc;

use burn::tensor::{ExecutionError, TensorReadError};
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
    /// Its name in `metrics.jsonl` and on screen.
    pub name: &'static str,
    /// Its unit, empty where it has none.
    pub unit: &'static str,
    /// Whether more of it is better.
    pub higher_is_better: bool,
}

impl LoggedValue {
    /// A value of which less is better.
    pub const fn error(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, higher_is_better: false }
    }
}

/// The logged values of a batch, on the host: as many and in the order of the task's [`LoggedValue`]s.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchValues {
    /// Samples in the batch.
    pub samples: usize,
    /// The values, the loss first.
    pub values: Vec<f64>,
}

impl BatchValues {
    /// The loss.
    pub(crate) fn loss(&self) -> f64 {
        self.values[0]
    }
}

impl ItemLazy for BatchValues {
    fn sync(self) -> Result<Self, ExecutionError> {
        Ok(self)
    }
}

impl Adaptor<Self> for BatchValues {
    fn adapt(&self) -> Self {
        self.clone()
    }
}

/// A running mean of one of the [`BatchValues`], as Burn wants it.
#[derive(Clone)]
pub(crate) struct ValueMetric {
    index: usize,
    value: LoggedValue,
    state: NumericMetricState,
}

impl ValueMetric {
    /// The metric of a value by its position.
    pub(crate) fn new((index, value): (usize, &LoggedValue)) -> Self {
        Self { index, value: *value, state: NumericMetricState::default() }
    }

    fn format(&self) -> FormatOptions {
        let options = FormatOptions::new(self.name()).precision(3);
        if self.value.unit.is_empty() { options } else { options.unit(self.value.unit) }
    }
}

impl Metric for ValueMetric {
    type Input = BatchValues;

    fn name(&self) -> MetricName {
        Arc::new(self.value.name.to_owned())
    }

    fn attributes(&self) -> MetricAttributes {
        let unit = (!self.value.unit.is_empty()).then(|| self.value.unit.to_owned());
        NumericAttributes { unit, higher_is_better: self.value.higher_is_better }.into()
    }

    fn update(
        &mut self,
        item: &BatchValues,
        _: &MetricMetadata,
    ) -> Result<SerializedEntry, TensorReadError> {
        self.state.update(item.values[self.index], item.samples);
        Ok(self.state.compute_update(self.format()))
    }

    fn compute(&mut self) -> Result<SerializedEntry, TensorReadError> {
        Ok(self.state.compute_final(self.format()))
    }

    fn clear(&mut self) {
        self.state.reset();
    }
}

impl Numeric for ValueMetric {
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
