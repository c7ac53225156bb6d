//! The pictures from which episodes take their backgrounds.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::Texture;
use super::background::paint_background;
use crate::SimError;
use crate::config::BackgroundSource;

/// Endings of the files that are taken from a folder, in small letters.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// Pictures shared by all sequences of a run; made-up ones are painted when first used.
#[derive(Debug)]
pub struct PicturePool {
    seed: u64,
    pictures: Vec<OnceLock<Texture>>,
}

impl PicturePool {
    /// Reads the folder, or prepares to paint from `seed`.
    ///
    /// # Errors
    /// A folder or picture that cannot be read, or no picture at all.
    pub fn new(source: &BackgroundSource, seed: u64) -> Result<Self, SimError> {
        let pictures = match source {
            BackgroundSource::Procedural(count) => vec![OnceLock::new(); *count],
            BackgroundSource::Folder(path) => {
                let read = pictures_in(path)?.into_iter().map(|picture| read(&picture));
                read.map(|texture| texture.map(OnceLock::from)).collect::<Result<_, _>>()?
            }
        };
        Ok(Self { seed, pictures })
    }

    /// How many there are; at least one in a valid configuration.
    pub fn len(&self) -> usize {
        self.pictures.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pictures.is_empty()
    }

    /// Picture number `index`.
    ///
    /// # Panics
    /// If there are not that many.
    pub fn picture(&self, index: usize) -> &Texture {
        self.pictures[index].get_or_init(|| paint_background(self.seed, index))
    }
}

/// The pictures of a folder, by name.
fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, SimError> {
    let unreadable = |source| SimError::Folder { path: folder.to_owned(), source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if ending.is_some_and(|e| ENDINGS.contains(&e.as_str())) {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(SimError::NoPictures { path: folder.to_owned() });
    }
    found.sort();
    Ok(found)
}

fn read(path: &Path) -> Result<Texture, SimError> {
    let picture = image::open(path)
        .map_err(|source| SimError::Picture { path: path.to_owned(), source })?
        .into_rgb8();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let empty = || SimError::NoPictures { path: path.to_owned() };
    Texture::from_rgb8(width, height, picture.as_raw()).ok_or_else(empty)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use glam::Vec2;

    use super::*;

    #[test]
    fn a_folder_gives_its_pictures_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let missing = PicturePool::new(&BackgroundSource::Folder(folder.path().join("no")), 0);
        assert!(matches!(missing, Err(SimError::Folder { .. })));
        let source = BackgroundSource::Folder(folder.path().to_owned());
        assert!(matches!(PicturePool::new(&source, 0), Err(SimError::NoPictures { .. })));
        for (name, level) in [("b.png", 255), ("a.PNG", 0)] {
            let picture = image::RgbImage::from_pixel(2, 3, image::Rgb([level; 3]));
            picture.save(folder.path().join(name)).unwrap();
        }
        std::fs::write(folder.path().join("notes.txt"), "not a picture").unwrap();
        let pool = PicturePool::new(&source, 0).unwrap();
        assert_eq!(pool.len(), 2);
        assert_eq!(pool.picture(0).sample(Vec2::ZERO).x, 0.0);
        assert_eq!(pool.picture(1).sample(Vec2::ZERO).x, 1.0);
        std::fs::write(folder.path().join("c.png"), "not a picture either").unwrap();
        let error = PicturePool::new(&source, 0).unwrap_err().to_string();
        assert!(error.contains("c.png"), "{error}");
    }
}
