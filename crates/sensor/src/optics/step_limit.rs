//! Division of the steps between exposures, as the chain keeps it.

/// How finely steps may be divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AdaptiveSteps {
    pub(super) max_parts: u32,
}

impl AdaptiveSteps {
    /// Whether steps stay as they are.
    pub fn is_neutral(&self) -> bool {
        self.max_parts <= 1
    }
}
