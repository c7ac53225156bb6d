//! The stored file of a set.

use evpose_cli::provenance::Provenance;
use serde::Serialize;
use serde_json::Value;

/// The accuracy of all networks on a set.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    #[serde(flatten)]
    pub(super) provenance: Provenance,
    pub(super) set: &'static str,
    /// SHA-256 of the set: of `sha256sum`'s lines for its files, or of the manifests of what was simulated.
    pub(super) digest: String,
    /// How the recordings were simulated.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) simulated: Vec<Simulated>,
    pub(super) networks: Vec<NetworkRecord>,
}

#[derive(Debug, Serialize)]
pub(super) struct Simulated {
    pub(super) task: &'static str,
    pub(super) simulation: String,
    /// The lines of `manifest.sha256`.
    pub(super) manifest: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct NetworkRecord {
    pub(super) name: String,
    pub(super) task: &'static str,
    pub(super) sha256: String,
    /// The command, without the checkpoint.
    pub(super) evaluation: String,
    /// The content of the file of `evpose eval --json`.
    pub(super) result: Value,
}
