//! Skins of the HTML hand texture model, from the files of its makers.
//!
//! # Model
//! `texels = clip(mean + E·(S·c), 0, 255)` with 101 coefficients `c`: 1024 x 1024 texels, row by
//! row, red, green, blue.
//!
//! # Source
//! Qian, Wang, Mueller, Bernard, Golyanik, Theobalt: *HTML: A Parametric Hand Texture Model* (ECCV
//! 2020). Layout of the files as EventHands reads them: `f32`, little-endian, matrices column by
//! column.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use evpose_core::CounterRng;

use super::Texture;
use crate::SimError;

const TEXELS: usize = 1024;
/// Values of a texture: three channels per texel.
const VALUES: usize = 3 * TEXELS * TEXELS;
/// Coefficients of the published basis.
const COEFFICIENTS: usize = 101;
const MEAN: &str = "mean_data_vec.bin";
const BASIS: &str = "eigen_vector_matrix.bin";
const DEVIATIONS: &str = "std_dev_matrix.bin";

/// The basis: its mean and scale in memory, its 1.3 GB of vectors on disk.
#[derive(Debug, Clone)]
pub struct HtmlSkins {
    mean: Vec<f32>,
    /// Column by column.
    deviations: Vec<f32>,
    basis: PathBuf,
}

impl HtmlSkins {
    /// Opens the three files of a folder.
    ///
    /// # Errors
    /// If one is missing or has another size than the published one.
    pub fn open(folder: &Path) -> Result<Self, SimError> {
        let basis = folder.join(BASIS);
        check_size(&basis, VALUES * COEFFICIENTS)?;
        Ok(Self {
            mean: read(&folder.join(MEAN), VALUES)?,
            deviations: read(&folder.join(DEVIATIONS), COEFFICIENTS * COEFFICIENTS)?,
            basis,
        })
    }

    /// The skin of a person whose coefficients are drawn from N(0, `sd`²).
    ///
    /// # Errors
    /// If the basis can no longer be read.
    pub fn draw(&self, rng: &mut CounterRng, sd: f32) -> Result<Texture, SimError> {
        let coefficients: Vec<f32> = (0..COEFFICIENTS).map(|_| sd * rng.normal()).collect();
        let mut texels = self.mean.clone();
        let mut file = File::open(&self.basis).map_err(|error| fault(&self.basis, &error))?;
        let mut bytes = vec![0; 4 * VALUES];
        for row in 0..COEFFICIENTS {
            let scale: f32 = (0..COEFFICIENTS)
                .map(|column| self.deviations[column * COEFFICIENTS + row] * coefficients[column])
                .sum();
            file.read_exact(&mut bytes).map_err(|error| fault(&self.basis, &error))?;
            for (texel, value) in texels.iter_mut().zip(bytes.as_chunks::<4>().0) {
                *texel += scale * f32::from_le_bytes(*value);
            }
        }
        // A cast to `u8` stops at its ends and drops fractions, as published.
        let codes: Vec<u8> = texels.iter().map(|&texel| texel as u8).collect();
        Texture::from_rgb8(TEXELS, TEXELS, &codes)
            .ok_or_else(|| fault(&self.basis, &"a texture of another size"))
    }
}

fn fault(path: &Path, reason: &impl ToString) -> SimError {
    SimError::SkinFile { path: path.to_owned(), reason: reason.to_string() }
}

fn check_size(path: &Path, values: usize) -> Result<(), SimError> {
    let bytes = std::fs::metadata(path).map_err(|error| fault(path, &error))?.len();
    let expected = 4 * values as u64;
    if bytes == expected {
        return Ok(());
    }
    Err(fault(path, &format!("{bytes} bytes, but the published file has {expected}")))
}

fn read(path: &Path, values: usize) -> Result<Vec<f32>, SimError> {
    check_size(path, values)?;
    let bytes = std::fs::read(path).map_err(|error| fault(path, &error))?;
    Ok(bytes.as_chunks::<4>().0.iter().map(|value| f32::from_le_bytes(*value)).collect())
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, SeekFrom, Write};

    use glam::Vec2;

    use super::*;

    fn write(path: &Path, values: impl Iterator<Item = f32>) {
        let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        std::fs::write(path, bytes).unwrap();
    }

    /// A mean of 100, a last basis vector that moves the first texel's red alone, and a scale that
    /// takes the last coefficient from the first.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join(MEAN), (0..VALUES).map(|_| 100.0));
        let last = COEFFICIENTS * (COEFFICIENTS - 1);
        // Column 0, row 100.
        let scale =
            (0..last + COEFFICIENTS).map(|at| if at == COEFFICIENTS - 1 { 2.0 } else { 0.0 });
        write(&folder.path().join(DEVIATIONS), scale);
        // Zeros that take no room on the disk.
        let mut basis = File::create(folder.path().join(BASIS)).unwrap();
        basis.set_len(4 * (VALUES * COEFFICIENTS) as u64).unwrap();
        basis.seek(SeekFrom::Start(4 * (VALUES * (COEFFICIENTS - 1)) as u64)).unwrap();
        basis.write_all(&10f32.to_le_bytes()).unwrap();
        folder
    }

    #[test]
    fn a_skin_is_the_mean_moved_by_its_coefficients() {
        let folder = folder();
        let skins = HtmlSkins::open(folder.path()).unwrap();
        let skin = skins.draw(&mut CounterRng::new(1, "skin", 0), 2.0).unwrap();
        let first = 2.0 * CounterRng::new(1, "skin", 0).normal();
        let at = |x: f32, y: f32| skin.sample(Vec2::new(x + 0.5, y + 0.5) / TEXELS as f32) * 255.0;
        let moved = (100.0 + 10.0 * (2.0 * first)).clamp(0.0, 255.0).trunc();
        assert!((at(0.0, 0.0).x - moved).abs() < 1e-3, "{} {moved}", at(0.0, 0.0));
        assert!((at(0.0, 0.0).y - 100.0).abs() < 1e-3 && (at(7.0, 9.0).x - 100.0).abs() < 1e-3);
    }

    #[test]
    fn a_file_of_another_size_is_named() {
        let folder = folder();
        File::create(folder.path().join(MEAN)).unwrap();
        let message = HtmlSkins::open(folder.path()).unwrap_err().to_string();
        assert!(message.contains(MEAN) && message.contains("0 bytes"), "{message}");
    }
}
