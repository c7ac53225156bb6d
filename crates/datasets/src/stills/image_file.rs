//! Photographs in, images of persons out.

use std::path::Path;

use evpose_core::{Plane, atomic_write};
use evpose_repr::{ColourOrder, grey_from_colour};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError, ImageReader};

use super::CropFormat;
use crate::DatasetError;

/// Reads a photograph in grey.
pub(super) fn read_grey(path: &Path) -> Result<Plane<u8>, ImageError> {
    let image = ImageReader::open(path)?.with_guessed_format()?.decode()?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let data = match image {
        DynamicImage::ImageLuma8(grey) => grey.into_raw(),
        colour => {
            let mut grey = vec![0; width * height];
            grey_from_colour(colour.to_rgb8().as_raw(), ColourOrder::Rgb, &mut grey);
            grey
        }
    };
    Plane::from_vec(width, height, data)
        .map_err(|error| ImageError::IoError(std::io::Error::other(error)))
}

/// Width and height of a photograph, without reading all of it.
pub(super) fn size(path: &Path) -> Result<[usize; 2], ImageError> {
    let (width, height) = ImageReader::open(path)?.with_guessed_format()?.into_dimensions()?;
    Ok([width as usize, height as usize])
}

/// Writes an image; it appears when it is complete.
pub(crate) fn write(
    path: &Path,
    image: &Plane<u8>,
    format: CropFormat,
) -> Result<(), DatasetError> {
    let mut bytes = Vec::new();
    let (width, height) = (image.width() as u32, image.height() as u32);
    let encoded = match format {
        CropFormat::Png => PngEncoder::new(&mut bytes).write_image(
            image.data(),
            width,
            height,
            ExtendedColorType::L8,
        ),
        CropFormat::Jpeg { quality } => JpegEncoder::new_with_quality(&mut bytes, quality)
            .write_image(image.data(), width, height, ExtendedColorType::L8),
    };
    encoded.map_err(|error| DatasetError::io(path, "write it")(std::io::Error::other(error)))?;
    atomic_write(path, &bytes).map_err(DatasetError::io(path, "write it"))
}
