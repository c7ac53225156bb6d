//! Storage of the values of an array.

/// Numeric type and byte order of stored values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    kind: Kind,
    /// Bytes of a value.
    bytes: usize,
    is_big_endian: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
}

impl Element {
    /// The element of a numpy type name such as `f8`, `<i4` or `>u2`; none for a type that is not
    /// numeric.
    pub fn parse(name: &str) -> Option<Self> {
        let (is_big_endian, name) = match name.as_bytes().first()? {
            b'>' => (true, &name[1..]),
            b'<' | b'|' | b'=' => (false, &name[1..]),
            _ => (false, name),
        };
        let (kind, bytes) = match name {
            "f4" => (Kind::Float, 4),
            "f8" => (Kind::Float, 8),
            "i1" => (Kind::Signed, 1),
            "i2" => (Kind::Signed, 2),
            "i4" => (Kind::Signed, 4),
            "i8" => (Kind::Signed, 8),
            "u1" | "b1" => (Kind::Unsigned, 1),
            "u2" => (Kind::Unsigned, 2),
            "u4" => (Kind::Unsigned, 4),
            "u8" => (Kind::Unsigned, 8),
            _ => return None,
        };
        Some(Self { kind, bytes, is_big_endian })
    }

    /// The same in the byte order `order`: `>` is the other one on the machines of today.
    pub fn with_order(self, order: &str) -> Self {
        Self { is_big_endian: order == ">", ..self }
    }

    /// Bytes of a value.
    pub fn size(self) -> usize {
        self.bytes
    }

    /// Decodes a value. Integers beyond 2^53 are rounded.
    pub(crate) fn decode(self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 8];
        for (k, byte) in bytes.iter().enumerate().take(8) {
            wide[if self.is_big_endian { bytes.len() - 1 - k } else { k }] = *byte;
        }
        let raw = u64::from_le_bytes(wide);
        match self.kind {
            Kind::Float if self.bytes == 4 => f32::from_bits(raw as u32).into(),
            Kind::Float => f64::from_bits(raw),
            Kind::Unsigned => raw as f64,
            Kind::Signed => {
                // The sign is the first bit of as many bytes as there are.
                let unused = 64 - 8 * self.bytes as u32;
                ((raw << unused) as i64 >> unused) as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_every_type_and_order_are_decoded() {
        let decode = |name: &str, bytes: &[u8]| Element::parse(name).map(|e| e.decode(bytes));
        assert_eq!(decode("<f8", &1.5f64.to_le_bytes()), Some(1.5));
        assert_eq!(decode(">f8", &1.5f64.to_be_bytes()), Some(1.5));
        assert_eq!(decode(">f4", &(-2.5f32).to_be_bytes()), Some(-2.5));
        assert_eq!(decode("<i4", &(-3i32).to_le_bytes()), Some(-3.0));
        assert_eq!(decode(">i8", &(-3i64).to_be_bytes()), Some(-3.0));
        assert_eq!(decode("<u4", &u32::MAX.to_le_bytes()), Some(4_294_967_295.0));
        assert_eq!(decode("|i1", &[0xff]), Some(-1.0));
        assert_eq!(decode("O8", &[0; 8]), None);
        assert_eq!(decode("é", &[0; 8]), None);
    }
}
