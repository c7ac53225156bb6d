//! The bytes of a program: opcodes and their arguments.

use crate::pickle::PickleError;

/// Result of a step of a program.
pub(crate) type Step<T> = Result<T, PickleError>;

/// The failure of an instruction, whose place the caller fills in.
pub(crate) fn fault(reason: impl Into<String>) -> PickleError {
    PickleError { byte: 0, reason: reason.into() }
}

/// A program, and the position in it.
pub(crate) struct Program<'a> {
    pub(crate) bytes: &'a [u8],
    /// Offset of the next byte.
    pub(crate) at: usize,
}

impl<'a> Program<'a> {
    pub(crate) fn byte(&mut self) -> Step<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub(crate) fn take(&mut self, count: usize) -> Step<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or_else(|| fault("the file ends here"))?;
        self.at += count;
        Ok(taken)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Step<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// Reads a little-endian integer of `width` bytes.
    pub(crate) fn integer(&mut self, width: usize) -> Step<usize> {
        let mut bytes = [0; 8];
        bytes[..width].copy_from_slice(self.take(width)?);
        usize::try_from(u64::from_le_bytes(bytes)).map_err(|_| fault("too large a number"))
    }

    /// Reads up to the end of the line, and skips that.
    pub(crate) fn raw_line(&mut self) -> Step<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest
            .iter()
            .position(|&b| b == b'\n')
            .ok_or_else(|| fault("the file ends in a line"))?;
        self.at += length + 1;
        // Written on Windows in text mode.
        Ok(rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length]))
    }

    pub(crate) fn line(&mut self) -> Step<String> {
        utf8(self.raw_line()?)
    }

    /// Reads the index of a memo entry, in digits.
    pub(crate) fn decimal_index(&mut self) -> Step<usize> {
        let line = self.line()?;
        line.trim().parse().map_err(|_| fault(format!("`{line}` is no place of a value")))
    }
}

pub(crate) fn utf8(bytes: &[u8]) -> Step<String> {
    String::from_utf8(bytes.to_vec()).map_err(|_| fault("a text that is not UTF-8"))
}
