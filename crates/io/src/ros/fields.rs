//! Fields of a message, in the order of its definition.
//!
//! ROS 2 writes messages as CDR: four bytes that say which, then fields, values at multiples of their
//! length. ROS 1 writes fields without gaps, little-endian. Lengths of texts and lists are 32 bits in
//! both; a text of CDR ends with a byte of zero, which its length counts.
//!
//! # Source
//! <https://www.omg.org/spec/DDSI-RTPS/2.5>, 10.2; <https://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes>

use std::borrow::Cow;

/// The reason of a fault.
pub(super) type Reason = Cow<'static, str>;

/// How the fields of messages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Serialisation {
    /// Of ROS 2.
    Cdr,
    /// Of ROS 1.
    Ros1,
}

/// A message that is read field by field.
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    serialisation: Serialisation,
    is_big_endian: bool,
}

impl<'a> Fields<'a> {
    pub(super) fn new(message: &'a [u8], serialisation: Serialisation) -> Result<Self, Reason> {
        let (bytes, is_big_endian) = match (serialisation, message) {
            (Serialisation::Ros1, bytes) => (bytes, false),
            (Serialisation::Cdr, [0, order @ (0 | 1), _, _, bytes @ ..]) => (bytes, *order == 0),
            (Serialisation::Cdr, _) => return Err("a message that is no plain CDR".into()),
        };
        Ok(Self { bytes, at: 0, serialisation, is_big_endian })
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], Reason> {
        let taken = self.bytes.get(self.at..).and_then(|rest| rest.get(..length));
        self.at += length;
        taken.ok_or(Cow::Borrowed("a message ends within its fields"))
    }

    /// Passes over bytes.
    pub(super) fn skip(&mut self, length: usize) -> Result<(), Reason> {
        self.take(length).map(drop)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], Reason> {
        if self.serialisation == Serialisation::Cdr {
            // CDR aligns each value to its own size, counted from behind the first four bytes.
            self.at = self.at.next_multiple_of(N);
        }
        let mut number = [0; N];
        number.copy_from_slice(self.take(N)?);
        if self.is_big_endian {
            number.reverse();
        }
        Ok(number)
    }

    pub(super) fn u8(&mut self) -> Result<u8, Reason> {
        self.number().map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, Reason> {
        self.number().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, Reason> {
        self.number().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, Reason> {
        self.number().map(u64::from_le_bytes)
    }

    /// A list of bytes.
    pub(super) fn bytes(&mut self) -> Result<&'a [u8], Reason> {
        let length = self.u32()? as usize;
        self.take(length)
    }

    pub(super) fn text(&mut self) -> Result<&'a str, Reason> {
        let bytes = self.bytes()?;
        let text = bytes.strip_suffix(b"\0").unwrap_or(bytes);
        str::from_utf8(text).map_err(|_| Cow::Borrowed("a text that is no UTF-8"))
    }

    /// A time, microseconds since 1970.
    pub(super) fn time_us(&mut self) -> Result<i64, Reason> {
        let (seconds, nanoseconds) = (self.u32()?, self.u32()?);
        Ok(i64::from(seconds) * 1_000_000 + i64::from(nanoseconds / 1_000))
    }

    /// The header that messages of sensors begin with; its time.
    pub(super) fn header_us(&mut self) -> Result<i64, Reason> {
        // Only headers of ROS 1 begin with a sequence number.
        if self.serialisation == Serialisation::Ros1 {
            self.u32()?;
        }
        let time = self.time_us()?;
        self.text()?;
        Ok(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_stand_at_multiples_of_their_length_in_cdr_and_without_gaps_in_ros_1() {
        let cdr = [0, 1, 0, 0, 7, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 5];
        let mut fields = Fields::new(&cdr, Serialisation::Cdr).unwrap();
        assert_eq!((fields.u8(), fields.u32(), fields.text()), (Ok(7), Ok(9), Ok("ab")));
        assert_eq!((fields.left(), fields.u8()), (1, Ok(5)));
        assert!(fields.u16().is_err());
        let big = [0, 0, 0, 0, 1, 0, 0, 2];
        let mut fields = Fields::new(&big, Serialisation::Cdr).unwrap();
        assert_eq!((fields.u8(), fields.u16()), (Ok(1), Ok(2)));
        let mut fields = Fields::new(&[7, 9, 0, 0, 0, 1], Serialisation::Ros1).unwrap();
        assert_eq!((fields.u8(), fields.u32(), fields.u8()), (Ok(7), Ok(9), Ok(1)));
        assert!(Fields::new(&[0, 3, 0, 0], Serialisation::Cdr).is_err());
    }
}
