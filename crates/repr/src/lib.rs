//! Event representations: events to dense planes for networks and viewers.
//!
//! * [`Representation`]: planes of a stream as it arrives, in `f32` and in 8 bits ([`Grey`]).
//!   - of a window: [`Lnes`], [`Eoi`], [`Eci`], [`EciS`], [`Binary`], [`EventCount`], [`VoxelGrid`];
//!   - with a memory of their own: [`Eros`], [`Tos`], [`Sits`], [`Pim`], [`Sae`], [`TimeSurface`];
//!   - of the latest events: [`FixedCount`].
//! * [`REPRESENTATIONS`]: the registry, with the [`Parameter`]s of each entry;
//!   [`representation_by_name`] parses `eros:kernel=9,decay=0.5` into a [`RepresentationChoice`],
//!   which starts on a stream or fills the planes of a window of frames.
//! * [`FrameWindow`], [`FrameEvent`]: windows of 1 ms frames, as training reads them;
//!   [`fill_lnes`], [`fill_eoi`], [`fill_eci`], [`fill_eci_s`] draw them directly.
//! * [`ErosFramer`]: an EROS in 8 bits, blurred and resized, as the published online program sends
//!   it.
//! * [`ChannelOrder`]: order of the polarity channels, explicit everywhere.
//! * [`WindowAugmentation`]: augmentation of windows for training.
//! * [`ErosLike`]: photographs converted to EROS-like frames, and the steps of the conversion.
//! * [`RepresentationTrigger`]: decides when a stream is due for a new representation.
//!
//! ```
//! use evpose_repr::{
//!     ChannelOrder, Event, EventStream, Lnes, Micros, Polarity, Representation, SensorSize,
//!     StreamWindow,
//! };
//!
//! let sensor = SensorSize { width: 4, height: 3 };
//! let event = Event { t: Micros(25_000), x: 2, y: 1, polarity: Polarity::On };
//! let events = EventStream::from_events(sensor, [event])?;
//! let window = StreamWindow::new(sensor, Micros(50_000), ChannelOrder::OffFirst)?;
//! let mut lnes = Lnes::new(window);
//! lnes.push(&events);
//! lnes.advance(Micros(50_000));
//! let mut planes = vec![0.0; lnes.channels() * sensor.pixels()];
//! lnes.render(&mut planes);
//! // The ON channel is the second one; an event half a window old is worth one half.
//! assert!((planes[sensor.pixels() + 4 + 2] - 0.5).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Planes are `[channels][height][width]`, row by row from the top. The types of `evpose_core` in the
//! signatures here are re-exported.

mod augment;
mod binary;
mod channel;
mod clock;
mod count;
mod counts;
mod eros;
mod eros_like;
mod error;
mod event_count;
mod fade;
mod fixed_count;
mod frame;
mod grey;
mod last_times;
mod lnes;
mod neighbourhood;
mod occurrence;
mod pim;
mod registry;
mod representation;
mod sae;
mod sits;
mod sliding;
mod spec;
mod three_sigma;
mod time_surface;
mod tos;
mod trigger;
mod voxel_grid;

pub use augment::{WindowAugmentation, WindowDraw};
pub use binary::Binary;
pub use channel::ChannelOrder;
pub use count::{Counting, Eci, EciS, fill_eci, fill_eci_s};
pub use eros::{Eros, ErosConfig, ErosFramer};
pub use eros_like::{
    Aperture, BlurWork, Canny, CannyWork, ColourOrder, ErosLike, ErosLikeWork, GaussianKernel,
    GradientNorm, grey_from_colour, pepper, salt_and_pepper,
};
pub use error::ReprError;
pub use event_count::EventCount;
pub use fixed_count::{FixedCount, FixedCountConfig};
pub use frame::{FrameEvent, FrameWindow};
pub use grey::Grey;
pub use lnes::{Lnes, fill_lnes};
pub use occurrence::{Eoi, fill_eoi};
pub use pim::{Pim, PimConfig};
pub use registry::{REPRESENTATIONS, representation_by_name};
pub use representation::{Representation, StreamWindow};
pub use sae::Sae;
pub use sits::{Ageing, Sits, SitsConfig};
pub use spec::{Fill, Memory, PolarityUse, RepresentationChoice, RepresentationSpec};
pub use time_surface::{TimeSurface, TimeSurfaceConfig};
pub use tos::{Tos, TosConfig};
pub use trigger::{RepresentationTrigger, TriggerConfig};
pub use voxel_grid::{VoxelGrid, VoxelGridConfig};

pub use evpose_core::{
    Event, EventStream, Micros, NumberKind, NumberSpec, Parameter, ParameterError, Plane, Polarity,
    Registry, RegistryError, SensorSize, Settings,
};
