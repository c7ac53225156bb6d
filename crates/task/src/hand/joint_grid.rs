//! The cells of heatmaps, and the rays that they lie on.

use evpose_core::SensorSize;
use evpose_nn::JointNet;
use evpose_sim::raster::Camera;
use glam::{Vec2, Vec3};

/// The heatmaps of one image: of the whole view, or of a crop of it.
///
/// # Model
/// A cell covers [`JointNet::STRIDE`] pixels in both directions. Positions count cells from the middle of the
/// first one: x to the right, y down. The frame of a crop is that of its camera: x right, y up, looking
/// along -z; a ray is `(x, y) / -z` of its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointGrid {
    /// Columns and rows.
    pub cells: [usize; 2],
    focal_cells: f32,
    principal_cells: Vec2,
}

impl JointGrid {
    /// The grid of an image of `size`, of a crop of the view of `camera` that is magnified by `zoom`.
    pub fn new(camera: &Camera, size: SensorSize, zoom: f32) -> Self {
        let (pinhole, stride) = (camera.pinhole(), JointNet::STRIDE);
        let scale = f32::from(size.height) / f32::from(camera.sensor().height) / stride as f32;
        Self {
            cells: [usize::from(size.width) / stride, usize::from(size.height) / stride],
            focal_cells: zoom * scale * pinhole.focal_px,
            principal_cells: scale * pinhole.principal_px - 0.5,
        }
    }

    /// Cells to one unit of a ray.
    pub fn focal_cells(&self) -> f32 {
        self.focal_cells
    }

    /// The position of a point in the frame of the crop; none if it lies behind the camera.
    pub fn position(&self, point_m: Vec3) -> Option<Vec2> {
        let depth_m = -point_m.z;
        let ray = Vec2::new(point_m.x, -point_m.y) / depth_m;
        (depth_m > 0.0).then(|| self.principal_cells + self.focal_cells * ray)
    }

    /// The ray through a position.
    pub fn ray(&self, position: Vec2) -> Vec2 {
        let [x, y] = ((position - self.principal_cells) / self.focal_cells).to_array();
        Vec2::new(x, -y)
    }

    /// Whether a position lies in the image.
    pub fn contains(&self, position: Vec2) -> bool {
        let [columns, rows] = self.cells.map(|count| count as f32);
        let from_edge = position + 0.5;
        from_edge.cmpge(Vec2::ZERO).all() && from_edge.cmple(Vec2::new(columns, rows)).all()
    }
}

#[cfg(test)]
mod tests {
    use crate::hand::{HandConfig, PerspectiveCrop};

    use super::*;

    /// The pixel that a crop fills from a point of the view lies in the cell of the point.
    #[test]
    fn a_point_lies_in_the_cell_of_the_pixels_that_show_it() {
        let camera = HandConfig::default().simulation.camera();
        let (view, pinhole) = (camera.sensor(), camera.pinhole());
        let size = SensorSize { width: 128, height: 96 };
        let turn = glam::Mat3::from_rotation_z(0.7) * glam::Mat3::from_rotation_y(0.1);
        let crop = PerspectiveCrop::new(turn, 2.5);
        let grid = JointGrid::new(&camera, size, crop.zoom());
        assert_eq!(grid.cells, [32, 24]);
        for point_m in [Vec3::new(-0.06, 0.01, -0.5), Vec3::new(0.02, -0.05, -0.6)] {
            let [x, y] = pinhole.image_from_camera(point_m).unwrap().floor().to_array();
            let mut values = vec![0.0; 2 * view.pixels()];
            values[y as usize * usize::from(view.width) + x as usize] = 1.0;
            let mut image = vec![0.0; 2 * size.pixels()];
            crop.fill(&camera, &values, size, &mut image);
            let position = grid.position(turn * point_m).unwrap();
            let lit = (0..size.pixels()).filter(|&i| image[i] > 0.0).map(|i| {
                let (x, y) = (i % usize::from(size.width), i / usize::from(size.width));
                Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / JointNet::STRIDE as f32 - 0.5
            });
            let nearest = lit.map(|at| at.distance(position)).fold(f32::INFINITY, f32::min);
            assert!(nearest < 0.5, "{point_m}: {nearest} cells");
            assert!(grid.contains(position));
        }
    }

    #[test]
    fn rays_and_positions_are_inverse() {
        let camera = HandConfig::default().simulation.camera();
        let grid = JointGrid::new(&camera, SensorSize { width: 128, height: 96 }, 1.7);
        let point_m = Vec3::new(0.04, -0.02, -0.7);
        let ray = grid.ray(grid.position(point_m).unwrap());
        assert!(ray.distance(Vec2::new(0.04, -0.02) / 0.7) < 1e-6, "{ray}");
        assert!(grid.position(Vec3::Z).is_none());
        assert!(!grid.contains(Vec2::new(-0.6, 3.0)) && grid.contains(Vec2::new(31.4, 23.4)));
    }
}
