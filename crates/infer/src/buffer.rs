//! Buffers of the values of a plan, in any storage type.

use evpose_kernels::blocked::{
    Image, LowPrecisionImage, LowPrecisionType, NchwImage, TensorView, TensorViewMut,
};

use crate::shapes::Shape;

/// Element type in which a value is stored between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StorageType {
    F32,
    /// bf16 or quantised uint8.
    LowPrecision(LowPrecisionType),
}

impl StorageType {
    pub(crate) fn is_f32(self) -> bool {
        self == Self::F32
    }

    /// Whether a buffer of one type can be reused for a value of the other.
    pub(crate) fn is_compatible_with(self, other: Self) -> bool {
        match (self, other) {
            (Self::F32, Self::F32) => true,
            (Self::LowPrecision(one), Self::LowPrecision(other)) => one.is_compatible_with(other),
            _ => false,
        }
    }
}

/// An image in one of the storage types and layouts.
#[derive(Debug, Clone)]
pub(crate) enum Buffer {
    F32(Image),
    LowPrecision(LowPrecisionImage),
    /// The input of the network in nchw, in f32.
    Nchw(NchwImage),
}

/// Accessors by kind. They panic on another kind: the planner gives every step buffers of the kind
/// it takes.
impl Buffer {
    pub(crate) fn zeros(shape: Shape, border: usize, storage: StorageType) -> Self {
        let [channels, height, width] = shape;
        match storage {
            StorageType::F32 => Self::F32(Image::zeros(channels, height, width, border)),
            StorageType::LowPrecision(element_type) => {
                Self::LowPrecision(LowPrecisionImage::zeros(shape, border, element_type))
            }
        }
    }

    /// View of an image in nChw16c.
    pub(crate) fn view(&self) -> TensorView<'_> {
        match self {
            Self::F32(image) => TensorView::F32(image),
            Self::LowPrecision(image) => TensorView::LowPrecision(image),
            Self::Nchw(_) => panic!("an image in nChw16c"),
        }
    }

    pub(crate) fn view_mut(&mut self) -> TensorViewMut<'_> {
        match self {
            Self::F32(image) => TensorViewMut::F32(image),
            Self::LowPrecision(image) => TensorViewMut::LowPrecision(image),
            Self::Nchw(_) => panic!("an image in nChw16c"),
        }
    }

    /// The f32 image.
    pub(crate) fn f32(&self) -> &Image {
        match self {
            Self::F32(image) => image,
            _ => panic!("an f32 image"),
        }
    }

    pub(crate) fn f32_mut(&mut self) -> &mut Image {
        match self {
            Self::F32(image) => image,
            _ => panic!("an f32 image"),
        }
    }

    /// The image of low precision.
    pub(crate) fn low_precision(&self) -> &LowPrecisionImage {
        match self {
            Self::LowPrecision(image) => image,
            _ => panic!("an image of low precision"),
        }
    }

    pub(crate) fn low_precision_mut(&mut self) -> &mut LowPrecisionImage {
        match self {
            Self::LowPrecision(image) => image,
            _ => panic!("an image of low precision"),
        }
    }

    /// The image in nchw.
    pub(crate) fn nchw(&self) -> &NchwImage {
        match self {
            Self::Nchw(image) => image,
            _ => panic!("an image in nchw"),
        }
    }

    /// Minimum and maximum of an f32 image.
    pub(crate) fn min_max(&self) -> [f32; 2] {
        match self {
            Self::Nchw(image) => image.min_max(),
            _ => self.f32().min_max(),
        }
    }
}
