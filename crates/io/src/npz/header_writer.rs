//! Writes the header of a NumPy array.

use super::ARRAY;

/// NumPy pads headers to multiples of this.
const ALIGNMENT: usize = 64;
/// Bytes before the text: what marks an array, its version, the length of the text.
const BEFORE: usize = ARRAY.len() + 4;

/// The header of an array in C order, as long as that of `longest`, a shape of more digits.
///
/// `descr` is the type as Python writes it, such as `'<f4'`.
pub(crate) fn header_for(descr: &str, shape: &[u64], longest: &[u64]) -> Vec<u8> {
    let text = |shape: &[u64]| {
        let sizes: String = shape.iter().map(|size| format!("{size}, ")).collect();
        format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({}), }}", sizes.trim_end())
    };
    // A line break ends it.
    let length = (BEFORE + text(longest).len() + 1).next_multiple_of(ALIGNMENT);
    let mut header = ARRAY.to_vec();
    header.extend_from_slice(&[1, 0]);
    header.extend_from_slice(&((length - BEFORE) as u16).to_le_bytes());
    header.extend_from_slice(text(shape).as_bytes());
    header.resize(length - 1, b' ');
    header.push(b'\n');
    header
}

#[cfg(test)]
mod tests {
    use super::header_for;

    #[test]
    fn headers_are_read_back_and_of_the_length_of_the_longest() {
        let longest = [u64::MAX; 4];
        for shape in [&[][..], &[7], &[1, 2], &[900, 2, 180, 240]] {
            let bytes = header_for("'<f4'", shape, &longest);
            assert_eq!(bytes.len(), 192);
            let header = crate::npz::header(&mut bytes.as_slice()).unwrap();
            assert_eq!(header.shape(), shape);
            assert_eq!(header.dtype().descr(), "'<f4'");
        }
        assert_eq!(header_for("'<i8'", &[7], &[7]).len(), 128);
    }
}
