//! Scalars as files store them, and the order of the values of an array.

/// Byte order of stored values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    pub(crate) fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            Self::Little => u32::from_le_bytes(bytes),
            Self::Big => u32::from_be_bytes(bytes),
        }
    }
}

/// Type of stored values, of any length up to eight bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberKind {
    Float,
    Signed,
    Unsigned,
}

impl NumberKind {
    pub(crate) fn decode(self, bytes: &[u8], order: ByteOrder) -> Number {
        let mut wide = [0; 8];
        // Little-endian at the low end, whatever the order of the file.
        for (i, byte) in bytes.iter().enumerate().take(8) {
            wide[if order == ByteOrder::Little { i } else { bytes.len() - 1 - i }] = *byte;
        }
        let raw = u64::from_le_bytes(wide);
        match self {
            Self::Float if bytes.len() == 4 => Number::Real(f32::from_bits(raw as u32).into()),
            Self::Float => Number::Real(f64::from_bits(raw)),
            Self::Unsigned => Number::Integer(raw.into()),
            Self::Signed => {
                // The sign is the first bit of as many bytes as there are.
                let unused = 64 - 8 * bytes.len() as u32;
                Number::Integer(((raw << unused) as i64 >> unused).into())
            }
        }
    }
}

/// A stored value before conversion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    Integer(i128),
    Real(f64),
}

impl Number {
    pub(crate) fn as_f64(self) -> f64 {
        match self {
            Self::Integer(value) => value as f64,
            Self::Real(value) => value,
        }
    }

    /// The value as an integer, if it has no fraction and fits.
    pub(crate) fn as_i64(self) -> Option<i64> {
        match self {
            Self::Integer(value) => i64::try_from(value).ok(),
            // From -2⁶³ up to but without 2⁶³, both of which are exact in double precision.
            Self::Real(value) if value.fract() == 0.0 && value.abs() < 9.223_372_036_854_776e18 => {
                Some(value as i64)
            }
            Self::Real(_) => None,
        }
    }
}

/// Reorders a column-major array into a row-major one.
pub(crate) fn row_major(stored: &[f64], shape: &[usize]) -> Vec<f64> {
    let (mut strides, mut stride) = (Vec::with_capacity(shape.len()), 1);
    // Column-major: neighbours along the first dimension are next to each other.
    for &length in shape {
        strides.push(stride);
        stride *= length;
    }
    let mut values = Vec::with_capacity(stored.len());
    let mut position = vec![0; shape.len()];
    for _ in 0..stored.len() {
        let at: usize = position.iter().zip(&strides).map(|(at, stride)| at * stride).sum();
        values.push(stored[at]);
        // The result is row-major: its last dimension runs fastest.
        for (at, &length) in position.iter_mut().zip(shape).rev() {
            *at = (*at + 1) % length;
            if *at != 0 {
                break;
            }
        }
    }
    values
}
