//! A folder of images, one frame each.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use evpose_core::SensorSize;
use image::{DynamicImage, ImageFormat, ImageReader};

use super::fault::sensor_size;
use super::light::Light;
use super::{About, FrameDepth, FrameFault, Frames, Opened, natural};
use crate::IoError;

/// Endings of images that are frames elsewhere, but are not read here.
const OTHERS: [&str; 12] =
    ["bmp", "tif", "tiff", "webp", "exr", "hdr", "pgm", "ppm", "pnm", "avif", "heic", "jp2"];

/// The images of a folder that are still to come.
struct Folder {
    images: Vec<PathBuf>,
    next: usize,
    size: SensorSize,
    depth: FrameDepth,
}

pub(super) fn open(path: &Path) -> Result<Opened, IoError> {
    let failed = |e| IoError::file(path, "list", e);
    let (mut images, mut unread, mut hidden) = (Vec::new(), Vec::new(), Vec::new());
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let image = entry.map_err(failed)?.path();
        // Systems leave files of their own in folders, whose names begin with a dot.
        let name = image.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with('.') {
            // What macOS puts beside a file has its name and ending behind these two.
            if image_format(&image).is_some() && !name.starts_with("._") {
                hidden.push(name.into_owned());
            }
            continue;
        }
        if image_format(&image).is_some() {
            images.push(image);
        } else if is_other_image(&image) {
            unread.push(image);
        }
    }
    // Half of a sequence would be taken for all of it.
    if let Some(first) = unread.iter().min() {
        let first = first.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let fault = FrameFault::OtherImages { count: unread.len(), first };
        return Err(IoError::frames(path, fault));
    }
    let is_png = |image: &PathBuf| image_format(image) == Some(ImageFormat::Png);
    let (lossless, others): (Vec<_>, Vec<_>) = images.iter().cloned().partition(is_png);
    // A JPEG image beside every lossless frame is its preview.
    let stem = |image: &PathBuf| {
        image.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default()
    };
    let stems: HashSet<String> = lossless.iter().map(stem).collect();
    let is_preview = |image: &PathBuf| stems.contains(&stem(image));
    if !lossless.is_empty() {
        if !others.iter().all(is_preview) {
            let fault = FrameFault::Mixed { png: lossless.len(), jpg: others.len() };
            return Err(IoError::frames(path, fault));
        }
        images = lossless;
    }
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
    images.sort_by(|a, b| {
        natural::compare(&name(a).unwrap_or_default(), &name(b).unwrap_or_default())
    });
    let Some(first) = images.first() else {
        return Err(IoError::frames(path, FrameFault::NoImages));
    };
    // The first image gives size and depth, which all must have.
    let image = decode(first)?;
    let (size, depth) = properties(&image).map_err(|fault| IoError::frames(first, fault))?;
    let mut about = About::new(size, depth, images.len() as u64);
    about.note = hidden.iter().min().map(|first| {
        let (folder, count) = (path.display(), hidden.len());
        format!("{folder}: hidden images are left out, {count} in all, such as {first}")
    });
    Ok((Box::new(Folder { images, next: 0, size, depth }), about))
}

impl Frames for Folder {
    fn next_into(&mut self, _: &Path, light: &Light, out: &mut [f32]) -> Result<bool, IoError> {
        let Some(path) = self.images.get(self.next) else { return Ok(false) };
        let image = decode(path)?;
        let fault = match properties(&image) {
            Ok((got, _)) if got != self.size => FrameFault::Size { got, first: self.size },
            Ok((_, got)) if got != self.depth => FrameFault::Depth { got, first: self.depth },
            Ok(_) => {
                // Only now: after a fault, the next call reports the same image again.
                convert(&image, light, out);
                self.next += 1;
                return Ok(true);
            }
            Err(fault) => fault,
        };
        Err(IoError::frames(path, fault))
    }
}

/// Image format by the extension, if it is one of those that are read.
fn image_format(path: &Path) -> Option<ImageFormat> {
    let ending = path.extension()?;
    let is = |known: &str| ending.eq_ignore_ascii_case(known);
    if is("png") {
        return Some(ImageFormat::Png);
    }
    (is("jpg") || is("jpeg")).then_some(ImageFormat::Jpeg)
}

fn is_other_image(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default();
    OTHERS.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

fn decode(path: &Path) -> Result<DynamicImage, IoError> {
    let mut reader = ImageReader::open(path).map_err(|e| IoError::file(path, "open", e))?;
    reader.set_format(image_format(path).unwrap_or(ImageFormat::Png));
    let undecodable = |e: image::ImageError| FrameFault::Undecodable(e.to_string());
    reader.decode().map_err(|e| IoError::frames(path, undecodable(e)))
}

fn properties(image: &DynamicImage) -> Result<(SensorSize, FrameDepth), FrameFault> {
    let size = sensor_size(image.width().into(), image.height().into())?;
    let depth = match image {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => FrameDepth::Eight,
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => FrameDepth::Sixteen,
        other => return Err(FrameFault::Pixels(format!("{:?}", other.color()))),
    };
    Ok((size, depth))
}

/// Light of all pixels; `properties` has let no other images pass.
fn convert(image: &DynamicImage, light: &Light, out: &mut [f32]) {
    match image {
        DynamicImage::ImageLuma8(i) => grey::<_, 1>(i, light, out),
        DynamicImage::ImageLumaA8(i) => grey::<_, 2>(i, light, out),
        DynamicImage::ImageRgb8(i) => colour::<_, 3>(i, light, out),
        DynamicImage::ImageRgba8(i) => colour::<_, 4>(i, light, out),
        DynamicImage::ImageLuma16(i) => grey::<_, 1>(i, light, out),
        DynamicImage::ImageLumaA16(i) => grey::<_, 2>(i, light, out),
        DynamicImage::ImageRgb16(i) => colour::<_, 3>(i, light, out),
        DynamicImage::ImageRgba16(i) => colour::<_, 4>(i, light, out),
        _ => {}
    }
}

fn grey<T: Copy + Into<usize>, const N: usize>(codes: &[T], light: &Light, out: &mut [f32]) {
    for (y, pixel) in out.iter_mut().zip(codes.as_chunks::<N>().0) {
        *y = light.code_to_light(pixel[0]);
    }
}

/// Light of pixels of red, green, blue and, for `N` of 4, what else.
pub(super) fn colour<T: Copy + Into<usize>, const N: usize>(
    codes: &[T],
    light: &Light,
    out: &mut [f32],
) {
    for (y, pixel) in out.iter_mut().zip(codes.as_chunks::<N>().0) {
        *y = light.rgb_to_light([pixel[0], pixel[1], pixel[2]]);
    }
}
