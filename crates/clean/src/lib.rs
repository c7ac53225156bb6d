//! Preprocessing of recordings: undistort, denoise, mask, deflicker. Events in, events out.
//!
//! * [`CLEANERS`], [`CleanRequest`]: all cleaners by name, with their parameters.
//! * [`CleanerChain`]: several of them, one after the other, batch by batch, with counts of what each
//!   removed.
//! * [`Undistort`]: removes lens distortion.
//! * [`Background`]: removes events that no neighbour confirms; [`Denoise`]: the same as a setting of
//!   a network's view.
//! * [`HotPixels`], [`PixelActivity`]: finds pixels that fire without a cause; [`Mask`], [`Masking`]:
//!   removes them.
//! * [`Deflicker`]: removes single pixels where a lamp makes all of them fire.
//! * [`Checkup`]: checks of the axes, polarities and time stamps of a recording;
//!   [`symmetry`]: checks against reference events of the same scene.
//!
//! ```
//! use evpose_clean::{CleanerChain, CleanRequest};
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//!
//! let sensor = SensorSize { width: 8, height: 6 };
//! let event = |k, x| Event { t: Micros(k), x, y: 3, polarity: Polarity::On };
//! // 1,000 events of one pixel, and one event of another.
//! let recording = (0..1_000).map(|k| event(k, 5)).chain([event(1_000, 2)]);
//! let mut events = EventStream::from_events(sensor, recording)?;
//!
//! let mut chain = CleanerChain::new(sensor, &["hot:count=500".parse::<CleanRequest>()?])?;
//! chain.survey(&events)?;
//! chain.end_survey()?;
//! chain.clean(&mut events)?;
//! assert_eq!(events.len(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Deviations of published programs are presets under their names.

mod activity;
mod background;
mod chain;
mod checkup;
mod cleaner;
mod deflicker;
mod denoise;
mod error;
mod hot;
mod mask;
mod masking;
mod rates;
mod registry;
mod spec;
pub mod symmetry;
mod undistort;

#[cfg(test)]
mod laws;

pub use activity::{HotPixel, HotRule, PixelActivity};
pub use background::{Background, BackgroundOptions};
pub use chain::{CleanReport, CleanerChain};
pub use checkup::{Checkup, Findings};
pub use cleaner::{Cleaner, Note};
pub use deflicker::{Deflicker, DeflickerOptions, Rule};
pub use denoise::{Denoise, DenoiseFilter};
pub use error::CleanError;
pub use hot::HotPixels;
pub use mask::{Mask, Rectangle};
pub use masking::Masking;
pub use rates::{RateCheck, RateFindings};
pub use registry::{CLEANERS, CleanRequest, cleaner_by_name};
pub use spec::{Build, CleanerSpec};
pub use undistort::{Inverse, Outside, Rounding, TOLERANCE_PX, Undistort, UndistortOptions};
