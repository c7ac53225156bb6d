//! Storage of the values of an array.

use crate::number::{ByteOrder, NumberKind};

/// Numeric type and byte order of stored values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    kind: NumberKind,
    /// Bytes of a value.
    bytes: usize,
    order: ByteOrder,
}

impl Element {
    /// The element of a numpy type name such as `f8`, `<i4` or `>u2`; none for a type that is not
    /// numeric.
    pub fn parse(name: &str) -> Option<Self> {
        let (order, name) = match name.as_bytes().first()? {
            b'>' => (ByteOrder::Big, &name[1..]),
            b'<' | b'|' | b'=' => (ByteOrder::Little, &name[1..]),
            _ => (ByteOrder::Little, name),
        };
        let (kind, bytes) = match name {
            "f4" => (NumberKind::Float, 4),
            "f8" => (NumberKind::Float, 8),
            "i1" => (NumberKind::Signed, 1),
            "i2" => (NumberKind::Signed, 2),
            "i4" => (NumberKind::Signed, 4),
            "i8" => (NumberKind::Signed, 8),
            "u1" | "b1" => (NumberKind::Unsigned, 1),
            "u2" => (NumberKind::Unsigned, 2),
            "u4" => (NumberKind::Unsigned, 4),
            "u8" => (NumberKind::Unsigned, 8),
            _ => return None,
        };
        Some(Self { kind, bytes, order })
    }

    /// The same in the byte order `order`: `>` is the other one on the machines of today.
    pub fn with_order(self, order: &str) -> Self {
        Self { order: if order == ">" { ByteOrder::Big } else { ByteOrder::Little }, ..self }
    }

    /// Bytes of a value.
    pub fn size(self) -> usize {
        self.bytes
    }

    /// Decodes a value. Integers beyond 2^53 are rounded.
    pub(crate) fn decode(self, bytes: &[u8]) -> f64 {
        self.kind.decode(bytes, self.order).as_f64()
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
