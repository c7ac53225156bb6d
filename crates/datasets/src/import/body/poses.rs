//! Labelled images of one person each, in the clock of the events and the pixels of the sensor.

use std::path::Path;

use evpose_core::{Micros, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec2;

use super::format::LabelledImage;
use crate::import::ImportError;
use crate::import::clock::LabelClock;

/// Largest relative difference of aspect ratios at which labels of another image size are scaled.
const SAME_ASPECT: f32 = 0.02;

/// Joints of a person over time, in the order of time.
#[derive(Debug, Default)]
pub(super) struct LabelledPoses {
    /// Time stamps.
    pub(super) times: Vec<Micros>,
    /// Joints in pixels of the sensor; none where not labelled or outside of the image.
    pub(super) joints_px: Vec<BodyPoints>,
    /// Images without annotations, which are skipped.
    pub(super) without_person: usize,
    /// Images with several persons, of whom the largest is used.
    pub(super) several_persons: usize,
    /// Labelled joints outside of the image.
    pub(super) outside: usize,
    /// Size of the images of the labels, where it differs from the sensor's.
    pub(super) scaled_from: Option<[f32; 2]>,
}

impl LabelledPoses {
    /// The poses of `images`, which are of the label file at `path`.
    ///
    /// # Errors
    /// If an image has no time stamp or that of another, or another aspect ratio than the sensor.
    pub(super) fn new(
        images: &[LabelledImage],
        clock: &LabelClock,
        sensor: SensorSize,
        path: &Path,
    ) -> Result<Self, ImportError> {
        let times: Vec<_> = images.iter().map(|image| image.time.clone()).collect();
        let times = clock.times(&times, path)?;
        // Files list images in any order.
        let mut order: Vec<usize> = (0..images.len()).collect();
        order.sort_by_key(|index| times[*index]);
        for pair in order.windows(2) {
            if times[pair[0]] == times[pair[1]] {
                let reason = format!("at the same time as image {}", pair[0]);
                return Err(ImportError::malformed(path, format!("image {}", pair[1]), reason));
            }
        }
        let mut poses = Self::default();
        for index in order {
            let image = &images[index];
            let Some(person) = largest(&image.persons) else {
                poses.without_person += 1;
                continue;
            };
            poses.several_persons += usize::from(image.persons.len() > 1);
            let scale = poses.scale(image, sensor, |reason| {
                ImportError::malformed(path, format!("image {index}"), reason)
            })?;
            let labelled = person.iter().flatten().count();
            let joints_px =
                // A network cannot learn joints beyond the border.
                person.map(|at_px| at_px.map(|at| at * scale).filter(|at| is_on(*at, sensor)));
            poses.outside += labelled - joints_px.iter().flatten().count();
            poses.times.push(times[index]);
            poses.joints_px.push(joints_px);
        }
        if poses.times.is_empty() {
            return Err(ImportError::Empty { path: path.to_owned(), content: "labels" });
        }
        Ok(poses)
    }

    /// Pixels of the sensor for a pixel of an image, or the fault of an image that is not one of it.
    fn scale(
        &mut self,
        image: &LabelledImage,
        sensor: SensorSize,
        fault: impl Fn(String) -> ImportError,
    ) -> Result<Vec2, ImportError> {
        let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let Some(size_px) = image.size_px.filter(|own| *own != size.to_array()) else {
            return Ok(Vec2::ONE);
        };
        let scale = size / Vec2::from(size_px);
        // Labels of a cropped or stretched image lie elsewhere on the sensor.
        let is_same = (scale.x / scale.y - 1.0).abs() <= SAME_ASPECT;
        if !is_same {
            let [width, height] = size_px;
            let reason = format!("labels on {width}x{height} pixels, but the sensor has {sensor}");
            return Err(fault(reason));
        }
        self.scaled_from = Some(size_px);
        Ok(scale)
    }

    /// Count of labels of each joint.
    pub(super) fn counts(joints_px: &[BodyPoints]) -> [usize; BODY_JOINTS] {
        let labelled = |joint: usize| joints_px.iter().filter(|pose| pose[joint].is_some()).count();
        std::array::from_fn(labelled)
    }
}

fn is_on(at_px: Vec2, sensor: SensorSize) -> bool {
    (0.0..f32::from(sensor.width)).contains(&at_px.x)
        && (0.0..f32::from(sensor.height)).contains(&at_px.y)
}

/// The person of the largest diagonal on the image.
fn largest(persons: &[BodyPoints]) -> Option<&BodyPoints> {
    let diagonal_px = |person: &BodyPoints| {
        let points = || person.iter().flatten();
        let low = points().fold(Vec2::INFINITY, |low, at| low.min(*at));
        let high = points().fold(Vec2::NEG_INFINITY, |high, at| high.max(*at));
        // Without points both bounds are infinite, and so would be the diagonal.
        if points().count() == 0 { 0.0 } else { low.distance(high) }
    };
    persons.iter().max_by(|a, b| diagonal_px(a).total_cmp(&diagonal_px(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::clock::ImageTime;

    const SENSOR: SensorSize = SensorSize { width: 100, height: 80 };

    fn person(at: f32, apart: f32) -> BodyPoints {
        std::array::from_fn(|joint| (joint < 2).then(|| Vec2::splat(at + joint as f32 * apart)))
    }

    fn image(t: i64, persons: Vec<BodyPoints>) -> LabelledImage {
        LabelledImage { time: ImageTime::Stamp(Micros(t)), size_px: None, persons }
    }

    fn poses(images: &[LabelledImage]) -> Result<LabelledPoses, ImportError> {
        LabelledPoses::new(images, &LabelClock::default(), SENSOR, Path::new("l.json"))
    }

    #[test]
    fn images_are_sorted_and_the_largest_person_is_used() {
        let images = [
            image(20, vec![person(1.0, 2.0), person(5.0, 9.0)]),
            image(10, vec![person(70.0, 20.0)]),
            image(30, Vec::new()),
        ];
        let poses = poses(&images).unwrap();
        assert_eq!(poses.times, [Micros(10), Micros(20)]);
        assert_eq!(poses.joints_px[1][0], Some(Vec2::splat(5.0)));
        // Of the first image, one joint is below the sensor.
        assert_eq!(poses.joints_px[0][1], None);
        assert_eq!((poses.outside, poses.without_person, poses.several_persons), (1, 1, 1));
        assert_eq!(LabelledPoses::counts(&poses.joints_px)[..3], [2, 1, 0]);
    }

    #[test]
    fn labels_of_a_larger_image_are_scaled_and_of_another_shape_refused() {
        let sized = |size_px| LabelledImage { size_px, ..image(1, vec![person(20.0, 20.0)]) };
        let scaled = poses(&[sized(Some([200.0, 160.0]))]).unwrap();
        assert_eq!(scaled.joints_px[0][1], Some(Vec2::splat(20.0)));
        assert_eq!(scaled.scaled_from, Some([200.0, 160.0]));
        let message = poses(&[sized(Some([200.0, 200.0]))]).unwrap_err().to_string();
        assert!(message.contains("image 0: labels on 200x200"), "{message}");
        assert!(poses(&[sized(Some([0.0, 0.0]))]).is_err());
    }

    #[test]
    fn two_images_of_one_time_are_refused() {
        let one = image(10, vec![person(1.0, 2.0)]);
        let message = poses(&[one.clone(), one]).unwrap_err().to_string();
        assert!(message.contains("image 1: at the same time as image 0"), "{message}");
    }
}
