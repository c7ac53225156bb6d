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
    /// The values, the loss first. Another one that is not a number is unknown for this batch, and left out of
    /// means.
    pub values: Vec<f64>,
}

impl BatchValues {
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
    /// Whether the newest batch has the value, and any batch since the last reset.
    is_current: bool,
    is_known: bool,
}

impl ValueMetric {
    /// The metric of a value by its position.
    pub(crate) fn new((index, value): (usize, &LoggedValue)) -> Self {
        let state = NumericMetricState::default();
        Self { index, value: *value, state, is_current: false, is_known: false }
    }

    /// Adds the value of a batch to the mean, if it is known.
    fn take(&mut self, item: &BatchValues) -> bool {
        let value = item.values[self.index];
        // A loss that is not a number ends the training: it must be seen.
        self.is_current = self.index == 0 || !value.is_nan();
        if self.is_current {
            self.is_known = true;
            self.state.update(value, item.samples);
        }
        self.is_current
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
        if self.take(item) {
            return Ok(self.state.compute_update(self.format()));
        }
        Ok(SerializedEntry::not_available(self.format().unit_value().as_deref()))
    }

    fn compute(&mut self) -> Result<SerializedEntry, TensorReadError> {
        Ok(self.state.compute_final(self.format()))
    }

    fn clear(&mut self) {
        self.state.reset();
        (self.is_current, self.is_known) = (false, false);
    }
}

impl Numeric for ValueMetric {
    fn value(&self) -> Option<NumericEntry> {
        self.is_current.then(|| self.state.current_value())
    }

    fn running_value(&self) -> Option<NumericEntry> {
        self.is_known.then(|| self.state.running_value())
    }

    fn final_value(&self) -> NumericEntry {
        self.state.final_value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_values_are_left_out_of_the_mean() {
        let accuracy = LoggedValue { name: "accuracy", unit: "", higher_is_better: true };
        let mut metric = ValueMetric::new((1, &accuracy));
        let mut update = |value: f64| {
            let is_taken = metric.take(&BatchValues { samples: 2, values: vec![0.5, value] });
            assert_eq!(is_taken, metric.value().is_some());
            (is_taken, metric.running_value().map(|mean| mean.current()))
        };
        assert_eq!(update(f64::NAN), (false, None));
        assert_eq!(update(0.5), (true, Some(0.5)));
        assert_eq!(update(f64::NAN), (false, Some(0.5)));
        assert_eq!(update(1.0), (true, Some(0.75)));
    }
}
