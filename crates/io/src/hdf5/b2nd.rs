//! Places of values that Blosc2 packed in several dimensions.
//!
//! The entry `b2nd` of a frame's header, of MessagePack: a version, the count of dimensions, and the shapes of the
//! array, of a chunk and of a block. Chunks of an array, blocks of a chunk and values of a block stand row by row; blocks
//! at the end of a chunk, and chunks at the end of the array, are filled up.
//!
//! Source: `README_B2ND_METALAYER.rst` and `README_CFRAME_FORMAT.rst` of c-blosc2 3.3 (BSD-3-Clause), read for the format.

use std::borrow::Cow;

/// Dimensions at most; arrays of events have one or two.
const MAX_DIMENSIONS: usize = 4;
/// The entry's name with its type, and that of the place of its content.
const NAME: &[u8] = b"\xa4b2nd\xd2";
/// Types: bytes behind a length of 32 bits, integers of 32 and of 64 bits.
const BYTES: u8 = 0xc6;
const INT32: u8 = 0xd2;
const INT64: u8 = 0xd3;

/// Lengths along each dimension; those that there are not are 1, before the others.
type Shape = [usize; MAX_DIMENSIONS];

/// Shapes of an array, a chunk and a block, and the size of a value in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shapes {
    array: Shape,
    chunk: Shape,
    block: Shape,
    size: usize,
}

impl Shapes {
    /// Shapes in the header of a frame, if it has some; the array has `max` bytes at most.
    pub(super) fn of(
        header: &[u8],
        size: usize,
        max: usize,
    ) -> Result<Option<Self>, Cow<'static, str>> {
        let Some(at) = header.windows(NAME.len()).position(|name| name == NAME) else {
            return Ok(None);
        };
        let shapes = Self::read(header, at + NAME.len(), size);
        let shapes = shapes.filter(|shapes| {
            let parts = shapes.array.iter().zip(&shapes.chunk).zip(&shapes.block);
            // Chunks of no more than the array, so that what is filled up is little more.
            let mut parts = parts.map(|((array, chunk), block)| [*array, *chunk, *block]);
            parts.all(|[array, chunk, block]| 0 < block && block <= chunk && chunk <= array)
                && product(shapes.array, size).is_some_and(|bytes| bytes <= max)
        });
        shapes.map(Some).ok_or("Blosc2's shapes of several dimensions, which are not read".into())
    }

    fn read(header: &[u8], at: usize, size: usize) -> Option<Self> {
        let place = u32::from_be_bytes(*header.get(at..)?.first_chunk()?) as usize;
        let (kind, content) = header.get(place..)?.split_first()?;
        // Behind the length: the list, its version, the count of dimensions.
        let [_, _, _, _, _, _, count] = *content.first_chunk()?;
        let (mut rest, count) = (&content[7..], usize::from(count));
        let mut shapes = [[1; MAX_DIMENSIONS]; 3];
        for shape in &mut shapes {
            // Shapes are aligned at their end, and dimensions that are missing have length 1.
            let lengths = shape.get_mut(MAX_DIMENSIONS.checked_sub(count)?..)?;
            rest = rest.get(1..)?;
            for length in lengths {
                let (kind, value) = rest.split_first()?;
                let bytes = match *kind {
                    INT32 => 4,
                    INT64 => 8,
                    _ => return None,
                };
                let (value, behind) = value.split_at_checked(bytes)?;
                let value = value.iter().fold(0, |value, byte| value << 8 | u64::from(*byte));
                (*length, rest) = (usize::try_from(value).ok()?, behind);
            }
        }
        let [array, chunk, block] = shapes;
        (*kind == BYTES).then_some(Self { array, chunk, block, size })
    }

    /// Bytes of the array.
    pub(super) fn bytes(&self) -> usize {
        product(self.array, self.size).unwrap_or(usize::MAX)
    }

    /// Bytes of a chunk, filled up to whole blocks.
    pub(super) fn chunk_bytes(&self) -> usize {
        let whole = each(self.chunk, self.block, |chunk, block| chunk.next_multiple_of(block));
        product(whole, self.size).unwrap_or(usize::MAX)
    }

    /// Count of chunks.
    pub(super) fn chunks(&self) -> usize {
        product(each(self.array, self.chunk, usize::div_ceil), 1).unwrap_or(usize::MAX)
    }

    /// Puts the values of chunk `index` in their places in the array.
    pub(super) fn place(&self, index: usize, chunk: &[u8], array: &mut [u8]) {
        const LAST: usize = MAX_DIMENSIONS - 1;
        let Self { size, .. } = *self;
        let begin = position(index, each(self.array, self.chunk, usize::div_ceil));
        let begin = each(begin, self.chunk, |chunks, length| chunks * length);
        // The chunk's end in the array.
        let end = each(begin, self.chunk, |begin, length| begin + length);
        let end = each(end, self.array, usize::min);
        let blocks = each(self.chunk, self.block, usize::div_ceil);
        let mut rows = self.block;
        rows[LAST] = 1;
        let row_bytes = self.block[LAST] * size;
        let block_bytes = product(self.block, size).unwrap_or(usize::MAX);
        for (k, block) in chunk.chunks_exact(block_bytes).enumerate() {
            let corner = each(position(k, blocks), self.block, |blocks, length| blocks * length);
            let corner = each(begin, corner, |begin, offset| begin + offset);
            for (k, row) in block.chunks_exact(row_bytes).enumerate() {
                let at = each(corner, position(k, rows), |corner, offset| corner + offset);
                // Blocks and chunks are filled up beyond the array, where a row has no place.
                if at.iter().zip(&end).any(|(at, end)| at >= end) {
                    continue;
                }
                let dimensions = at.iter().zip(&self.array);
                let offset = dimensions.fold(0, |offset, (at, length)| offset * length + at) * size;
                let bytes = row_bytes.min((end[LAST] - at[LAST]) * size);
                array[offset..offset + bytes].copy_from_slice(&row[..bytes]);
            }
        }
    }
}

fn each(a: Shape, b: Shape, of: impl Fn(usize, usize) -> usize) -> Shape {
    std::array::from_fn(|k| of(a[k], b[k]))
}

fn product(shape: Shape, size: usize) -> Option<usize> {
    shape.into_iter().try_fold(size, usize::checked_mul)
}

/// The place of number `index` of a shape, row by row.
fn position(mut index: usize, shape: Shape) -> Shape {
    let mut position = [0; MAX_DIMENSIONS];
    for (place, length) in position.iter_mut().zip(shape).rev() {
        (*place, index) = (index % length, index / length);
    }
    position
}
