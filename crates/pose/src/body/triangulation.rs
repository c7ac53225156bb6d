//! Points in the world from their positions on the images of several calibrated cameras.
//!
//! # Model
//! A detection of score `s` is off by `detection_px / s` pixels, along columns and along rows. The
//! point is the one of least squares of reprojection errors with these weights: a linear solution
//! first, then Gauss-Newton. Its covariance is the inverse of the normal matrix. Where more than two
//! cameras see a joint, the detection that fits worst is left out until the others agree.
//!
//! # Source
//! Hartley and Zisserman, *Multiple View Geometry*, 2nd edition, sections 12.2 and 12.3. Calabrese et
//! al., *DHP19*, CVPRW 2019, intersect the rays of two cameras without weights:
//! [`intersect_rays`].

use evpose_core::PlacedCamera;
use glam::{DMat3, DVec2, DVec3, Vec2};
use serde::{Deserialize, Serialize};

/// Steps of the iteration that inverts lens distortion.
const INVERSE_STEPS: u32 = 20;
/// Steps of Gauss-Newton; two are enough where cameras agree.
const NEWTON_STEPS: usize = 5;
/// Smallest determinant of the normal matrix of directions: rays that are nearer to parallel do not
/// meet anywhere in particular.
const MIN_DETERMINANT: f64 = 1e-4;

/// A position on the image of a camera.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// Camera with its pose in the world.
    pub camera: &'a PlacedCamera,
    /// Position in pixels of the sensor, with the distortion of its lens.
    pub at_px: Vec2,
    /// Score, 0 to 1.
    pub score: f32,
}

/// Accuracy of detections, and which are used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriangulationConfig {
    /// Detections of a lower score are not used.
    pub min_score: f32,
    /// Standard deviation of a detection of score 1, in pixels.
    pub detection_px: f64,
    /// Largest reprojection error, relative to the standard deviation of the detection.
    pub max_error: f64,
}

impl Default for TriangulationConfig {
    fn default() -> Self {
        Self { min_score: 0.1, detection_px: 3.0, max_error: 3.0 }
    }
}

/// A point in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangulatedPoint {
    /// Position in metres.
    pub position_m: DVec3,
    /// Covariance of the position, in square metres.
    pub covariance_m2: DMat3,
    /// Root mean square of the reprojection errors in pixels.
    pub error_px: f64,
    /// Number of cameras that were used.
    pub cameras: usize,
}

/// The point that cameras see; none if fewer than two see it, if they do not agree, or if their rays
/// are parallel.
pub fn triangulate(
    observations: &[Observation<'_>],
    config: &TriangulationConfig,
) -> Option<TriangulatedPoint> {
    // Deviations are divided by the score: zero has none.
    let mut used: Vec<&Observation<'_>> = observations
        .iter()
        .filter(|seen| seen.score >= config.min_score && seen.score > 0.0 && seen.at_px.is_finite())
        .collect();
    // A camera may be wrong: the worst one is dropped until the others agree.
    while used.len() >= 2 {
        let point = least_squares(&used, config)?;
        let relative = |seen: &Observation<'_>| {
            let at_px = seen.camera.image_from_world(point.position_m);
            // A point behind a camera cannot be what it shows.
            let error_px = at_px.map_or(f64::INFINITY, |at| at.distance(seen.at_px.as_dvec2()));
            error_px / deviation_px(seen, config)
        };
        let errors: Vec<f64> = used.iter().map(|seen| relative(seen)).collect();
        let worst = (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b]))?;
        if errors[worst] <= config.max_error {
            return Some(point);
        }
        used.remove(worst);
    }
    None
}

/// The point with the least sum of squared distances to the rays of detections, without weights.
///
/// # Source
/// The program published with DHP19, `find_intersection`.
pub fn intersect_rays(observations: &[Observation<'_>]) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for seen in observations {
        let (eye_m, direction) = ray(seen)?;
        // Only the distance across the ray counts, since a pixel says nothing of the depth.
        let across = DMat3::IDENTITY - outer(direction, direction);
        matrix += across;
        right += across * eye_m;
    }
    (matrix.determinant() > MIN_DETERMINANT).then(|| matrix.inverse() * right)
}

fn deviation_px(seen: &Observation<'_>, config: &TriangulationConfig) -> f64 {
    config.detection_px / f64::from(seen.score)
}

/// Position of the camera, in metres, and direction of the point, of unit length.
fn ray(seen: &Observation<'_>) -> Option<(DVec3, DVec3)> {
    let viewing = seen.camera.lens.direction_from_image(seen.at_px.as_dvec2(), INVERSE_STEPS);
    let world_from_camera = seen.camera.camera_from_world.inverse();
    // The lens has y down and z forwards, the camera y up and z backwards.
    let in_camera = DVec3::new(viewing.direction.x, -viewing.direction.y, -1.0);
    let direction = world_from_camera.transform_vector3(in_camera).try_normalize()?;
    // No ray leads to a pixel beyond the rim of a fisheye lens.
    viewing.error_px.is_finite().then_some((world_from_camera.translation, direction))
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn least_squares(
    used: &[&Observation<'_>],
    config: &TriangulationConfig,
) -> Option<TriangulatedPoint> {
    let seen: Vec<Observation<'_>> = used.iter().map(|seen| **seen).collect();
    // A start: it minimises distances in space, not errors on the images.
    let mut position_m = intersect_rays(&seen)?;
    // That of the last step is the inverse of the covariance.
    let mut normal = DMat3::ZERO;
    for _ in 0..NEWTON_STEPS {
        let mut gradient = DVec3::ZERO;
        normal = DMat3::ZERO;
        for seen in &seen {
            // The inverse of the variance, as for any weighted mean.
            let weight = deviation_px(seen, config).powi(-2);
            let (at_px, rows) = projection_and_slopes(seen.camera, position_m)?;
            let error_px = seen.at_px.as_dvec2() - at_px;
            for (row, error) in rows.into_iter().zip(error_px.to_array()) {
                normal += outer(row, row) * weight;
                gradient += row * (weight * error);
            }
        }
        let step_m = normal.inverse() * gradient;
        // Rays are parallel: any point along them will do.
        if !step_m.is_finite() {
            return None;
        }
        position_m += step_m;
    }
    let errors = seen.iter().map(|seen| {
        let at_px = seen.camera.image_from_world(position_m)?;
        Some(at_px.distance_squared(seen.at_px.as_dvec2()))
    });
    // A point behind one camera is no answer.
    let squared: f64 = errors.sum::<Option<f64>>()?;
    Some(TriangulatedPoint {
        position_m,
        covariance_m2: normal.inverse(),
        error_px: (squared / seen.len() as f64).sqrt(),
        cameras: seen.len(),
    })
}

/// The image of a point, and the derivatives of its column and its row by the point. The derivatives
/// are those of the camera without distortion: its slopes differ little, and the iteration converges
/// to the same point.
fn projection_and_slopes(camera: &PlacedCamera, point_m: DVec3) -> Option<(DVec2, [DVec3; 2])> {
    let at_px = camera.image_from_world(point_m)?;
    let in_camera = camera.camera_from_world.transform_point3(point_m);
    // The camera looks along its negative z axis.
    let depth_m = -in_camera.z;
    let focal_px = camera.lens.focal_px;
    let column = DVec3::new(1.0, 0.0, in_camera.x / depth_m) * (focal_px.x / depth_m);
    let row = DVec3::new(0.0, -1.0, -in_camera.y / depth_m) * (focal_px.y / depth_m);
    let world = camera.camera_from_world.matrix3.transpose();
    Some((at_px, [world * column, world * row]))
}

#[cfg(test)]
mod tests {
    use evpose_core::{Distortion, LensCamera, LookAt};
    use glam::{DAffine3, Vec3};

    use super::*;

    /// A camera at an angle about the vertical axis, three metres from it.
    fn camera(angle_deg: f32, distortion: &[f64]) -> PlacedCamera {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let place = LookAt {
            eye_m: Vec3::new(3.0 * sin, 1.2, 3.0 * cos),
            centre_m: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
        };
        PlacedCamera {
            lens: LensCamera {
                focal_px: DVec2::new(310.0, 312.0),
                principal_px: DVec2::new(173.0, 130.0),
                distortion: Distortion::from_opencv(distortion).unwrap(),
            },
            camera_from_world: DAffine3::from_mat4(place.camera_from_world().as_dmat4()),
        }
    }

    const POINT: DVec3 = DVec3::new(0.2, 1.4, -0.1);

    fn seen<'a>(camera: &'a PlacedCamera, offset: Vec2, score: f32) -> Observation<'a> {
        let at_px = camera.image_from_world(POINT).unwrap().as_vec2() + offset;
        Observation { camera, at_px, score }
    }

    #[test]
    fn exact_detections_meet_in_the_point_through_any_lens() {
        for distortion in [&[][..], &[-0.2, 0.05, 1e-3, -1e-3][..]] {
            let cameras = [camera(-45.0, distortion), camera(45.0, distortion)];
            let all = [&cameras[0], &cameras[1]].map(|camera| seen(camera, Vec2::ZERO, 0.8));
            let point = triangulate(&all, &TriangulationConfig::default()).unwrap();
            assert!(point.position_m.distance(POINT) < 1e-4, "{}", point.position_m);
            assert!(point.error_px < 0.02 && point.cameras == 2, "{point:?}");
            assert!(intersect_rays(&all).unwrap().distance(POINT) < 1e-4);
        }
    }

    /// The covariance against its definition: the spread of solutions of noisy detections.
    #[test]
    fn the_covariance_is_that_of_repeated_detections() {
        let cameras = [camera(-30.0, &[]), camera(30.0, &[])];
        let config = TriangulationConfig { max_error: 100.0, ..TriangulationConfig::default() };
        let mut rng = evpose_core::CounterRng::new(1, "detections", 0);
        let (mut spread, count) = (DMat3::ZERO, 4_000);
        let mut predicted = DMat3::ZERO;
        for _ in 0..count {
            let all = [(&cameras[0], 1.0_f32), (&cameras[1], 0.5)].map(|(camera, score)| {
                let noise = Vec2::new(rng.normal(), rng.normal());
                seen(camera, noise * config.detection_px as f32 / score, score)
            });
            let point = triangulate(&all, &config).unwrap();
            let off = point.position_m - POINT;
            spread += outer(off, off) * (1.0 / f64::from(count));
            predicted = point.covariance_m2;
        }
        for axis in 0..3 {
            let ratio = spread.col(axis)[axis] / predicted.col(axis)[axis];
            assert!((ratio - 1.0).abs() < 0.1, "axis {axis}: {ratio}");
        }
        // Two cameras before the person know least about the depth.
        assert!(predicted.z_axis.z > 2.0 * predicted.x_axis.x, "{predicted}");
    }

    #[test]
    fn the_error_is_the_root_of_the_mean_square_over_cameras() {
        let cameras = [camera(-45.0, &[]), camera(45.0, &[])];
        let offsets = [Vec2::new(0.0, 3.0), Vec2::new(0.0, -3.0)];
        let pairs = cameras.iter().zip(offsets);
        let all: Vec<_> = pairs.map(|(camera, offset)| seen(camera, offset, 0.9)).collect();
        let point = triangulate(&all, &TriangulationConfig::default()).unwrap();
        // Rows that contradict each other by six pixels leave three to either camera.
        assert!((point.error_px - 3.0).abs() < 0.05, "{point:?}");
    }

    #[test]
    fn one_of_three_cameras_that_contradicts_the_others_is_left_out() {
        let cameras = [camera(-45.0, &[]), camera(0.0, &[]), camera(45.0, &[])];
        let all = [Vec2::ZERO, Vec2::new(0.0, 60.0), Vec2::ZERO];
        let all: Vec<_> =
            cameras.iter().zip(all).map(|(camera, offset)| seen(camera, offset, 0.9)).collect();
        let point = triangulate(&all, &TriangulationConfig::default()).unwrap();
        assert!(point.position_m.distance(POINT) < 1e-3 && point.cameras == 2, "{point:?}");
        // Of two, nobody knows which one is wrong.
        assert_eq!(triangulate(&all[..2], &TriangulationConfig::default()), None);
    }

    #[test]
    fn one_camera_and_parallel_rays_give_no_point() {
        let one = camera(10.0, &[]);
        let all = [seen(&one, Vec2::ZERO, 0.9), seen(&one, Vec2::ZERO, 0.9)];
        assert_eq!(triangulate(&all[..1], &TriangulationConfig::default()), None);
        assert_eq!(triangulate(&all, &TriangulationConfig::default()), None);
        assert_eq!(intersect_rays(&all), None);
    }
}
