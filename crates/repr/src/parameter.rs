//! Parameters of representations and their values.

use crate::ReprError;

/// Largest number of parameters of a representation.
const MAX_PARAMETERS: usize = 4;

/// A numeric parameter of a representation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name in `representation:name=value`.
    pub name: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Effect, in one line.
    pub summary: &'static str,
    /// Accepted values between the bounds.
    pub kind: ParameterKind,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// Default value.
    pub default: f64,
}

/// Accepted values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// Any value.
    Real,
    /// Integers.
    Whole,
    /// Odd integers.
    Odd,
    /// Even integers.
    Even,
}

impl Parameter {
    fn takes(&self, value: f64) -> bool {
        let rest = match self.kind {
            ParameterKind::Real => 0.0,
            ParameterKind::Whole => value.rem_euclid(1.0),
            ParameterKind::Odd => (value - 1.0).rem_euclid(2.0),
            ParameterKind::Even => value.rem_euclid(2.0),
        };
        (self.min..=self.max).contains(&value) && rest == 0.0
    }

    fn parse(&'static self, representation: &str, text: &str) -> Result<f64, ReprError> {
        let value = text.parse().ok().filter(|&value| self.takes(value));
        value.ok_or_else(|| ReprError::ParameterValue {
            representation: representation.to_owned(),
            parameter: self,
            text: text.to_owned(),
        })
    }
}

/// The values of a representation's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterValues {
    parameters: &'static [Parameter],
    values: [f64; MAX_PARAMETERS],
}

impl ParameterValues {
    /// Default values.
    pub fn defaults(parameters: &'static [Parameter]) -> Self {
        let mut values = [0.0; MAX_PARAMETERS];
        for (value, parameter) in values.iter_mut().zip(parameters) {
            *value = parameter.default;
        }
        Self { parameters, values }
    }

    /// Parses and sets `settings`: `name=value`, separated by commas.
    ///
    /// # Errors
    /// A name that `representation` does not have, or a value that it does not take.
    pub fn set(&mut self, representation: &str, settings: &str) -> Result<(), ReprError> {
        for setting in settings.split(',') {
            let (name, text) = setting.split_once('=').unwrap_or((setting, ""));
            let at = self.parameters.iter().position(|parameter| parameter.name == name);
            let at = at.ok_or_else(|| ReprError::UnknownParameter {
                representation: representation.to_owned(),
                parameter: name.to_owned(),
                parameters: self.parameters,
            })?;
            self.values[at] = self.parameters[at].parse(representation, text)?;
        }
        Ok(())
    }

    /// The parameters and their values.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Parameter, f64)> + '_ {
        self.parameters.iter().zip(self.values)
    }

    /// The value of a parameter.
    ///
    /// # Panics
    /// If there is none of that name.
    pub fn number(&self, name: &str) -> f64 {
        let found = self.iter().find(|(parameter, _)| parameter.name == name);
        found.unwrap_or_else(|| panic!("no parameter is called `{name}`")).1
    }

    /// Value of an integer parameter.
    ///
    /// # Panics
    /// If there is none of that name.
    pub fn whole(&self, name: &str) -> u32 {
        self.number(name) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMETERS: &[Parameter] = &[
        Parameter {
            name: "kernel",
            unit: "px",
            summary: "",
            kind: ParameterKind::Odd,
            min: 1.0,
            max: 31.0,
            default: 7.0,
        },
        Parameter {
            name: "decay",
            unit: "",
            summary: "",
            kind: ParameterKind::Real,
            min: 0.0,
            max: 1.0,
            default: 0.3,
        },
    ];

    fn set(settings: &str) -> Result<[f64; 2], String> {
        let mut values = ParameterValues::defaults(PARAMETERS);
        values.set("eros", settings).map_err(|error| error.to_string())?;
        Ok(["kernel", "decay"].map(|name| values.number(name)))
    }

    #[test]
    fn what_is_not_set_has_its_default() {
        assert_eq!(set("kernel=9"), Ok([9.0, 0.3]));
        assert_eq!(set("decay=0.5,kernel=1"), Ok([1.0, 0.5]));
    }

    #[test]
    fn what_a_parameter_does_not_take_is_refused_with_what_it_takes() {
        for text in ["8", "33", "-1", "7.5", "nan", "inf", ""] {
            let want = format!(
                "representation `eros`: `kernel` is an odd number of px from 1 to 31, not `{text}`"
            );
            assert_eq!(set(&format!("kernel={text}")), Err(want));
        }
        let want = "representation `eros` has no parameter `tau`; it has kernel, decay";
        assert_eq!(set("kernel=9,tau=3"), Err(want.to_owned()));
        let want = "representation `eros` has no parameter ``; it has kernel, decay";
        assert_eq!(set(""), Err(want.to_owned()));
    }
}
