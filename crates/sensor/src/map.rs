//! One number per pixel, from an `.npy` file of shape (height, width).

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use evpose_core::SensorSize;
use npyz::{NpyFile, Order};

/// One value per pixel, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PixelMap {
    pub(crate) size: SensorSize,
    pub(crate) values: Vec<f32>,
}

/// Why a file is no map of pixels.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MapFault {
    /// It cannot be read, or is no `.npy` file, or is shorter than its shape says.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// Its shape is not (height, width) of a sensor.
    #[error("of shape {0:?}, expected (height, width)")]
    Shape(Vec<u64>),
    /// Its values are of another type than `f4` or `f8`, or stored column by column.
    #[error("of type {0}, expected f4 or f8, row by row")]
    Type(String),
    /// The value at this column and row is out of range.
    #[error("the value of pixel ({0}, {1}) is out of range")]
    Value(u16, u16),
    /// Its size is not that of the effect's other maps.
    #[error("is for a {0} sensor, unlike the maps before it")]
    OtherSize(SensorSize),
}

impl PixelMap {
    /// Reads a map whose values are all at least `least`.
    pub(crate) fn read(path: &Path, least: f32) -> Result<Self, MapFault> {
        let unreadable = |e: io::Error| MapFault::Unreadable(e.to_string());
        let file = BufReader::new(File::open(path).map_err(unreadable)?);
        let npy = NpyFile::new(file).map_err(unreadable)?;
        // A side of no pixels is refused as well as one that is too long.
        let side = |n: u64| u16::try_from(n).ok().filter(|&n| n > 0);
        let size = match npy.shape() {
            &[height, width] => side(width).zip(side(height)),
            _ => None,
        };
        let Some((width, height)) = size else {
            return Err(MapFault::Shape(npy.shape().to_vec()));
        };
        // Values in columns would be a transposed map.
        if npy.order() != Order::C {
            return Err(MapFault::Type(format!("{} in columns", npy.dtype().descr())));
        }
        // NumPy writes double precision unless asked otherwise: both are read.
        let values: io::Result<Vec<f32>> = match npy.try_data::<f32>() {
            Ok(values) => values.collect(),
            Err(npy) => match npy.try_data::<f64>() {
                Ok(values) => values.map(|value| value.map(|v| v as f32)).collect(),
                Err(npy) => return Err(MapFault::Type(npy.dtype().descr())),
            },
        };
        let values = values.map_err(unreadable)?;
        let is_allowed = |v: &f32| v.is_finite() && *v >= least;
        if let Some(faulty) = values.iter().position(|v| !is_allowed(v)) {
            let columns = usize::from(width);
            return Err(MapFault::Value((faulty % columns) as u16, (faulty / columns) as u16));
        }
        Ok(Self { size: SensorSize { width, height }, values })
    }
}
