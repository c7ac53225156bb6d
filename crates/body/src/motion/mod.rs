//! How the arm moves: random targets and smooth paths between them, as published.
//!
//! * [`Variant`]: the published distributions of targets ([`target`]).
//! * [`BezierMotion`]: quadratic Bezier curves between them, one a second ([`bezier`]).
//! * [`ViewTest`]: when the wrist has left the image and the arm is called back ([`view`]).

pub mod bezier;
pub mod target;
pub mod view;

pub use bezier::{BezierMotion, MotionConfig};
pub use target::{Target, Variant};
pub use view::ViewTest;
