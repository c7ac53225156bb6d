//! Joints in metres to the coordinates of LiftMono-HPE, and back.

use evpose_core::{LensCamera, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, number};
use glam::{DVec2, Vec3};

const LENS_STEPS: u32 = 20;

/// The depths of joints in a camera as LiftMono-HPE has them.
///
/// # Model
/// Of a point at depth `d` relative to the reference depth `r`, that of the head: `z = a (1 - r /
/// d)`, 0 at the reference, with `a = (1 + sqrt(1 + e²)) / e` and `e` the larger side of what the
/// image shows at distance one. So -1 and 1 are as far apart in metres as the sides of the image at
/// the reference. Across the image, coordinates are those on it. The reference depth is not seen;
/// joints are scaled so that the torso has a known length, as far as the reference stays within
/// known depths.
///
/// # Source
/// Scarpellini et al.: *Lifting Monocular Events to 3D Human Poses*, CVPRW 2021; the projection is
/// that of Nibali's `pose3d-utils`, there with the principal point in the middle of the image. The
/// published depth is searched for; here it has a closed form, since joints at fixed coordinates
/// are in proportion to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftGeometry {
    camera: LensCamera,
    /// `a` of the model.
    depth_scale: f64,
    /// The smallest and the largest reference depth.
    reference_m: [f32; 2],
}

impl LiftGeometry {
    /// Of a camera.
    pub fn new(camera: LensCamera, sensor: SensorSize) -> Self {
        let size = DVec2::new(f64::from(sensor.width), f64::from(sensor.height));
        let extent = (size / camera.focal_px).max_element();
        Self {
            camera,
            depth_scale: (1.0 + (1.0 + extent * extent).sqrt()) / extent,
            reference_m: [0.0, f32::INFINITY],
        }
    }

    /// The same for people whose heads are between these depths, in metres: nobody is placed nearer
    /// or farther, however small or large the torso.
    #[must_use]
    pub fn within_depths(self, reference_m: [f32; 2]) -> Self {
        Self { reference_m, ..self }
    }

    /// The depth coordinates of joints in camera space (x right, y up, looking along -z), in
    /// metres; none without a head before the camera. Joints that are not before the camera are
    /// not finite.
    pub fn depths(&self, joints_m: &[Vec3; BODY_JOINTS]) -> Option<[f32; BODY_JOINTS]> {
        let reference_m = f64::from(-joints_m[number::HEAD].z);
        (reference_m.is_finite() && reference_m > 0.0).then(|| {
            joints_m.map(|joint| {
                let depth_m = f64::from(-joint.z);
                let depth = self.depth_scale * (1.0 - reference_m / depth_m);
                if depth_m > 0.0 { depth as f32 } else { f32::NAN }
            })
        })
    }

    /// Joints in camera space, in metres, of positions on the sensor in pixels and depth
    /// coordinates, for a torso of `torso_m` metres. All none if a joint of the torso is.
    pub fn joints_m(
        &self,
        joints_px: &BodyPoints,
        depths: &[f32; BODY_JOINTS],
        torso_m: f32,
    ) -> [Option<Vec3>; BODY_JOINTS] {
        // At a reference depth of one metre.
        let unit: [Option<Vec3>; BODY_JOINTS] = std::array::from_fn(|joint| {
            let ray = self.camera.direction_from_image(joints_px[joint]?.as_dvec2(), LENS_STEPS);
            let relative = 1.0 - f64::from(depths[joint]) / self.depth_scale;
            let depth = relative.recip();
            let at = ray.direction * depth;
            // The lens has y down and z forwards, camera space y up and z backwards.
            let at = glam::DVec3::new(at.x, -at.y, -depth).as_vec3();
            // A depth coordinate beyond the scale would lie behind the camera.
            (relative > 0.0 && at.is_finite()).then_some(at)
        });
        // A torso without length has no scale: it would put people at the farthest depth there is.
        let Some(length) = torso_of(&unit).filter(|length| *length > 0.0) else {
            return [None; BODY_JOINTS];
        };
        let [nearest_m, farthest_m] = self.reference_m;
        let reference_m = (torso_m / length).max(nearest_m).min(farthest_m);
        unit.map(|joint| Some(joint? * reference_m).filter(|at_m| at_m.is_finite()))
    }
}

/// The length of a torso from the middle of the hips to that of the shoulders, in metres; none if
/// one of the four is not finite.
pub fn torso_m(joints_m: &[Vec3; BODY_JOINTS]) -> Option<f32> {
    torso_of(&joints_m.map(|joint| joint.is_finite().then_some(joint)))
}

fn torso_of(joints: &[Option<Vec3>; BODY_JOINTS]) -> Option<f32> {
    let middle = |a: usize, b: usize| Some((joints[a]? + joints[b]?) * 0.5);
    let neck = middle(number::SHOULDER_L, number::SHOULDER_R)?;
    Some(neck.distance(middle(number::HIP_L, number::HIP_R)?))
}

#[cfg(test)]
mod tests {
    use evpose_core::Distortion;
    use glam::{DVec3, Vec2};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

    fn camera(distortion: Distortion) -> LensCamera {
        let (focal_px, principal_px) = (DVec2::new(300.0, 310.0), DVec2::new(170.0, 128.0));
        LensCamera { focal_px, principal_px, distortion }
    }

    fn person() -> [Vec3; BODY_JOINTS] {
        std::array::from_fn(|k| {
            let k = k as f32;
            Vec3::new(0.3 * (k * 1.3).sin(), 0.9 - 0.14 * k, -3.0 + 0.25 * (k * 0.7).cos())
        })
    }

    /// The published projection with the camera's matrix: z is `(near + far) / size - 2 near far /
    /// (size d)`, planes at which are `size` apart and whose harmonic mean is the reference.
    #[test]
    fn depths_are_those_of_the_published_projection() {
        let geometry = LiftGeometry::new(camera(Distortion::default()), SENSOR);
        let person = person();
        let depths = geometry.depths(&person).unwrap();
        let reference = -f64::from(person[number::HEAD].z);
        let size = reference * (346.0f64 / 300.0).max(260.0 / 310.0);
        let root = (reference.powi(2) + size.powi(2)).sqrt();
        let (one, other) = (0.5 * (root + reference - size), 0.5 * (root + reference + size));
        assert_eq!(depths[number::HEAD], 0.0);
        for (joint, depth) in person.iter().zip(depths) {
            let d = -f64::from(joint.z);
            let want = (one + other) / (other - one) - 2.0 * one * other / ((other - one) * d);
            assert!((f64::from(depth) - want).abs() < 1e-6, "{depth} {want}");
        }
    }

    #[test]
    fn a_person_comes_back_from_the_image_and_the_depths_through_any_lens() {
        let lens = Distortion::from_opencv(&[-0.2, 0.05, 0.001, -0.002]).unwrap();
        for distortion in [Distortion::default(), lens] {
            let camera = camera(distortion);
            let geometry = LiftGeometry::new(camera, SENSOR);
            let person = person();
            let joints_px = person.map(|joint| {
                let at = camera.image_from_camera(DVec3::from(joint)).unwrap();
                Some(Vec2::new(at.x as f32, at.y as f32))
            });
            let depths = geometry.depths(&person).unwrap();
            let torso_m = torso_m(&person).unwrap();
            let back = geometry.joints_m(&joints_px, &depths, torso_m);
            for (back, joint) in back.iter().zip(person) {
                assert!(back.unwrap().distance(joint) < 1e-3, "{back:?} {joint}");
            }
            let larger = geometry.joints_m(&joints_px, &depths, 2.0 * torso_m);
            assert!((larger[3].unwrap() - 2.0 * person[3]).length() < 2e-3);
            // No farther than anybody is, whatever the torso.
            let head_m = -person[number::HEAD].z;
            let bounded = geometry.within_depths([1.0, head_m]);
            let bounded = bounded.joints_m(&joints_px, &depths, 2.0 * torso_m);
            assert!((bounded[3].unwrap() - person[3]).length() < 1e-3);
        }
    }

    #[test]
    fn nobody_is_placed_without_a_torso_and_no_head_is_no_reference() {
        let geometry = LiftGeometry::new(camera(Distortion::default()), SENSOR);
        let mut joints_px = [Some(Vec2::new(100.0, 90.0)); BODY_JOINTS];
        joints_px[number::HIP_L] = None;
        assert_eq!(geometry.joints_m(&joints_px, &[0.0; BODY_JOINTS], 0.5), [None; BODY_JOINTS]);
        // Nor where all joints of the torso are in one place.
        let point = [Some(Vec2::new(100.0, 90.0)); BODY_JOINTS];
        assert_eq!(geometry.joints_m(&point, &[0.0; BODY_JOINTS], 0.5), [None; BODY_JOINTS]);
        let mut person = person();
        person[number::HEAD] = Vec3::NAN;
        assert_eq!(geometry.depths(&person), None);
    }
}
