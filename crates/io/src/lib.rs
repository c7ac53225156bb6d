//! Event, label and frame files, opened by content.
//!
//! * [`open`], [`info`]: any recording, whole or described. [`FORMATS`] lists the formats.
//! * [`evc`], [`meta`]: the sequences of EventHands, events and labels, of any size, by random
//!   access.
//! * [`npz`], [`text`]: recordings for other tools.
//! * [`frames`]: the light of an image sequence, one frame at a time.
//!
//! A faulty file is a typed [`IoError`] that names the file, the byte and what was readable before
//! it; files appear under their name only when they are complete.

mod error;
pub mod evc;
pub mod frames;
mod info;
pub mod meta;
pub mod npz;
mod open;
mod order;
mod positional;
pub mod text;

pub use error::IoError;
pub use evc::{EvcEvent, EvcReader, EvcWindow, EvcWriter};
pub use frames::{Encoding, FrameFault, FrameSource};
pub use info::{Info, Labels};
pub use meta::{MetaReader, MetaWriter};
pub use open::{
    FORMATS, Format, Recording, SensorOrigin, format_called, format_for, format_of, info, open,
    open_with,
};
