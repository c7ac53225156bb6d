//! Lens distortion: OpenCV's rational model, and its fisheye model.
//!
//! # Model
//! A direction `(x, y)` is a ray in normalised image coordinates, its intersection with the plane
//! at distance one: x right, y down. With `r² = x² + y²` and `f = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1
//! + k4 r² + k5 r⁴ + k6 r⁶)`,
//!
//! ```text
//! x' = x f + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴
//! y' = y f + p1 (r² + 2 y²) + 2 p2 x y + s3 r² + s4 r⁴
//! ```
//!
//! and a sensor that is tilted by `tx` and `ty` projects `(x', y')` onto its own plane: `P R (x',
//! y', 1)`, with `R = Ry(ty) Rx(tx)` and `P` the projection back along the axis. With `k4` to `k6`,
//! `s` and the tilt zero it is Brown and Conrady's model.
//!
//! # Inverse
//! It has no closed form. As OpenCV's `undistortPoints`, a fixed-point iteration divides the
//! distorted direction by the distortion at the current estimate. The residual is returned in
//! pixels, by distorting the result.
//!
//! # Source
//! Brown, *Decentering distortion of lenses*, 1966; OpenCV's manual, "Camera Calibration and 3D
//! Reconstruction", for the order and the meaning of the coefficients.

mod fisheye;

use glam::{DMat3, DVec2, DVec3};

/// Length of a step, at distance one, below which the iteration has converged: a millionth of a
/// pixel at a focal length of 10,000.
const MIN_STEP: f64 = 1e-10;

/// Coefficients of lens distortion, see the module.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// Radial: `k1` to `k3` of the numerator, `k4` to `k6` of the denominator.
    pub radial: [f64; 6],
    /// Tangential: `p1`, `p2`.
    pub tangential: [f64; 2],
    /// Thin prism: `s1` to `s4`.
    pub prism: [f64; 4],
    /// Tilt of the sensor about x and y.
    pub tilt_rad: [f64; 2],
    /// `k1` to `k4` of a fisheye lens, which has none of the others.
    pub fisheye: Option<[f64; 4]>,
}

impl Distortion {
    /// Coefficients in OpenCV's order, `k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty`, of which there
    /// are 0, 4, 5, 8, 12 or 14; none for any other number.
    pub fn from_opencv(coefficients: &[f64]) -> Option<Self> {
        if ![0, 4, 5, 8, 12, 14].contains(&coefficients.len()) {
            return None;
        }
        let c = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        Some(Self {
            radial: [c(0), c(1), c(4), c(5), c(6), c(7)],
            tangential: [c(2), c(3)],
            prism: [c(8), c(9), c(10), c(11)],
            tilt_rad: [c(12), c(13)],
            fisheye: None,
        })
    }

    /// A fisheye lens by the coefficients `k1` to `k4` of Kannala and Brandt's equidistant model, as
    /// OpenCV's `fisheye`, kalibr and ROS have them.
    pub fn fisheye(coefficients: [f64; 4]) -> Self {
        Self { fisheye: Some(coefficients), ..Self::default() }
    }

    /// All fourteen coefficients in OpenCV's order, without those of a fisheye lens.
    pub fn to_opencv(&self) -> [f64; 14] {
        let ([k1, k2, k3, k4, k5, k6], [p1, p2]) = (self.radial, self.tangential);
        let ([s1, s2, s3, s4], [tx, ty]) = (self.prism, self.tilt_rad);
        [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty]
    }

    /// Distorts a direction.
    pub fn distort(&self, direction: DVec2) -> DVec2 {
        if let Some(k) = self.fisheye {
            return fisheye::distort(k, direction);
        }
        let r2 = direction.length_squared();
        let distorted = direction * (self.numerator(r2) / self.denominator(r2))
            + self.tangential_shift(direction);
        project(self.tilt(), distorted)
    }

    /// Inverse of [`distort`](Self::distort), after at most `steps` of the iteration. Not finite,
    /// or far off, where it does not converge; `distorted` itself where the radial factor is
    /// negative.
    fn undistort(&self, distorted: DVec2, steps: u32) -> DVec2 {
        if let Some(k) = self.fisheye {
            return fisheye::undistort(k, distorted, steps);
        }
        let distorted = project(self.tilt().inverse(), distorted);
        let mut direction = distorted;
        for _ in 0..steps {
            let r2 = direction.length_squared();
            let ratio = self.denominator(r2) / self.numerator(r2);
            // As OpenCV: a negative factor would mirror the direction.
            if ratio < 0.0 {
                return distorted;
            }
            let next = (distorted - self.tangential_shift(direction)) * ratio;
            let step = (next - direction).abs().max_element();
            direction = next;
            // NaN never becomes small, and would cost all of the remaining steps.
            if step <= MIN_STEP || step.is_nan() {
                break;
            }
        }
        direction
    }

    fn numerator(&self, r2: f64) -> f64 {
        1.0 + ((self.radial[2] * r2 + self.radial[1]) * r2 + self.radial[0]) * r2
    }

    fn denominator(&self, r2: f64) -> f64 {
        1.0 + ((self.radial[5] * r2 + self.radial[4]) * r2 + self.radial[3]) * r2
    }

    /// Shift by the tangential and thin-prism terms.
    fn tangential_shift(&self, DVec2 { x, y }: DVec2) -> DVec2 {
        let ([p1, p2], [s1, s2, s3, s4]) = (self.tangential, self.prism);
        let r2 = x * x + y * y;
        DVec2::new(
            2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + (s2 * r2 + s1) * r2,
            p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + (s4 * r2 + s3) * r2,
        )
    }

    /// `P R`, the homography of the sensor's tilt; sines have the signs of OpenCV's manual.
    fn tilt(&self) -> DMat3 {
        let ((sx, cx), (sy, cy)) = (self.tilt_rad[0].sin_cos(), self.tilt_rad[1].sin_cos());
        let rows = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
            DMat3::from_cols_array_2d(&[a, b, c]).transpose()
        };
        let about_x = rows([1.0, 0.0, 0.0], [0.0, cx, sx], [0.0, -sx, cx]);
        let about_y = rows([cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]);
        let rotation = about_y * about_x;
        let (r13, r23, r33) = (rotation.z_axis.x, rotation.z_axis.y, rotation.z_axis.z);
        rows([r33, 0.0, -r13], [0.0, r33, -r23], [0.0, 0.0, 1.0]) * rotation
    }
}

/// Applies a homography.
fn project(homography: DMat3, point: DVec2) -> DVec2 {
    let point = homography * point.extend(1.0);
    point.truncate() / point.z
}

/// A camera with lens distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensCamera {
    /// Focal lengths in pixels, along columns' and rows' axes.
    pub focal_px: DVec2,
    /// Principal point, in pixels from the top-left corner of the image: pixel centres lie at
    /// half-integers, as those of [`Pinhole`](crate::Pinhole).
    pub principal_px: DVec2,
    /// Distortion of the lens.
    pub distortion: Distortion,
}

/// The undistorted viewing ray of an image point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewingRay {
    /// Normalised image coordinates, the intersection with the plane at distance one: x right, y
    /// down.
    pub direction: DVec2,
    /// Reprojection error in pixels; not finite where the iteration diverged.
    pub error_px: f64,
}

/// Values that are those of no camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LensError {
    /// Focal lengths that are not positive and finite, in pixels.
    #[error("focal lengths of {0:?} pixels: both must be positive and finite")]
    FocalLength([f64; 2]),
    /// A principal point that is not finite, in pixels.
    #[error("a principal point of {0:?} pixels, which is not finite")]
    PrincipalPoint([f64; 2]),
    /// A number of coefficients that [`Distortion::from_opencv`] does not know.
    #[error("{0} coefficients of distortion; there are 0, 4, 5, 8, 12 or 14")]
    DistortionCount(usize),
    /// A number of coefficients that is none of a fisheye lens.
    #[error("{0} coefficients of a fisheye lens; there are 4")]
    FisheyeCount(usize),
    /// A coefficient of distortion that is not finite.
    #[error("coefficients of distortion of {0:?}, which are not finite")]
    Distortion(Vec<f64>),
}

impl LensError {
    /// The message with the field of a file in which focal lengths, principal point or distortion are.
    pub fn in_field(&self, [focal, principal, distortion]: [&str; 3]) -> String {
        let field = match self {
            Self::FocalLength(_) => focal,
            Self::PrincipalPoint(_) => principal,
            Self::DistortionCount(_) | Self::FisheyeCount(_) | Self::Distortion(_) => distortion,
        };
        format!("{field}: {self}")
    }
}

impl LensCamera {
    /// A camera of a file: focal lengths, principal point from the corner of the image, both in
    /// pixels, and distortion in the order of [`Distortion::from_opencv`].
    ///
    /// # Errors
    /// Focal lengths that are not positive, values that are not finite, another number of
    /// coefficients.
    pub fn from_file(
        focal_px: [f64; 2],
        principal_px: [f64; 2],
        distortion: &[f64],
    ) -> Result<Self, LensError> {
        if !focal_px.iter().all(|focal| *focal > 0.0 && focal.is_finite()) {
            return Err(LensError::FocalLength(focal_px));
        }
        // It may lie outside of the image, as it does where a sensor was cropped.
        if !principal_px.iter().all(|at| at.is_finite()) {
            return Err(LensError::PrincipalPoint(principal_px));
        }
        if !distortion.iter().all(|coefficient| coefficient.is_finite()) {
            return Err(LensError::Distortion(distortion.to_vec()));
        }
        let distortion = Distortion::from_opencv(distortion)
            .ok_or(LensError::DistortionCount(distortion.len()))?;
        Ok(Self { focal_px: focal_px.into(), principal_px: principal_px.into(), distortion })
    }

    /// As [`Self::from_file`], of a fisheye lens: distortion as [`Distortion::fisheye`] takes it.
    ///
    /// # Errors
    /// As [`Self::from_file`].
    pub fn fisheye_from_file(
        focal_px: [f64; 2],
        principal_px: [f64; 2],
        distortion: &[f64],
    ) -> Result<Self, LensError> {
        // Four values are an OpenCV lens as well: what is checked of them is the same.
        let camera = Self::from_file(focal_px, principal_px, distortion);
        let k = distortion.try_into().map_err(|_| LensError::FisheyeCount(distortion.len()));
        Ok(Self { distortion: Distortion::fisheye(k?), ..camera? })
    }

    /// A camera as OpenCV calibrates it: `fx, fy`, `cx, cy`, and distortion. There, pixel centres
    /// lie at integers.
    pub fn from_opencv(focal_px: DVec2, centre_px: DVec2, distortion: Distortion) -> Self {
        Self { focal_px, principal_px: centre_px + 0.5, distortion }
    }

    /// Image position in pixels (y down) of a point in camera space, in metres: that of
    /// [`Pinhole`](crate::Pinhole), x right, y up, looking along -z.
    ///
    /// Only points in front of the camera (`z < 0`) have one.
    pub fn image_from_camera(&self, point_m: DVec3) -> Option<DVec2> {
        let depth_m = -point_m.z;
        (depth_m > 0.0)
            .then(|| self.image_from_direction(DVec2::new(point_m.x, -point_m.y) / depth_m))
    }

    /// Image position in pixels of a direction, through the lens.
    pub fn image_from_direction(&self, direction: DVec2) -> DVec2 {
        self.pinhole_image_from_direction(self.distortion.distort(direction))
    }

    /// Image position in pixels of a direction in the same camera without distortion.
    pub fn pinhole_image_from_direction(&self, direction: DVec2) -> DVec2 {
        self.principal_px + direction * self.focal_px
    }

    /// Viewing ray of an image position, after at most `steps` of the iteration.
    pub fn direction_from_image(&self, image_px: DVec2, steps: u32) -> ViewingRay {
        let distorted = (image_px - self.principal_px) / self.focal_px;
        let direction = self.distortion.undistort(distorted, steps);
        // Distorting the result again shows whether the iteration has converged, in any model.
        let error_px = (self.image_from_direction(direction) - image_px).length();
        ViewingRay { direction, error_px }
    }
}

#[cfg(test)]
mod tests;
