//! Activities: procedural motions of a whole body.
//!
//! * [`ACTIVITIES`]: the registry, a file per activity; an entry draws one person's motion.
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

/// All activities. A new one is a file and a line here.
pub static ACTIVITIES: &[Activity] = &[
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
    arms::ACTIVITY,
    kicking::ACTIVITY,
    stretching::ACTIVITY,
    dancing::ACTIVITY,
    mixed::ACTIVITY,
];

/// Looks up an activity by name.
pub fn activity_by_name(name: &str) -> Option<&'static Activity> {
    ACTIVITIES.iter().find(|activity| activity.name == name)
}
