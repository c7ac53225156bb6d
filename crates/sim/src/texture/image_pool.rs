//! The pool of images from which episodes draw their backgrounds.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::Texture;
use super::background::paint_background;
use crate::SimError;
use crate::config::BackgroundSource;

/// Lower-case extensions of image files.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// Background images shared by all sequences of a run; procedural ones are painted at first use.
#[derive(Debug)]
pub struct ImagePool {
    seed: u64,
    images: Vec<OnceLock<Texture>>,
}

impl ImagePool {
    /// Reads the folder, or prepares to paint from `seed`.
    ///
    /// # Errors
    /// A folder or image that cannot be read, or a folder without images.
    pub fn new(source: &BackgroundSource, seed: u64) -> Result<Self, SimError> {
        let images = match source {
            BackgroundSource::Procedural(count) => vec![OnceLock::new(); *count],
            BackgroundSource::Folder(path) => {
                let read = image_files(path)?.into_iter().map(|path| read(&path));
                read.map(|texture| texture.map(OnceLock::from)).collect::<Result<_, _>>()?
            }
        };
        Ok(Self { seed, images })
    }

    /// Number of images; at least one in a valid configuration.
    pub fn len(&self) -> usize {
        self.images.len()
    }

    /// Whether the pool is empty.
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// Image `index`.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn image(&self, index: usize) -> &Texture {
        self.images[index].get_or_init(|| paint_background(self.seed, index))
    }
}

fn image_files(folder: &Path) -> Result<Vec<PathBuf>, SimError> {
    let unreadable = |source| SimError::Folder { path: folder.to_owned(), source };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if ending.is_some_and(|e| ENDINGS.contains(&e.as_str())) {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(SimError::NoImages { path: folder.to_owned() });
    }
    // Operating systems list files in any order; draws are by index.
    paths.sort();
    Ok(paths)
}

fn read(path: &Path) -> Result<Texture, SimError> {
    let pixels = image::open(path)
        .map_err(|source| SimError::Image { path: path.to_owned(), source })?
        .into_rgb8();
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let empty = || SimError::NoImages { path: path.to_owned() };
    Texture::from_rgb8(width, height, pixels.as_raw()).ok_or_else(empty)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    #[test]
    fn a_folder_gives_its_images_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let missing = ImagePool::new(&BackgroundSource::Folder(folder.path().join("no")), 0);
        assert!(matches!(missing, Err(SimError::Folder { .. })));
        let source = BackgroundSource::Folder(folder.path().to_owned());
        assert!(matches!(ImagePool::new(&source, 0), Err(SimError::NoImages { .. })));
        for (name, level) in [("b.png", 255), ("a.PNG", 0)] {
            let pixels = image::RgbImage::from_pixel(2, 3, image::Rgb([level; 3]));
            pixels.save(folder.path().join(name)).unwrap();
        }
        std::fs::write(folder.path().join("notes.txt"), "not an image").unwrap();
        let pool = ImagePool::new(&source, 0).unwrap();
        assert_eq!(pool.len(), 2);
        assert_eq!(pool.image(0).sample(Vec2::ZERO).x, 0.0);
        assert_eq!(pool.image(1).sample(Vec2::ZERO).x, 1.0);
        std::fs::write(folder.path().join("c.png"), "not an image either").unwrap();
        let error = ImagePool::new(&source, 0).unwrap_err().to_string();
        assert!(error.contains("c.png"), "{error}");
    }
}
