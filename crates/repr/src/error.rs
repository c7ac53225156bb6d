//! Errors of names, parameters and windows.

use evpose_core::{Micros, NumberSpec, Parameter, ParameterError};

use crate::StreamWindow;

/// Error of looking up or configuring a representation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReprError {
    /// No representation has this name.
    #[error(
        "no representation is called `{name}`; there are {}",
        known.join(", ")
    )]
    UnknownRepresentation {
        /// Name that was asked for.
        name: String,
        /// The names of the registry.
        known: Vec<&'static str>,
    },
    /// A parameter that the representation does not have, or a value that one does not take.
    #[error("representation `{representation}`{}", of_representation(error))]
    Parameter {
        /// Name of the representation.
        representation: &'static str,
        /// Name of the parameter, and why it is refused.
        error: ParameterError,
    },
    /// A window of a stream that is empty or too long.
    #[error("a window of {length} is not within 1 µs to {}", StreamWindow::MAX_LENGTH)]
    WindowLength {
        /// Length that was asked for.
        length: Micros,
    },
}

fn of_representation(error: &ParameterError) -> String {
    match error {
        ParameterError::BadValue { parameter: Parameter::Number(spec), value } => {
            let NumberSpec { name, unit, kind, range: (low, high), .. } = spec;
            let of = if unit.is_empty() { "" } else { " of " };
            format!(": `{name}` is {}{of}{unit} from {low} to {high}, not `{value}`", kind.words())
        }
        _ => format!(" {error}"),
    }
}

#[cfg(test)]
mod tests {
    use crate::representation_by_name;

    #[test]
    fn what_a_parameter_does_not_take_is_refused_with_what_it_takes() {
        for (name, want) in [
            ("kernel=8", ": `kernel` is an odd number of px from 1 to 31, not `8`"),
            ("decay=2", ": `decay` is a number from 0 to 1, not `2`"),
            ("kernel=9,tau=3", " has no parameter `tau`; it has kernel, decay"),
            ("", " has no parameter ``; it has kernel, decay"),
        ] {
            let refused =
                representation_by_name(&format!("eros:{name}")).map_err(|e| e.to_string());
            assert_eq!(refused.err(), Some(format!("representation `eros`{want}")));
        }
    }
}
