//! Response curves: from light to the codes of a frame, and back.

use std::fmt;
use std::str::FromStr;

/// Response curve of a camera's frames. One is white, zero is black, on both sides.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Response {
    /// Codes proportional to light, as in the raw frames of a DAVIS.
    #[default]
    Linear,
    /// sRGB, IEC 61966-2-1.
    Srgb,
    /// Light is this power of the code: 2.2 for a gamma of 2.2.
    Power(f64),
}

impl Response {
    /// Light of a code, both between 0 and 1.
    pub fn light(self, code: f64) -> f64 {
        let code = code.max(0.0);
        match self {
            Self::Linear => code,
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((code + 0.055) / 1.055).powf(2.4),
            Self::Power(gamma) => code.powf(gamma),
        }
    }

    /// Code of light, both between 0 and 1.
    pub fn code(self, light: f64) -> f64 {
        let light = light.max(0.0);
        match self {
            Self::Linear => light,
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
            Self::Power(gamma) => light.powf(1.0 / gamma),
        }
    }
}

impl fmt::Display for Response {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Linear => f.write_str("linear"),
            Self::Srgb => f.write_str("srgb"),
            Self::Power(gamma) => write!(f, "{gamma}"),
        }
    }
}

/// A text that is no response curve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no response curve: linear, srgb, or an exponent between 0.2 and 5 such as 2.2")]
pub struct UnknownResponse(String);

impl FromStr for Response {
    type Err = UnknownResponse;

    fn from_str(text: &str) -> Result<Self, UnknownResponse> {
        match text {
            "linear" => Ok(Self::Linear),
            "srgb" => Ok(Self::Srgb),
            other => match other.parse() {
                Ok(gamma) if (0.2..=5.0).contains(&gamma) => Ok(Self::Power(gamma)),
                _ => Err(UnknownResponse(text.to_owned())),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_and_codes_are_inverse_and_rise() {
        for response in [Response::Linear, Response::Srgb, Response::Power(2.2)] {
            let lights = (0..=1_000).map(|i| f64::from(i) / 1_000.0);
            let mut before = -1.0;
            for light in lights {
                let code = response.code(light);
                assert!(code > before, "{response}: {light}");
                assert!((response.light(code) - light).abs() < 1e-6, "{response}: {light}");
                before = code;
            }
            assert!((before - 1.0).abs() < 1e-9);
        }
        // The published value of middle grey.
        assert!((Response::Srgb.code(0.214_041) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn curves_are_read_as_they_are_written() {
        for text in ["linear", "srgb", "2.2"] {
            assert_eq!(text.parse::<Response>().unwrap().to_string(), text);
        }
        for text in ["", "gamma", "0", "-1", "9", "NaN"] {
            assert!(text.parse::<Response>().is_err(), "{text}");
        }
    }
}
