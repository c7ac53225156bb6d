//! Recordings with labels of the user's own, as training data of hands and bodies.
//!
//! * [`body`]: joints of people in 2D, in a registry of label formats, to recordings with tables of
//!   poses.
//! * [`hand`]: joints of a hand in 2D or 3D, to which its parameters are fitted, or parameters, to
//!   sequences in the view of a network.
//! * [`LabelClock`]: times of labelled images in the clock of the events.
//!
//! Time stamps of what is written count from the start of the sequence. A recording is cut where
//! labels are too far apart to be interpolated.
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_datasets::import::body::{BodyOptions, import_body, read_body_labels};
//!
//! let folder = tempfile::tempdir()?;
//! let labels = folder.path().join("wave.csv");
//! std::fs::write(&labels, "t_s,wrist_l_u_px,wrist_l_v_px\n0.1,60,80\n0.15,62,81\n")?;
//! let event = |t| Event { t: Micros(t), x: 61, y: 80, polarity: Polarity::On };
//! let events = EventStream::from_events(SensorSize::DAVIS240C, (0..200_000).step_by(500).map(event))?;
//!
//! let images = read_body_labels(&labels, None)?;
//! let out = folder.path().join("data");
//! let report = import_body(&events, &images, &labels, &BodyOptions::default(), &out, "wave")?;
//! assert_eq!(report.labels, 2);
//! assert!(out.join("wave.raw").exists() && out.join("wave.poses.csv").exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod body;
mod clock;
mod error;
pub mod hand;
mod stretch;
mod table;

pub use clock::{FrameCount, ImageTime, LabelClock};
pub use error::ImportError;
pub use stretch::WrittenSequence;
