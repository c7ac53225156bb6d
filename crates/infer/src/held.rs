//! Images on their way, however they are kept.

use evpose_kernels::blocked::{Held, HeldMut, Image, Packed, Storage};

use crate::shapes::Shape;

/// How the values of a node are kept: in 32 bits, or in fewer.
pub(crate) type Kept = Option<Storage>;

/// An image that is kept in one of the ways there are.
#[derive(Debug, Clone)]
pub(crate) enum Buffer {
    Whole(Image),
    Packed(Packed),
}

impl Buffer {
    pub(crate) fn zeros(shape: Shape, border: usize, kept: Kept) -> Self {
        let [channels, height, width] = shape;
        match kept {
            None => Self::Whole(Image::zeros(channels, height, width, border)),
            Some(storage) => Self::Packed(Packed::zeros(shape, border, storage)),
        }
    }

    pub(crate) fn held(&self) -> Held<'_> {
        match self {
            Self::Whole(image) => Held::Whole(image),
            Self::Packed(image) => Held::Packed(image),
        }
    }

    pub(crate) fn held_mut(&mut self) -> HeldMut<'_> {
        match self {
            Self::Whole(image) => HeldMut::Whole(image),
            Self::Packed(image) => HeldMut::Packed(image),
        }
    }

    /// In 32 bits.
    ///
    /// # Panics
    /// If it is kept otherwise: plans see to it that steps get what they take.
    pub(crate) fn whole(&self) -> &Image {
        match self {
            Self::Whole(image) => image,
            Self::Packed(_) => panic!("an image of 32 bits"),
        }
    }

    /// As [`whole`](Self::whole), to write.
    pub(crate) fn whole_mut(&mut self) -> &mut Image {
        match self {
            Self::Whole(image) => image,
            Self::Packed(_) => panic!("an image of 32 bits"),
        }
    }

    /// In fewer bits.
    ///
    /// # Panics
    /// If it is kept otherwise: plans see to it that steps get what they take.
    pub(crate) fn packed(&self) -> &Packed {
        match self {
            Self::Packed(image) => image,
            Self::Whole(_) => panic!("an image of fewer bits"),
        }
    }

    /// As [`packed`](Self::packed), to write.
    pub(crate) fn packed_mut(&mut self) -> &mut Packed {
        match self {
            Self::Packed(image) => image,
            Self::Whole(_) => panic!("an image of fewer bits"),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Whole(image) => image.bytes(),
            Self::Packed(image) => image.bytes(),
        }
    }
}
