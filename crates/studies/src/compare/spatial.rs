//! Joints in space from two or more calibrated cameras, of systems that find joints on images.

use std::collections::BTreeMap;

use anyhow::Result;
use evpose_core::{Micros, PlacedCamera};
use evpose_pose::body::triangulation::{Observation, intersect_rays};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_train::body::{BodyFrame, BodyRecordings, calibrated_scenes};
use glam::{DVec3, Vec3};

/// Joints that a system found on an image of a calibrated camera.
#[derive(Debug, Clone)]
pub(crate) struct SeenJoints {
    /// Index of the recording, and time.
    image: (u64, Micros),
    /// In pixels of the sensor.
    joints_px: BodyPoints,
    /// The truth in the camera, in metres; not finite where it is not known.
    truth_m: [Vec3; BODY_JOINTS],
}

/// The scene of each recording that two or more cameras show, and its camera, by the index of the
/// recording.
#[derive(Debug, Default)]
pub(crate) struct Scenes(BTreeMap<u64, (u64, PlacedCamera)>);

impl SeenJoints {
    /// Joints on a frame; none where its camera is not known, or its pixels are not those of the
    /// sensor.
    pub(crate) fn new(frame: &BodyFrame, joints_px: BodyPoints) -> Option<Self> {
        let camera = frame.camera?;
        let sensor = [camera.sensor.width, camera.sensor.height].map(usize::from);
        let is_sensor = sensor == [frame.image.width(), frame.image.height()];
        let image = (frame.sequence, frame.t);
        is_sensor.then_some(Self { image, joints_px, truth_m: camera.joints_m })
    }
}

impl Scenes {
    /// Those of a directory of recordings.
    pub(crate) fn new(recordings: &BodyRecordings) -> Result<Self> {
        let mut scenes = BTreeMap::new();
        for scene in calibrated_scenes(recordings)? {
            for (events, _, camera) in scene.recordings {
                let index = recordings.files.iter().position(|(file, _)| *file == events);
                if let Some(index) = index {
                    scenes.insert(index as u64, (scene.scene, camera));
                }
            }
        }
        Ok(Self(scenes))
    }

    /// Distances of joints from the truth in metres, of those that two or more cameras see at a time.
    ///
    /// # Model
    /// A joint is the point nearest to the rays of all cameras, unweighted. The truth is the mean of
    /// that of the cameras, whose frames may be labelled at slightly different times.
    ///
    /// # Source
    /// Calabrese et al.: *DHP19*, CVPRW 2019, section 4.
    pub(crate) fn errors_m(&self, seen: &[SeenJoints]) -> Vec<f32> {
        let mut moments: BTreeMap<(u64, Micros), Vec<(&PlacedCamera, &SeenJoints)>> =
            BTreeMap::new();
        for joints in seen {
            let (recording, t) = joints.image;
            if let Some((scene, camera)) = self.0.get(&recording) {
                moments.entry((*scene, t)).or_default().push((camera, joints));
            }
        }
        let mut errors_m = Vec::new();
        for mut views in moments.into_values() {
            // The order of predictions depends on threads.
            views.sort_by_key(|(_, joints)| joints.image);
            errors_m.extend((0..BODY_JOINTS).filter_map(|joint| error_m(&views, joint)));
        }
        errors_m
    }
}

fn error_m(views: &[(&PlacedCamera, &SeenJoints)], joint: usize) -> Option<f32> {
    let observations: Vec<Observation<'_>> = views
        .iter()
        .filter_map(|(camera, seen)| {
            // Rays are unweighted, as published: scores of different systems have no common scale.
            Some(Observation { camera, at_px: seen.joints_px[joint]?, score: 1.0 })
        })
        .collect();
    // A single ray has no intersection.
    if observations.len() < 2 {
        return None;
    }
    let position_m = intersect_rays(&observations)?;
    // Frames of cameras may be labelled at slightly different times: the truth is the mean.
    let truths: Vec<DVec3> = views
        .iter()
        .map(|(camera, seen)| {
            let in_camera = seen.truth_m[joint].as_dvec3();
            camera.camera_from_world.inverse().transform_point3(in_camera)
        })
        .filter(|truth| truth.is_finite())
        .collect();
    let truth_m = truths.iter().sum::<DVec3>() / truths.len() as f64;
    // Without a label the mean is NaN.
    Some(position_m.distance(truth_m) as f32).filter(|error| error.is_finite())
}

#[cfg(test)]
mod tests {
    use evpose_core::{Distortion, LensCamera};
    use glam::{DAffine3, DVec2, Vec2};

    use super::*;

    /// A camera three metres from the origin, turned about it.
    fn camera(degrees: f64) -> PlacedCamera {
        let lens = LensCamera {
            focal_px: DVec2::splat(300.0),
            principal_px: DVec2::new(173.0, 130.0),
            distortion: Distortion::default(),
        };
        let turn = DAffine3::from_rotation_y(degrees.to_radians());
        let away = DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0));
        PlacedCamera { lens, camera_from_world: away * turn }
    }

    fn seen(recording: u64, camera: &PlacedCamera, at_m: DVec3, off_px: Vec2) -> SeenJoints {
        let at_px = camera.image_from_world(at_m).map(|at| at.as_vec2() + off_px);
        let mut joints_px = BodyPoints::default();
        joints_px[4] = at_px;
        let mut truth_m = [Vec3::NAN; BODY_JOINTS];
        truth_m[4] = camera.camera_from_world.transform_point3(at_m).as_vec3();
        SeenJoints { image: (recording, Micros(7)), joints_px, truth_m }
    }

    #[test]
    fn two_cameras_find_a_joint_in_space_and_one_does_not() {
        let cameras = [camera(-45.0), camera(45.0)];
        let scenes = Scenes(BTreeMap::from([(2, (9, cameras[0])), (3, (9, cameras[1]))]));
        let at_m = DVec3::new(0.2, 0.3, -0.1);
        let exact =
            [seen(3, &cameras[1], at_m, Vec2::ZERO), seen(2, &cameras[0], at_m, Vec2::ZERO)];
        let errors = scenes.errors_m(&exact);
        assert!(errors.len() == 1 && errors[0] < 1e-4, "{errors:?}");
        assert!(scenes.errors_m(&exact[..1]).is_empty());
        // Three pixels up at three metres and 300 px: three centimetres.
        let up = Vec2::new(0.0, -3.0);
        let off = [seen(2, &cameras[0], at_m, up), seen(3, &cameras[1], at_m, up)];
        let errors = scenes.errors_m(&off);
        assert!((errors[0] - 0.03).abs() < 0.005, "{errors:?}");
    }
}
