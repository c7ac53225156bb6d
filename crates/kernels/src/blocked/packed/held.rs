//! Images, however their numbers are kept, as kernels see them.

use super::image::{Packed, Scale, Storage};
use crate::blocked::image::Image;
use crate::blocked::tile::Activation;
use crate::simd::dots::{Bf16, Stored};
use crate::simd::{LANES, Lanes};

/// An image to read, however its numbers are kept.
#[derive(Debug, Clone, Copy)]
pub enum Held<'a> {
    /// In 32 bits.
    Whole(&'a Image),
    /// In fewer.
    Packed(&'a Packed),
}

/// An image to write, however its numbers are kept.
#[derive(Debug)]
pub enum HeldMut<'a> {
    /// In 32 bits.
    Whole(&'a mut Image),
    /// In fewer.
    Packed(&'a mut Packed),
}

impl Held<'_> {
    /// Channels, rows and columns.
    pub fn size(&self) -> [usize; 3] {
        match self {
            Self::Whole(image) => [image.channels(), image.height(), image.width()],
            Self::Packed(image) => image.size(),
        }
    }

    pub(super) fn from(&self) -> From {
        match self {
            Self::Whole(image) => From {
                pixels: image.tap(0, 0, 0, 0).cast(),
                kind: Kind::Whole,
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                scale: [1.0, 0.0],
            },
            Self::Packed(image) => From {
                pixels: image.first(),
                kind: Kind::of(image.storage()),
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                scale: match image.storage() {
                    Storage::Bf16 => [1.0, 0.0],
                    Storage::Byte(Scale { step, zero }) => [step, f32::from(zero)],
                },
            },
        }
    }
}

impl HeldMut<'_> {
    /// Channels, rows and columns.
    pub fn size(&self) -> [usize; 3] {
        match self {
            Self::Whole(image) => [image.channels(), image.height(), image.width()],
            Self::Packed(image) => image.size(),
        }
    }

    pub(in crate::blocked) fn to(&mut self) -> To {
        match self {
            Self::Whole(image) => To {
                pixels: image.first_mut().cast(),
                kind: Kind::Whole,
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                scale: [1.0, 0.0],
            },
            Self::Packed(image) => To {
                pixels: image.first_mut(),
                kind: Kind::of(image.storage()),
                row_pitch: image.row_pitch() * LANES,
                block_pitch: image.block_pitch() * LANES,
                scale: match image.storage() {
                    Storage::Bf16 => [1.0, 0.0],
                    Storage::Byte(Scale { step, zero }) => [1.0 / step, f32::from(zero)],
                },
            },
        }
    }
}

/// The largest byte.
const MOST: f32 = 255.0;

/// Bits of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Whole,
    Half,
    Byte,
}

impl Kind {
    fn of(storage: Storage) -> Self {
        match storage {
            Storage::Bf16 => Self::Half,
            Storage::Byte(_) => Self::Byte,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Whole => 4,
            Self::Half => 2,
            Self::Byte => 1,
        }
    }
}

/// Where numbers are, and what they stand for. Distances are in numbers.
#[derive(Clone, Copy)]
pub(super) struct From {
    pixels: *const u8,
    kind: Kind,
    row_pitch: usize,
    block_pitch: usize,
    /// What a number is multiplied by, after the other is taken from it: what stands for 0 is 0
    /// exactly.
    scale: [f32; 2],
}

// SAFETY: an image that somebody holds a reference to; it is only read.
unsafe impl Send for From {}
// SAFETY: as above.
unsafe impl Sync for From {}

impl From {
    /// How far the first pixel of a row of a block is from the first of all.
    pub(super) fn at(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    /// What sixteen numbers stand for.
    ///
    /// # Safety
    /// They are inside, and the processor has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn load<V: Lanes>(&self, at: usize) -> V {
        // SAFETY: the caller's.
        unsafe {
            let from = self.pixels.add(at * self.kind.bytes());
            match self.kind {
                Kind::Whole => V::load(from.cast()),
                Kind::Half => Bf16::load(from.cast()),
                Kind::Byte => {
                    let [step, zero] = self.scale.map(|value| V::splat(value));
                    u8::load::<V>(from).sub(zero).mul(step)
                }
            }
        }
    }
}

/// Where numbers go, and what they stand for there. Distances are in numbers.
#[derive(Clone, Copy)]
pub(in crate::blocked) struct To {
    pixels: *mut u8,
    kind: Kind,
    row_pitch: usize,
    block_pitch: usize,
    /// What a value is multiplied by, and what is added then.
    scale: [f32; 2],
}

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for To {}
// SAFETY: as above.
unsafe impl Sync for To {}

impl To {
    /// How far the first pixel of a row of a block is from the first of all.
    pub(in crate::blocked) fn at(&self, block: usize, y: usize) -> usize {
        block * self.block_pitch + y * self.row_pitch
    }

    /// Keeps sixteen values.
    ///
    /// # Safety
    /// There is room for them, nobody else writes there, and the processor has the instructions of
    /// `V`.
    #[inline(always)]
    pub(in crate::blocked) unsafe fn store<V: Lanes>(&self, value: V, at: usize) {
        // SAFETY: the caller's.
        unsafe {
            let to = self.pixels.add(at * self.kind.bytes());
            match self.kind {
                Kind::Whole => value.store(to.cast()),
                Kind::Half => Bf16::store(value, to.cast()),
                Kind::Byte => {
                    let [factor, term] = self.scale.map(|value| V::splat(value));
                    u8::store(value.mul_add(factor, term), to);
                }
            }
        }
    }

    /// What keeps values in bytes, if that is how they are kept, behind an activation.
    #[inline(always)]
    pub(super) fn bytes(&self, activation: Activation) -> Option<ToBytes> {
        let [factor, zero] = self.scale;
        (self.kind == Kind::Byte).then(|| {
            let low = if activation == Activation::Identity { 0.0 } else { zero };
            let is_cut = activation == Activation::Relu6;
            let high = if is_cut { 6.0_f32.mul_add(factor, zero) } else { MOST };
            ToBytes { pixels: self.pixels, factor, zero, low, high }
        })
    }

    /// Keeps the first `count` of sixteen values, each in a pixel of its own.
    ///
    /// # Safety
    /// As [`store`](Self::store), for one channel of so many neighbouring pixels from `at` on.
    #[inline(always)]
    pub(in crate::blocked) unsafe fn scatter<V: Lanes>(&self, value: V, at: usize, count: usize) {
        // SAFETY: the caller's.
        unsafe {
            match self.kind {
                Kind::Whole => {
                    let to = self.pixels.cast::<f32>().add(at);
                    let values = value.array();
                    for (pixel, value) in values[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*value);
                    }
                }
                Kind::Half => {
                    let (to, mut halves) = (self.pixels.cast::<Bf16>().add(at), [Bf16(0); LANES]);
                    Bf16::store(value, halves.as_mut_ptr());
                    for (pixel, half) in halves[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*half);
                    }
                }
                Kind::Byte => {
                    let (to, mut bytes) = (self.pixels.add(at), [0; LANES]);
                    let [factor, term] = self.scale.map(|value| V::splat(value));
                    u8::store(value.mul_add(factor, term), bytes.as_mut_ptr());
                    for (pixel, byte) in bytes[..count].iter().enumerate() {
                        to.add(pixel * LANES).write(*byte);
                    }
                }
            }
        }
    }
}

/// Where bytes go, and what sums become on their way: the steps of the bytes go into the factors,
/// and activations into their ends.
#[derive(Clone, Copy)]
pub(super) struct ToBytes {
    pixels: *mut u8,
    factor: f32,
    zero: f32,
    low: f32,
    high: f32,
}

impl ToBytes {
    /// A factor and an offset that give values, such that they give bytes.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    pub(super) unsafe fn after<V: Lanes>(&self, factor: V, offset: V) -> [V; 2] {
        // SAFETY: the caller's.
        unsafe {
            let step = V::splat(self.factor);
            [factor.mul(step), offset.mul_add(step, V::splat(self.zero))]
        }
    }

    /// Keeps sixteen sums.
    ///
    /// # Safety
    /// As of [`To::store`].
    #[inline(always)]
    pub(super) unsafe fn store<V: Lanes>(&self, sum: V, [factor, offset]: [V; 2], at: usize) {
        // SAFETY: the caller's.
        unsafe {
            let value = sum.mul_add(factor, offset).max(V::splat(self.low));
            let value = value.min(V::splat(self.high));
            value.store_positive_bytes(self.pixels.add(at));
        }
    }
}
