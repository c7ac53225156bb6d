//! Activities: procedural motions of a whole body.
//!
//! * [`TRAINING_ACTIVITIES`], [`HELD_OUT_ACTIVITIES`]: the registry, a file per activity; an entry draws one
//!   person's motion.
//! * [`Performance`]: an activity with the posture, the sway and the pauses of one person.
//! * [`Figure`]: a posture in anatomical angles, converted to a pose.

mod arms;
mod boxing;
mod dancing;
mod figure;
mod jumping;
mod kicking;
mod mixed;
mod performance;
mod reaching;
mod rhythm;
mod sitting;
mod stretching;
#[cfg(test)]
mod tests;
mod turning;
mod walking;
mod waving;

use evpose_core::CounterRng;

pub use figure::{Anchor, Arm, Figure, Leg};
pub(crate) use figure::{SOLE, lowest_sole_m};
pub use performance::Performance;

/// A motion: a posture for every time in seconds.
pub type Motion = Box<dyn Fn(f32) -> Figure + Send + Sync>;

/// An activity.
#[derive(Debug, Clone, Copy)]
pub struct Activity {
    /// Name in configurations.
    pub name: &'static str,
    /// Description in a few words.
    pub about: &'static str,
    /// Draws the motion of one person.
    pub draw: fn(&mut CounterRng) -> Motion,
}

/// Activities that training draws from. A new one is a file and a line here.
pub static TRAINING_ACTIVITIES: &[Activity] = &[
    walking::ACTIVITY,
    waving::ACTIVITY,
    jumping::ACTIVITY,
    boxing::ACTIVITY,
    sitting::ACTIVITY,
    turning::ACTIVITY,
    reaching::ACTIVITY,
    sitting::SQUATTING,
    jumping::JACKS,
    walking::RUNNING,
    dancing::ACTIVITY,
    mixed::ACTIVITY,
];

/// Activities that are kept for evaluation: no shipped training may draw one, whole or in part.
pub static HELD_OUT_ACTIVITIES: &[Activity] =
    &[arms::ACTIVITY, kicking::ACTIVITY, stretching::ACTIVITY];

/// All activities.
pub fn activities() -> impl Iterator<Item = &'static Activity> {
    TRAINING_ACTIVITIES.iter().chain(HELD_OUT_ACTIVITIES)
}

/// Looks up an activity by name.
pub fn activity_by_name(name: &str) -> Option<&'static Activity> {
    activities().find(|activity| activity.name == name)
}
