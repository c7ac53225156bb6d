//! All effects that were found fitted together: the first was fitted without the second.

use crate::GapError;
use crate::fit::descend;
use crate::naming::{Bench, Named};
use crate::search::{own, parameter_knobs};

/// Rounds of the fit.
const ROUNDS: usize = 4;

impl Bench<'_> {
    /// Fits the numbers of the model and of all effects together, where that helps on what was held
    /// out.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn polish(&self, named: &mut Named) -> Result<(), GapError> {
        let mut knobs = parameter_knobs();
        knobs.extend(named.steps.iter().flat_map(|step| own(&step.contenders[0].found.trial)));
        let Some(last) = named.steps.last_mut() else { return Ok(()) };
        let fit = descend(&self.train, &named.after.model, &knobs, None, 1, ROUNDS)?;
        let held = self.judge(&fit.model)?;
        if held.misfit < named.after.misfit {
            last.contenders[0].held = held.clone();
            named.after = held;
        }
        Ok(())
    }
}
