//! PNG files in memory.

use image::{ExtendedColorType, ImageEncoder as _, ImageError, RgbImage};

/// Encodes an image as a PNG file.
///
/// # Errors
/// If the encoder fails.
pub fn png(image: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        image,
        image.width(),
        image.height(),
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}
