//! Division of the steps between exposures, as the chain keeps it.

/// How finely steps may be divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AdaptiveSteps {
    pub(super) max_parts: u32,
}
