//! The event camera as a chain of physical stages.
