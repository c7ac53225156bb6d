//! Event cameras: their calibration, the view of a network on them, their parameters.
//!
//! A network expects one image size and one focal length, its [`CanonicalView`]; recordings come
//! from sensors of any size behind any lens. In between are
//!
//! * [`Calibration`]: what is known of a camera, from a file of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing
//!   or this project, from a camera's name, from a field of view, or guessed, which a note says;
//! * [`read_rig`]: several cameras and their places;
//! * [`ViewAdaptor`]: events from the sensor's pixels to those of the canonical view, pooled so that
//!   an edge makes about as many events per canonical pixel whatever the resolution, and image
//!   positions of poses back to the sensor's pixels.
//!
//! [`calibrate`] estimates contrast thresholds and noise from recordings made for it.
//!
//! ```
//! use evpose_core::{EventStream, SensorSize};
//! use evpose_camera::{Calibration, CanonicalView, ViewAdaptor};
//!
//! let sensor = SensorSize { width: 1280, height: 720 };
//! let camera = Calibration::guessed(sensor);
//! let mut adaptor = ViewAdaptor::new(&camera, &CanonicalView::for_bodies(&camera));
//! let mut seen = EventStream::empty(adaptor.view().sensor);
//! adaptor.push(&EventStream::empty(sensor), &mut seen);
//! assert_eq!(seen.sensor(), SensorSize { width: 320, height: 240 });
//! ```

mod adaptor;
pub mod calibrate;
mod calibration;
mod camera_file;
mod canonical;
mod error;
mod file_formats;
mod polarity;
mod rig;

pub use adaptor::ViewAdaptor;
pub use calibration::{Calibration, CalibrationSource, NAMED_CAMERAS};
pub use camera_file::CameraFile;
pub use canonical::CanonicalView;
pub use error::CalibrationError;
pub use rig::read_rig;
