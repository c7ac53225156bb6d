//! LZF, h5py's own compression: literals and copies of what came before.
//!
//! A control byte below 32 is followed by that many literals and one more. Any other holds, in its
//! upper three bits, the length of a copy less 2 (7: a byte follows that is added), and in its
//! lower five the upper bits of the distance less 1, whose lower eight are in a last byte.
//!
//! Source: `lzf_d.c` of LibLZF 3.6 (BSD-2-Clause), read for the format.

use super::blosclz::copy;

/// Unpacks `packed` to the last byte of `out`; none if it does not fit.
pub(super) fn decode(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let mut bytes = packed.iter();
    let mut done = 0;
    while let Some(control) = bytes.next().copied().map(usize::from) {
        // Below 32 it counts literals, less one; else its upper 3 bits are the length of a copy.
        if control < 32 {
            let (literals, rest) = bytes.as_slice().split_at_checked(control + 1)?;
            out.get_mut(done..done + literals.len())?.copy_from_slice(literals);
            done += literals.len();
            bytes = rest.iter();
            continue;
        }
        let mut length = (control >> 5) + 2;
        // The largest length of 3 bits says that a byte adds to it.
        if length == 9 {
            length += usize::from(*bytes.next()?);
        }
        let distance = ((control & 31) << 8) + usize::from(*bytes.next()?) + 1;
        copy(out, done, distance, length)?;
        done += length;
    }
    (done == out.len()).then_some(())
}
