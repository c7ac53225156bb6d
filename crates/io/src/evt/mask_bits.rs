//! Positions of the set bits of a mask, eight at a time.

/// Of every byte, the positions of its set bits from the lowest up; zeros behind them are
/// overwritten.
static BITS: [[u16; 8]; 256] = bits();

/// Puts a word for every set bit of the first `8 * BYTES` of `mask`: `first`, with the position of the
/// bit added `shift` bits further left. They begin at place `count`, which is then behind them; up to
/// seven places behind that are written over.
#[inline(always)]
pub(super) fn put_bits<const BYTES: usize>(
    first: u64,
    mask: u32,
    shift: u32,
    places: &mut [u64],
    count: &mut usize,
) {
    for byte in 0..BYTES {
        let bits = mask >> (8 * byte) & 0xFF;
        let first = first + ((8 * byte as u64) << shift);
        let words = BITS[bits as usize].map(|bit| first + (u64::from(bit) << shift));
        // Always eight, of which those beyond the set bits are written over next: no branch a bit.
        places[*count..*count + 8].copy_from_slice(&words);
        *count += bits.count_ones() as usize;
    }
}

const fn bits() -> [[u16; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut byte = 0;
    // `for` loops are not possible in a `const fn`.
    while byte < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[byte][count] = bit;
                count += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    table
}
