//! The registry of representations. A new one is a file and a line here.

use evpose_core::{Registry, registry_entry};

use crate::{ReprError, RepresentationChoice, RepresentationSpec};
use crate::{
    binary, count, eros, event_count, fixed_count, lnes, occurrence, pim, sae, sits, time_surface,
    tos, voxel_grid,
};

/// All representations, in the order of tables and help texts; those of other crates come last.
pub static REPRESENTATIONS: Registry<RepresentationSpec> = Registry::new(&[
    &lnes::SPEC,
    &occurrence::SPEC,
    &count::ECI,
    &count::ECI_S,
    &count::ECI_PARITY,
    &count::ECI_S_PARITY,
    &eros::SPEC,
    &eros::PYTHON,
    &eros::HPE_CORE,
    &tos::SPEC,
    &sits::SPEC,
    &sits::HPE_CORE,
    &pim::SPEC,
    &sae::SPEC,
    &binary::SPEC,
    &fixed_count::SPEC,
    &event_count::SPEC,
    &voxel_grid::SPEC,
    &time_surface::SPEC,
]);

registry_entry!(RepresentationSpec, "representation");

/// Looks up the representation `name`, or `name:parameter=value,…`: `eros`,
/// `eros:kernel=9,decay=0.5`.
///
/// # Errors
/// Unknown names, parameters and values; the message lists the known ones.
pub fn representation_by_name(name: &str) -> Result<RepresentationChoice, ReprError> {
    let (name, settings) = match name.split_once(':') {
        Some((name, settings)) => (name, Some(settings)),
        None => (name, None),
    };
    let entry = REPRESENTATIONS.find(name).ok_or_else(|| ReprError::UnknownRepresentation {
        name: name.to_owned(),
        known: REPRESENTATIONS.names(),
    })?;
    match settings {
        Some(settings) => entry.with(settings),
        None => Ok(entry.with_defaults()),
    }
}

#[cfg(test)]
mod tests;
