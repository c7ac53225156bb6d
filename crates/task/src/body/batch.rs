//! Images that are inferred together.

use evpose_core::{Micros, Plane, SensorSize};
use glam::Vec2;

/// Images with their time stamps. Memory of removed images is reused.
#[derive(Debug, Default, Clone)]
pub struct ImageBatch {
    /// Those of `times`, then spare ones.
    images: Vec<Plane<u8>>,
    times: Vec<Micros>,
    extents: Vec<Option<[Vec2; 2]>>,
}

impl ImageBatch {
    /// Adds an image of `size` with the time stamp `t`, to be filled: its content is that of an
    /// earlier one. `extent` is that of the latest events, if it is known.
    pub fn add(
        &mut self,
        size: SensorSize,
        t: Micros,
        extent: Option<[Vec2; 2]>,
    ) -> &mut Plane<u8> {
        let index = self.times.len();
        self.times.push(t);
        self.extents.push(extent);
        if index == self.images.len() {
            self.images.push(Plane::for_sensor(size, 0));
        }
        &mut self.images[index]
    }

    /// Images of the batch, in the order in which they were added.
    pub fn images(&self) -> &[Plane<u8>] {
        &self.images[..self.times.len()]
    }

    /// Time stamps of the images.
    pub fn times(&self) -> &[Micros] {
        &self.times
    }

    /// Corners of the rectangle of the latest events of each image, relative to it.
    pub fn extents(&self) -> &[Option<[Vec2; 2]>] {
        &self.extents
    }

    /// Number of images.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no images.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Removes all images.
    pub fn clear(&mut self) {
        self.times.clear();
        self.extents.clear();
    }
}
