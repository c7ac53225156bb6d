//! Videos of Human3.6M to events, and its poses to labels.
//!
//! # Model
//! Each frame is cut and resized to 640x480; between frames light changes in even steps, 1 ms long
//! at 50 frames a second; the sensor sees every step. The published set is made by v2e, which looks
//! at grey code values and draws the frames between by a network (Super SloMo) where here they are
//! mixed.

use evpose_core::{EventStream, Micros, Plane};
use evpose_io::FrameSource;
use evpose_sensor::{SensorConfig, SensorError, SensorModel};
use glam::IVec2;

use super::resize::Resizer;
use super::{Crop, CropRule, FPS, H36mPose, SENSOR, body_points};
use crate::DatasetError;
use crate::recording::TimedBody;

/// How frames become events.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesis {
    /// Sensor model that the frames are shown to.
    pub sensor: SensorConfig,
    /// Frames a second.
    pub fps: f64,
    /// Steps from one frame to the next.
    pub steps: u32,
    /// Seed of its noise.
    pub seed: u64,
    /// Threads of the sensor, on which its events do not depend.
    pub threads: usize,
}

impl Synthesis {
    /// As eH3.6M is made: v2e's sensor with the published thresholds and bandwidth, steps of 1 ms.
    ///
    /// # Errors
    /// Never, unless the description of the sensor that is part of this program is damaged.
    pub fn published(seed: u64) -> Result<Self, SensorError> {
        let sensor = SensorConfig::from_toml(include_str!("v2e.toml"))?;
        Ok(Self { sensor, fps: FPS, steps: 20, seed, threads: 1 })
    }
}

/// The events of frames, the first of which is at time 0. v2e's sensor takes code values for light:
/// the source is opened as [`Encoding::Linear`](evpose_io::Encoding::Linear) for it.
///
/// # Errors
/// If a frame cannot be read, the part is not inside the frames, the sensor cannot be built, or
/// there are more steps than microseconds.
pub fn events_of_frames(
    source: &mut FrameSource,
    crop: &Crop,
    how: &Synthesis,
) -> Result<EventStream, DatasetError> {
    let path = source.path().to_owned();
    let wrong = |place: &str, reason: String| DatasetError::malformed(&path, place, reason);
    let frame_px = IVec2::new(source.size().width.into(), source.size().height.into());
    if !crop.is_inside(frame_px) {
        let reason = format!("{crop} cannot be cut off frames of {}", source.size());
        return Err(wrong("crop", reason));
    }
    let steps_a_second = how.fps * f64::from(how.steps);
    // Written as what is allowed, so that NaN is refused.
    if !(how.fps > 0.0 && how.steps > 0 && steps_a_second <= 1e6) {
        let reason = format!("{} a second in {} steps: up to a million are", how.fps, how.steps);
        return Err(wrong("frames", reason));
    }
    let sensor = |source| DatasetError::Sensor { path: path.clone(), source };
    let model = SensorModel::from_config(&how.sensor).map_err(sensor)?.with_threads(how.threads);
    let mut run = model.start(SENSOR, how.seed);
    let mut resizer = Resizer::new(crop, frame_px);
    let mut stream = EventStream::empty(SENSOR);
    let mut frame = Plane::for_sensor(source.size(), 0.0);
    let [mut before, mut now, mut between] = [0; 3].map(|_| Plane::for_sensor(SENSOR, 0.0));
    let mut step = 0_u64;
    while source.next_into(&mut frame)? {
        resizer.resize(&frame, &mut now);
        let is_first = step == 0;
        // Before the first frame there is nothing to interpolate from.
        for part in if is_first { how.steps } else { 1 }..=how.steps {
            mix(&before, &now, part as f32 / how.steps as f32, &mut between);
            // From the number of the step: summed intervals would drift.
            let t = Micros::from_seconds(step as f64 / steps_a_second);
            let events = run.expose(&between, t).map_err(sensor)?;
            for event in events.iter() {
                stream.push(event).map_err(|error| wrong("events", error.to_string()))?;
            }
            step += 1;
        }
        // Swapped, not copied: the next frame overwrites the older one.
        std::mem::swap(&mut before, &mut now);
    }
    Ok(stream)
}

/// `share` of `now`, the rest of `before`; all of `now` is exactly that.
fn mix(before: &Plane<f32>, now: &Plane<f32>, share: f32, out: &mut Plane<f32>) {
    for ((out, a), b) in out.data_mut().iter_mut().zip(before.data()).zip(now.data()) {
        *out = a * (1.0 - share) + b * share;
    }
}

/// Joints of each frame on the event camera. With [`CropRule::Published`] they are on whole
/// pixels.
pub fn bodies_of_poses(
    poses: &[H36mPose],
    crop: &Crop,
    frame_px: IVec2,
    rule: CropRule,
    fps: f64,
) -> Vec<TimedBody> {
    let place = |point| crop.place(point, frame_px, rule);
    let body = |(frame, pose): (usize, &H36mPose)| TimedBody {
        t: Micros::from_seconds(frame as f64 / fps),
        points_px: body_points(pose).map(|point| point.map(place)),
    };
    poses.iter().enumerate().map(body).collect()
}
