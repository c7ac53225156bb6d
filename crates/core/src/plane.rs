//! Dense images of one value per pixel.

use crate::{CoreError, SensorSize};

/// A dense image: `height` rows of `width` values, row-major from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T: Clone> Plane<T> {
    /// A plane in which every pixel is `value`.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// A plane the size of `sensor`.
    pub fn for_sensor(sensor: SensorSize, value: T) -> Self {
        Self::filled(usize::from(sensor.width), usize::from(sensor.height), value)
    }
}

impl<T> Plane<T> {
    /// Takes `data`, row by row.
    ///
    /// # Errors
    /// If its length is not `width * height`.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Result<Self, CoreError> {
        if data.len() != width * height {
            return Err(CoreError::PlaneSize { width, height, got: data.len() });
        }
        Ok(Self { width, height, data })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The values, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// The values, row by row, to write.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Row `y`.
    ///
    /// # Panics
    /// Outside the plane.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// Row `y`, to write.
    ///
    /// # Panics
    /// Outside the plane.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }

    /// The value at column `x`, row `y`.
    ///
    /// # Panics
    /// Outside the plane.
    pub fn at(&self, x: usize, y: usize) -> &T {
        assert!(x < self.width, "column {x} of a plane {} wide", self.width);
        &self.data[y * self.width + x]
    }

    /// The value at column `x`, row `y`, to write.
    ///
    /// # Panics
    /// Outside the plane.
    pub fn at_mut(&mut self, x: usize, y: usize) -> &mut T {
        assert!(x < self.width, "column {x} of a plane {} wide", self.width);
        &mut self.data[y * self.width + x]
    }
}
