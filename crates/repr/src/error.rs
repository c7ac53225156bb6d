//! Errors of names, parameters and windows.

use evpose_core::Micros;

use crate::{Parameter, ParameterKind, StreamWindow};

/// Error of looking up or configuring a representation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReprError {
    /// No representation has this name.
    #[error(
        "no representation is called `{name}`; there are {}",
        known.join(", ")
    )]
    UnknownRepresentation {
        /// The name.
        name: String,
        /// The names of the registry.
        known: Vec<&'static str>,
    },
    /// A representation has no such parameter.
    #[error(
        "representation `{representation}` has no parameter `{parameter}`; it has {}",
        parameter_names(parameters)
    )]
    UnknownParameter {
        /// The representation.
        representation: String,
        /// The name.
        parameter: String,
        /// Those it has.
        parameters: &'static [Parameter],
    },
    /// A parameter does not take this value.
    #[error("representation `{representation}`: {}, not `{text}`", accepted_values(parameter))]
    ParameterValue {
        /// The representation.
        representation: String,
        /// The parameter.
        parameter: &'static Parameter,
        /// The value, as given.
        text: String,
    },
    /// A window of a stream that is empty or too long.
    #[error("a window of {length} is not within 1 µs to {}", StreamWindow::MAX_LENGTH)]
    WindowLength {
        /// Its length.
        length: Micros,
    },
}

fn parameter_names(parameters: &[Parameter]) -> String {
    match parameters {
        [] => "none".to_owned(),
        _ => parameters.iter().map(|parameter| parameter.name).collect::<Vec<_>>().join(", "),
    }
}

fn accepted_values(parameter: &Parameter) -> String {
    let Parameter { name, unit, kind, min, max, .. } = parameter;
    let kind = match kind {
        ParameterKind::Real => "a number",
        ParameterKind::Whole => "a whole number",
        ParameterKind::Odd => "an odd number",
        ParameterKind::Even => "an even number",
    };
    let of = if unit.is_empty() { "" } else { " of " };
    format!("`{name}` is {kind}{of}{unit} from {min} to {max}")
}
