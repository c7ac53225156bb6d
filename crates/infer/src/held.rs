//! Images on their way, however they are kept.

use evpose_kernels::blocked::{Held, HeldMut, Image, Packed, Planes, Storage};

use crate::shapes::Shape;

/// How the values of a node are kept: in 32 bits, or in fewer.
pub(crate) type Kept = Option<Storage>;

/// An image that is kept in one of the ways there are.
#[derive(Debug, Clone)]
pub(crate) enum Buffer {
    Whole(Image),
    Packed(Packed),
    /// What the world brings.
    Planes(Planes),
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
            Self::Planes(_) => panic!("an image in blocks of channels"),
        }
    }

    pub(crate) fn held_mut(&mut self) -> HeldMut<'_> {
        match self {
            Self::Whole(image) => HeldMut::Whole(image),
            Self::Packed(image) => HeldMut::Packed(image),
            Self::Planes(_) => panic!("an image in blocks of channels"),
        }
    }

    /// In 32 bits.
    ///
    /// # Panics
    /// If it is kept otherwise: plans see to it that steps get what they take.
    pub(crate) fn whole(&self) -> &Image {
        match self {
            Self::Whole(image) => image,
            _ => panic!("an image of 32 bits"),
        }
    }

    /// As [`whole`](Self::whole), to write.
    pub(crate) fn whole_mut(&mut self) -> &mut Image {
        match self {
            Self::Whole(image) => image,
            _ => panic!("an image of 32 bits"),
        }
    }

    /// In fewer bits.
    ///
    /// # Panics
    /// If it is kept otherwise: plans see to it that steps get what they take.
    pub(crate) fn packed(&self) -> &Packed {
        match self {
            Self::Packed(image) => image,
            _ => panic!("an image of fewer bits"),
        }
    }

    /// As [`packed`](Self::packed), to write.
    pub(crate) fn packed_mut(&mut self) -> &mut Packed {
        match self {
            Self::Packed(image) => image,
            _ => panic!("an image of fewer bits"),
        }
    }

    /// In planes.
    ///
    /// # Panics
    /// If it is kept otherwise: plans see to it that steps get what they take.
    pub(crate) fn planes(&self) -> &Planes {
        match self {
            Self::Planes(planes) => planes,
            _ => panic!("an image in planes"),
        }
    }

    /// The least and the largest value.
    ///
    /// # Panics
    /// If it is kept in fewer bits.
    pub(crate) fn extremes(&self) -> [f32; 2] {
        match self {
            Self::Planes(planes) => planes.extremes(),
            _ => self.whole().extremes(),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Whole(image) => image.bytes(),
            Self::Packed(image) => image.bytes(),
            Self::Planes(planes) => planes.bytes(),
        }
    }
}
