//! Bytes and bits that were put side by side by their place in a value, back where they were.

/// Undoes a shuffle of the bytes of values of `size` bytes: all first bytes, all second bytes, and
/// so on. What is left behind the last whole value was not moved.
pub(super) fn bytes(shuffled: &[u8], size: usize, out: &mut [u8]) {
    match size {
        // Usual sizes have loops of their own, which become vectors.
        1 => weave::<1>(shuffled, out),
        2 => weave::<2>(shuffled, out),
        4 => weave::<4>(shuffled, out),
        8 => weave::<8>(shuffled, out),
        _ => {
            let values = shuffled.len() / size;
            for place in 0..size {
                let plane = &shuffled[place * values..][..values];
                let places = out.iter_mut().skip(place).step_by(size);
                places.zip(plane).for_each(|(out, byte)| *out = *byte);
            }
        }
    }
    let whole = shuffled.len() / size * size;
    out[whole..].copy_from_slice(&shuffled[whole..]);
}

/// [`bytes`] for a size that the compiler knows.
fn weave<const N: usize>(shuffled: &[u8], out: &mut [u8]) {
    let values = shuffled.len() / N;
    let planes: [&[u8]; N] = std::array::from_fn(|place| &shuffled[place * values..][..values]);
    for (k, value) in out.as_chunks_mut::<N>().0.iter_mut().enumerate() {
        *value = std::array::from_fn(|place| planes[place][k]);
    }
}

/// Undoes a shuffle of the bits of values of `size` bytes: the lowest bits of all first bytes, and
/// so on. Values come in eights; Blosc leaves blocks of another number as they are.
///
/// Source: the `bitshuffle` library, function `bshuf_untrans_bit_elem`, for the order of bits.
pub(super) fn bits(shuffled: &[u8], size: usize, out: &mut [u8]) {
    let values = shuffled.len() / size;
    if values == 0 || !values.is_multiple_of(8) {
        out.copy_from_slice(shuffled);
        return;
    }
    let row = values / 8;
    let mut planes = vec![0; values * size];
    for (rows, plane) in shuffled.chunks_exact(8 * row).zip(planes.chunks_exact_mut(values)) {
        // Eight rows of bits, a row of each place, make one plane of bytes of the values.
        let rows: [&[u8]; 8] = std::array::from_fn(|bit| &rows[bit * row..][..row]);
        for (k, eight) in plane.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            *eight = transposed(std::array::from_fn(|bit| rows[bit][k]));
        }
    }
    let whole = values * size;
    // Planes of bytes are a shuffle of bytes, which is undone next.
    bytes(&planes, size, &mut out[..whole]);
    out[whole..].copy_from_slice(&shuffled[whole..]);
}

/// Bit `j` of byte `i` becomes bit `i` of byte `j`.
///
/// Source: H. Warren, Hacker's Delight, 7-3: blocks of 1, 2 and 4 bits change places.
fn transposed(bytes: [u8; 8]) -> [u8; 8] {
    let mut x = u64::from_le_bytes(bytes);
    for (by, mask) in
        [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)]
    {
        // Three swaps of blocks of 1, 2 and 4 bits transpose 8 by 8 (Warren: Hacker's Delight,
        // 7-3).
        let moved = (x ^ x >> by) & mask;
        x ^= moved ^ moved << by;
    }
    x.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn shuffled_bytes_come_back(
            size in 1_usize..20,
            data in prop::collection::vec(any::<u8>(), 0..300),
        ) {
            let values = data.len() / size;
            let mut shuffled = data.clone();
            for k in 0..values * size {
                shuffled[k % size * values + k / size] = data[k];
            }
            let mut out = vec![0; data.len()];
            bytes(&shuffled, size, &mut out);
            prop_assert_eq!(out, data);
        }

        #[test]
        fn shuffled_bits_come_back(
            size in 1_usize..10,
            eights in 0_usize..8,
            data in prop::collection::vec(any::<u8>(), 700),
            rest in 0_usize..8,
        ) {
            let data = &data[..size * 8 * eights + rest.min(size - 1)];
            let mut shuffled = data.to_vec();
            shuffled[..size * 8 * eights].fill(0);
            for bit in 0..size * 64 * eights {
                let (value, place) = (bit / (8 * size), bit % (8 * size));
                let to = place * 8 * eights + value;
                shuffled[to / 8] |= (data[bit / 8] >> (bit % 8) & 1) << (to % 8);
            }
            let mut out = vec![0; data.len()];
            bits(&shuffled, size, &mut out);
            prop_assert_eq!(out, data);
        }
    }
}
