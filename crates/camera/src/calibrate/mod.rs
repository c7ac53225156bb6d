//! Parameters of an event camera, estimated from recordings made for it.
//!
//! * [`threshold`]: frames and events of a moving pattern; contrast thresholds by totals (what all
//!   events together stand for) and by the steps of single pixels.
//! * [`noise`]: a recording of a scene at rest; background rates and hot pixels.
//!
//! Every estimate comes with an interval. Intervals are bootstrapped over parts of the image, or of
//! time, within which events resemble each other.
//!
//! ```
//! use evpose_camera::calibrate::threshold::{FLOOR, ThresholdRun};
//! use evpose_core::{EventStream, Micros, Plane, SensorSize};
//! use evpose_sensor::{SensorConfig, SensorModel};
//!
//! let size = SensorSize { width: 32, height: 24 };
//! // Waves of light that cross the sensor, at 1000 frames per second.
//! let frames = (0..200u16).map(|k| {
//!     let value = |x: u16| 0.3 * (0.9 * (0.35 * f32::from(x) - 0.1 * f32::from(k)).sin()).exp();
//!     let pixels = (0..size.height).flat_map(|_| (0..size.width).map(value)).collect();
//!     Plane::from_vec(32, 24, pixels).expect("a value per pixel")
//! });
//! let frames: Vec<Plane<f32>> = frames.collect();
//! let mut camera = SensorModel::from_config(&SensorConfig::default())?.start(size, 1);
//! let mut events = EventStream::empty(size);
//! for (frame, t_us) in frames.iter().zip((0..).step_by(1_000)) {
//!     for event in camera.expose(frame, Micros(t_us))?.iter() {
//!         events.push(event)?;
//!     }
//! }
//!
//! let mut run = ThresholdRun::new(size, 1_000.0, FLOOR, &events)?;
//! for frame in &frames {
//!     run.push(frame)?;
//! }
//! let thresholds = run.finish(1)?;
//! // The ideal sensor has thresholds of 0.2.
//! assert!((thresholds.by_steps_on.estimate - 0.2).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
pub mod noise;
mod steps;
pub mod threshold;
mod tiles;

pub use error::CalibrateError;
