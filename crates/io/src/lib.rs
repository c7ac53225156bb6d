//! Event, label and frame files, opened by content.
//!
//! * [`open`], [`info`], [`Windows`]: any recording, whole, described, or window by window.
//!   [`FORMATS`] lists the formats; each is a way to make an [`EventSource`], and an [`EventSink`]
//!   where it can be written.
//! * [`evc`], [`meta`]: the sequences of EventHands, events and labels, of any size, by random
//!   access.
//! * [`aedat4`]: recordings of iniVation's cameras, with their frames, inertial samples and
//!   triggers.
//! * [`npz`], [`text`]: recordings for other tools, as archives, arrays, tables and lines; HDF5 files
//!   of all usual layouts, with the Cargo feature `hdf5`.
//! * [`evt`], [`dat`]: recordings of Prophesee's cameras.
//! * [`ros`]: recordings of ROS, with their images.
//! * [`aedat2`], [`nmnist`], [`yarp`], Event Stream: recordings of other programs and data sets.
//! * [`framed`]: a stream for sockets and pipes, of our own.
//! * [`poses`]: poses of hands and people over time, as tables and JSON Lines, and the layouts of other
//!   programs.
//! * [`tensors`]: windows of a recording as dense planes, for other programs.
//! * [`frames`]: the light of an image sequence, one frame at a time.
//!
//! The types of `evpose_core` and `evpose_pose` in the signatures here are re-exported.
//!
//! A faulty file is a typed [`IoError`] that names the file, the byte and the count of events
//! readable before it; files appear under their name only when they are complete.
//!
//! ```
//! use evpose_io::{
//!     Event, EventStream, Micros, OpenOptions, Polarity, SensorSize, TimeWindow, Windows, create, open,
//! };
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("two.raw");
//! let event = |t| Event { t: Micros(t), x: 3, y: 2, polarity: Polarity::On };
//! let events = EventStream::from_events(SensorSize::DAVIS240C, [event(5), event(70_000)])?;
//! let mut sink = create(&path, events.sensor())?;
//! sink.write(&events)?;
//! sink.finish()?;
//!
//! let recording = open(&path)?;
//! assert_eq!((recording.format, &recording.stream), ("evt3", &events));
//!
//! let mut windows = Windows::open(&path, &OpenOptions::default())?;
//! let mut window = EventStream::empty(windows.sensor());
//! windows.read(TimeWindow { start: Micros(0), end: Micros(10_000) }, &mut window)?;
//! assert_eq!(window.len(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod aedat2;
mod aedat3;
pub mod aedat4;
mod columns;
pub mod dat;
mod error;
mod es;
pub mod evc;
pub mod evt;
mod fill;
mod first_line;
pub mod framed;
pub mod frames;
#[cfg(test)]
mod golden;
mod hdf5;
mod joints;
pub mod meta;
mod names;
pub mod nmnist;
pub mod npz;
mod open;
pub mod poses;
mod positional;
mod predictions;
pub mod ros;
#[cfg(test)]
mod sample;
mod sink;
mod sniff;
mod source;
pub mod tensors;
pub mod text;
mod time_stamp;
#[cfg(test)]
mod wire;
pub mod yarp;

pub use columns::Columns;
pub use error::IoError;
pub use evc::{EvcEvent, EvcReader, EvcWindow, EvcWriter};
pub use frames::{Encoding, FrameFault, FrameSource};
pub use joints::{HAND_JOINTS_ENDING, HandJointsWriter, JointsReader};
pub use meta::{MetaReader, MetaWriter};
pub use open::{
    Create, FORMATS, Format, Info, Labels, Open, OutsideCount, Recording, SensorOrigin, Windows,
    create, detect_format, find_sensor, format_for, info, input, open, open_as, open_with, read_as,
    recordings_by_stem, source, writable_format,
};
pub use sink::EventSink;
pub use source::{
    BlockSource, ColumnNames, DecodeFault, DecodeResult, Decoder, EventSource, Header, Input,
    MemorySource, OpenOptions, ReadSeek, Restarts, TimeUnit,
};

pub use evpose_core::{
    CoreError, Event, EventStream, Micros, Plane, Polarity, Rejected, SensorSize, TimeWindow,
};
pub use evpose_pose::{HandParams, metric::body::BodyPrediction};
