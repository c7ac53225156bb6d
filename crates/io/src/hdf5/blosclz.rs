//! BloscLZ, Blosc's own codec: runs of literals and copies of what came before.
//!
//! A control byte below 32 is followed by that many literals and one more. Any other holds, in its
//! upper three bits, the length of a copy less 2 (7: bytes follow that are added, to the first that
//! is not 255, and one more for a length of 9), and in its lower five the upper bits of the
//! distance less 1, whose lower eight are in a last byte. Where all those bits are set, two bytes
//! more are a distance beyond 8,191, the upper first. The first control byte of all has no upper
//! bits.
//!
//! Source: `blosclz.c` of c-blosc 1.21 (BSD-3-Clause), read for the format.

/// The largest distance of the short form.
const NEAR: usize = 8191;

/// Unpacks `packed` to the last byte of `out`; none if it does not fit.
pub(super) fn decode(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let mut bytes = packed.iter();
    let mut done = 0;
    // Literals come first: there is nothing to copy yet.
    let mut control = usize::from(*bytes.next()?) & 31;
    loop {
        if control < 32 {
            let (literals, rest) = bytes.as_slice().split_at_checked(control + 1)?;
            out.get_mut(done..done + literals.len())?.copy_from_slice(literals);
            done += literals.len();
            bytes = rest.iter();
        } else {
            let mut length = (control >> 5) + 2;
            let upper = (control & 31) << 8;
            // The longest length means that more bytes add to it.
            if length == 9 {
                loop {
                    let more = *bytes.next()?;
                    length += usize::from(more);
                    if more != 255 {
                        break;
                    }
                }
            }
            let lower = usize::from(*bytes.next()?);
            let mut distance = upper + lower + 1;
            // The largest near distance means that a far one follows.
            if distance == NEAR + 1 {
                let far = [*bytes.next()?, *bytes.next()?];
                distance += usize::from(u16::from_be_bytes(far));
            }
            copy(out, done, distance, length)?;
            done += length;
        }
        match bytes.next() {
            Some(next) => control = usize::from(*next),
            // The stream has to end where `out` is full.
            None => return (done == out.len()).then_some(()),
        }
    }
}

/// Copies `length` bytes from `distance` before `done`, which may be the bytes just written.
pub(super) fn copy(out: &mut [u8], done: usize, distance: usize, length: usize) -> Option<()> {
    let from = done.checked_sub(distance)?;
    let target = out.get_mut(from..done.checked_add(length)?)?;
    // Overlapping copies repeat what they have just written, byte by byte.
    if distance >= length {
        target.copy_within(..length, distance);
    } else {
        for k in distance..target.len() {
            target[k] = target[k - distance];
        }
    }
    Some(())
}
