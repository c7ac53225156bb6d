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

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
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

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 4;
    const HEIGHT: usize = 3;

    /// A way to the value of a column and a row.
    type Access = fn(&mut Plane<usize>, usize, usize) -> &mut usize;

    /// Each value is its place in memory.
    fn numbered() -> Plane<usize> {
        Plane::from_vec(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).collect()).unwrap()
    }

    #[test]
    fn values_rows_and_memory_are_the_same_pixels_read_or_written() {
        for (y, x) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (y, x))) {
            let place = y * WIDTH + x;
            let mut plane = numbered();
            assert_eq!((*plane.at(x, y), plane.row(y)[x]), (place, place));
            let writes: [Access; 3] = [
                |plane, x, y| plane.at_mut(x, y),
                |plane, x, y| &mut plane.row_mut(y)[x],
                |plane, x, y| &mut plane.data_mut()[y * WIDTH + x],
            ];
            for write in writes {
                plane = numbered();
                *write(&mut plane, x, y) = 99;
                let is_written =
                    |(i, value): (usize, &usize)| *value == if i == place { 99 } else { i };
                assert!(plane.data().iter().enumerate().all(is_written), "({x}, {y})");
            }
        }
        assert!((0..HEIGHT).all(|y| numbered().row(y).len() == WIDTH));
        assert!((0..HEIGHT).all(|y| numbered().row_mut(y).len() == WIDTH));
    }

    #[test]
    fn a_plane_has_the_size_of_its_sensor_and_no_other_number_of_values() {
        let plane = Plane::for_sensor(SensorSize { width: 5, height: 2 }, 7u8);
        assert_eq!((plane.width(), plane.height(), plane.data()), (5, 2, &[7; 10][..]));
        for got in [0, 9, 11] {
            let error = Plane::from_vec(5, 2, vec![0u8; got]);
            assert_eq!(error, Err(CoreError::PlaneSize { width: 5, height: 2, got }));
        }
    }

    #[test]
    #[should_panic(expected = "column 4 of a plane 4 wide")]
    fn a_column_beyond_the_plane_is_not_the_next_row() {
        numbered().at(WIDTH, 0);
    }

    #[test]
    #[should_panic(expected = "column 4 of a plane 4 wide")]
    fn a_column_beyond_the_plane_is_not_written_to_the_next_row() {
        *numbered().at_mut(WIDTH, 0) = 0;
    }
}
