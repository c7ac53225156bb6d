//! Events to dense planes.
//!
//! * [`Representation`]: planes of a stream as it arrives; [`Lnes`], [`Eoi`], [`Eci`], [`EciS`].
//! * [`FrameWindow`], [`FrameEvent`]: the same planes of a window of 1 ms frames at once, as training
//!   reads them; [`fill_lnes`], [`fill_eoi`], [`fill_eci`], [`fill_eci_s`].
//! * [`REPRESENTATIONS`]: all of them by name.
//! * [`ChannelOrder`]: which polarity comes first, explicit everywhere.
//! * [`WindowAugmentation`]: what varies from one training sample to the next.
//! * [`Transitions`]: the frames in which a simulated scene jumps.
//! * [`ErosLike`]: photographs made to look like EROS surfaces, and its steps.
//! * [`SurfaceTrigger`]: when a running stream is worth a new surface.
//!
//! Planes are `[channels][height][width]`, row by row from the top.

mod augment;
mod channel;
mod clock;
mod count;
mod eros_like;
mod error;
mod frame;
mod last_times;
mod lnes;
mod occurrence;
mod registry;
mod representation;
mod transition;
mod trigger;

pub use augment::{WindowAugmentation, WindowDraw};
pub use channel::ChannelOrder;
pub use count::{Counting, Eci, EciS, fill_eci, fill_eci_s};
pub use eros_like::{
    Aperture, BlurWork, Canny, CannyWork, ColourOrder, ErosLike, ErosLikeWork, GaussianKernel,
    GradientNorm, grey_from_colour, pepper, salt_and_pepper,
};
pub use error::ReprError;
pub use frame::{FrameEvent, FrameWindow};
pub use lnes::{Lnes, fill_lnes};
pub use occurrence::{Eoi, fill_eoi};
pub use registry::{REPRESENTATIONS, RepresentationSpec, representation_called};
pub use representation::{Representation, StreamWindow};
pub use transition::Transitions;
pub use trigger::{SurfaceTrigger, TriggerConfig};
