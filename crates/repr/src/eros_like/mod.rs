//! Images made to look like EROS frames, so that a network can learn poses from photographs
//! before it sees an event.
//!
//! # Model
//! 1. Colour to grey, [`grey_from_colour`];
//! 2. a Gaussian blur, [`GaussianKernel`];
//! 3. edges, [`Canny`], as 0 and 255;
//! 4. [`pepper`]: holes in the edges, as events that never came;
//! 5. [`salt_and_pepper`]: pixels that are lit or dark at random;
//! 6. a Gaussian blur again.
//!
//! Steps 1 to 3 and 6 are those of OpenCV to the bit. The noise is counted, not streamed: it
//! depends on the seed and the pixel alone.
//!
//! # Source
//! Goyal, Di Pietro, Carissimi, Glover, Bartolozzi: *MoveEnet: Online High-Frequency Human Pose
//! Estimation with an Event Camera*, CVPRW 2023, and its published program.

mod blur;
mod canny;
mod convert;
mod gradient;
mod grey;
mod hysteresis;
mod ring;
mod speckle;
mod suppress;

pub use blur::{BlurWork, GaussianKernel};
pub use canny::{Canny, CannyWork};
pub use convert::{ErosLike, ErosLikeWork};
pub use gradient::{Aperture, GradientNorm};
pub use grey::{ColourOrder, grey_from_colour};
pub use speckle::{pepper, salt_and_pepper};
