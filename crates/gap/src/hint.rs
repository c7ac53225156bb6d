//! Where to begin with numbers that a fit cannot find by going downhill.

use crate::Lab;
use crate::candidate::Trial;

/// The trial with numbers read off the recording, one for each that is likely.
pub fn of(_lab: &Lab<'_>, _name: &str, trial: &Trial) -> Vec<Trial> {
    vec![trial.clone()]
}
