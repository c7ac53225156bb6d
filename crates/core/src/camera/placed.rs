//! A calibrated camera at a place in the world.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{Distortion, LensCamera, LensError};

/// A camera whose lens and place are known, as triangulation needs it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CameraFields", into = "CameraFields")]
pub struct PlacedCamera {
    /// Focal lengths, principal point and distortion.
    pub lens: LensCamera,
    /// From the world to the camera, in metres; camera space is that of
    /// [`Pinhole`](super::Pinhole). Rigid, but for the skew of a camera that was read from a
    /// projection matrix.
    pub camera_from_world: DAffine3,
}

/// A camera in files: axes are OpenCV's, x right, y down, z forwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFields {
    /// Focal lengths in pixels.
    focal_px: [f64; 2],
    /// Principal point, in pixels from the corner of the image.
    principal_px: [f64; 2],
    /// Distortion, in the order of OpenCV.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    distortion: Vec<f64>,
    /// Whether it is that of a fisheye lens, `k1` to `k4`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    fisheye: bool,
    /// Rows of the matrix from the world, in metres, to the camera with OpenCV's axes.
    opencv_camera_from_world: [[f64; 4]; 3],
}

/// Between the axes of OpenCV and those of camera space, in both directions.
const FLIP: DMat3 = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
/// Smallest determinant of the axes of a matrix from the world to a camera.
const MIN_DETERMINANT: f64 = 1e-6;

impl PlacedCamera {
    /// A camera by the rows of its matrix from the world, in metres, to a camera with OpenCV's axes;
    /// none if the matrix mirrors, flattens or is not finite.
    pub fn from_opencv(lens: LensCamera, rows: [[f64; 4]; 3]) -> Option<Self> {
        let axes = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
        let origin = DVec3::from_array(rows.map(|[.., offset]| offset));
        let is_proper = axes.is_finite() && origin.is_finite();
        (is_proper && axes.determinant() > MIN_DETERMINANT).then(|| Self {
            lens,
            camera_from_world: DAffine3 { matrix3: FLIP * axes, translation: FLIP * origin },
        })
    }

    /// The rows of the matrix of [`Self::from_opencv`].
    pub fn opencv_rows(&self) -> [[f64; 4]; 3] {
        let axes = (FLIP * self.camera_from_world.matrix3).transpose();
        let origin = FLIP * self.camera_from_world.translation;
        [0, 1, 2].map(|row| {
            let [x, y, z] = axes.col(row).to_array();
            [x, y, z, origin[row]]
        })
    }

    /// A camera without distortion by its projection matrix, `(u d, v d, d) = P (x, y, z, 1)`, from
    /// metres to pixels from the corner of the image. What the matrix has of skew stays in
    /// [`Self::camera_from_world`], so that projections are those of the matrix. None if it is the
    /// matrix of no camera.
    ///
    /// # Source
    /// Hartley and Zisserman, *Multiple View Geometry*, 2nd edition, section 6.2.4: the matrix is
    /// divided into intrinsics and a place. Row products replace the RQ decomposition.
    pub fn from_projection(rows: [[f64; 4]; 3]) -> Option<Self> {
        let axis = |row: usize| DVec3::new(rows[row][0], rows[row][1], rows[row][2]);
        let length = axis(2).length();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let [a, b, c] = [axis(0) / length, axis(1) / length, axis(2) / length];
        // A matrix is only known up to its sign: depths are positive, so axes do not mirror.
        let sign = DMat3::from_cols(a, b, c).determinant().signum();
        let [a, b, c] = [sign * a, sign * b, sign * c];
        // The axes are orthogonal, so that the product with the third leaves the principal point.
        let principal_px = DVec2::new(a.dot(c), b.dot(c));
        let across = a - principal_px.x * c;
        let down = b - principal_px.y * c;
        let focal_px = DVec2::new(across.length(), down.length());
        let offset = [0, 1, 2].map(|row| sign * rows[row][3] / length);
        let [x, y] = [0, 1].map(|k| {
            let direction = [across, down][k] / focal_px[k];
            // The offset mixes focal length and principal point as the direction does.
            let shift = (offset[k] - principal_px[k] * offset[2]) / focal_px[k];
            [direction.x, direction.y, direction.z, shift]
        });
        let z = [c.x, c.y, c.z, offset[2]];
        let lens = LensCamera { focal_px, principal_px, distortion: Distortion::default() };
        Self::from_opencv(lens, [x, y, z])
    }

    /// Position on the image, in pixels, of a point in the world, in metres; none behind the camera.
    pub fn image_from_world(&self, point_m: DVec3) -> Option<DVec2> {
        self.lens.image_from_camera(self.camera_from_world.transform_point3(point_m))
    }
}

impl From<PlacedCamera> for CameraFields {
    fn from(camera: PlacedCamera) -> Self {
        let fisheye = camera.lens.distortion.fisheye;
        let mut distortion = camera.lens.distortion.to_opencv().to_vec();
        // Trailing zeros say nothing: most lenses have four or five coefficients.
        while distortion.last() == Some(&0.0) {
            distortion.pop();
        }
        // OpenCV has 4, 5, 8, 12 or 14 of them.
        let count = [0, 4, 5, 8, 12, 14].into_iter().find(|count| *count >= distortion.len());
        distortion.resize(count.unwrap_or(14), 0.0);
        distortion.extend(fisheye.into_iter().flatten());
        Self {
            focal_px: camera.lens.focal_px.into(),
            principal_px: camera.lens.principal_px.into(),
            distortion,
            fisheye: fisheye.is_some(),
            opencv_camera_from_world: camera.opencv_rows(),
        }
    }
}

/// Fields that are those of no camera.
#[derive(Debug, thiserror::Error)]
enum FieldFault {
    #[error("{}", .0.in_field(["focal_px", "principal_px", "distortion"]))]
    Lens(LensError),
    #[error("opencv_camera_from_world: no right-handed axes")]
    Axes,
}

impl TryFrom<CameraFields> for PlacedCamera {
    type Error = FieldFault;

    fn try_from(fields: CameraFields) -> Result<Self, FieldFault> {
        let CameraFields { focal_px, principal_px, distortion, .. } = &fields;
        let of_file =
            if fields.fisheye { LensCamera::fisheye_from_file } else { LensCamera::from_file };
        let lens = of_file(*focal_px, *principal_px, distortion).map_err(FieldFault::Lens)?;
        Self::from_opencv(lens, fields.opencv_camera_from_world).ok_or(FieldFault::Axes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LookAt, Pinhole, SensorSize};
    use glam::{DMat4, Vec3};

    fn camera() -> PlacedCamera {
        let sensor = SensorSize { width: 346, height: 260 };
        let pinhole = Pinhole::from_vertical_fov(sensor, 45.0);
        let placement = LookAt {
            eye_m: Vec3::new(2.0, 1.3, 2.5),
            centre_m: Vec3::new(0.1, 0.9, 0.0),
            up: Vec3::Y,
        };
        let lens = LensCamera {
            focal_px: DVec2::splat(pinhole.focal_px.into()),
            principal_px: pinhole.principal_px.as_dvec2(),
            distortion: Distortion::default(),
        };
        let world: DMat4 = placement.camera_from_world().as_dmat4();
        PlacedCamera { lens, camera_from_world: DAffine3::from_mat4(world) }
    }

    const POINTS: [DVec3; 3] =
        [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.4, 1.7, -0.2), DVec3::new(-0.3, 0.1, 0.5)];

    #[test]
    fn a_camera_in_a_file_is_read_back() {
        let mut camera = camera();
        camera.lens.distortion = Distortion::from_opencv(&[0.1, -0.05, 1e-3, 2e-3, 0.01]).unwrap();
        let text = serde_json::to_string(&camera).unwrap();
        let read: PlacedCamera = serde_json::from_str(&text).unwrap();
        assert_eq!(read.lens, camera.lens);
        for point in POINTS {
            let [a, b] = [camera, read].map(|camera| camera.image_from_world(point).unwrap());
            assert!((a - b).length() < 1e-9, "{a} {b}");
        }
        assert!(text.contains("\"opencv_camera_from_world\""), "{text}");
        let focal = format!("{:?}", camera.lens.focal_px.to_array()).replace(' ', "");
        let spoilt = text.replace(&focal, "[0.0,310.0]");
        let fault = serde_json::from_str::<PlacedCamera>(&spoilt).unwrap_err().to_string();
        assert!(fault.contains("focal_px") && spoilt != text, "{fault}");
        let [x, y, z] = camera.opencv_rows();
        assert_eq!(PlacedCamera::from_opencv(camera.lens, [y, x, z]), None, "it mirrors");
        assert_eq!(PlacedCamera::from_opencv(camera.lens, [x, y, y]), None, "it is flat");
        for column in 0..4 {
            let mut rows = [x, y, z];
            rows[1][column] = f64::NAN;
            assert_eq!(PlacedCamera::from_opencv(camera.lens, rows), None, "not finite");
        }
    }

    /// A skew of five pixels and a scale of the matrix, which says nothing.
    #[test]
    fn a_camera_of_a_projection_matrix_projects_as_the_matrix() {
        let camera = camera();
        let [x, y, z] = camera.opencv_rows();
        let lens = camera.lens;
        let mix = |k: usize| {
            let [u, v] = [
                lens.focal_px.x * x[k] + 5.0 * y[k] + lens.principal_px.x * z[k],
                lens.focal_px.y * y[k] + lens.principal_px.y * z[k],
            ];
            [u, v, z[k]]
        };
        for scale in [1.0, -3.0] {
            let columns = [0, 1, 2, 3].map(mix);
            let rows = [0, 1, 2].map(|row| columns.map(|column| scale * column[row]));
            let read = PlacedCamera::from_projection(rows).unwrap();
            for point in POINTS {
                let [u, v, d] = rows.map(|[a, b, c, e]| DVec3::new(a, b, c).dot(point) + e);
                let want = DVec2::new(u / d, v / d);
                let at = read.image_from_world(point).unwrap();
                assert!((at - want).length() < 1e-6, "{at} {want}");
            }
        }
        assert_eq!(PlacedCamera::from_projection([[0.0; 4]; 3]), None);
    }
}
