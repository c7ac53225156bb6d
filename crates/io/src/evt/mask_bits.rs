//! Positions of the set bits of a mask, eight at a time.

/// Of every byte, the positions of its set bits from the lowest up; zeros behind them are
/// overwritten.
pub(super) static BITS: [[u16; 8]; 256] = bits();

const fn bits() -> [[u16; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut byte = 0;
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
