//! What people do: motions of a whole body, made up from formulas.
//!
//! * [`ACTIVITIES`]: kinds of motion, each a file; an entry draws one person's way of it.
//! * [`Performance`]: an activity with the posture, the sway and the pauses of somebody.
//! * [`Figure`]: a posture in the words of anatomy, and the pose that it is.

mod arms;
mod boxing;
mod dancing;
mod figure;
mod jumping;
mod kicking;
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

/// A kind of motion.
#[derive(Debug, Clone, Copy)]
pub struct Activity {
    /// What it is called in configurations.
    pub name: &'static str,
    /// What is done.
    pub about: &'static str,
    /// Somebody's way of doing it.
    pub draw: fn(&mut CounterRng) -> Motion,
}

/// All kinds of motion. A new one is a file and a line here.
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
];

/// The activity of a name.
pub fn activity_called(name: &str) -> Option<&'static Activity> {
    ACTIVITIES.iter().find(|activity| activity.name == name)
}
