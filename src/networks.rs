//! The shipped networks, in the program: an installed one is far from its checkout.

use evpose_cli::shipped::EmbeddedNetwork;

macro_rules! network {
    ($name:literal) => {
        &EmbeddedNetwork {
            name: $name,
            bytes: include_bytes!(concat!("../checkpoints/", $name, ".bpk")),
            card: include_str!(concat!("../checkpoints/", $name, ".md")),
        }
    };
}

/// All of them, by the names that `--checkpoint` takes.
pub(crate) static NETWORKS: &[&EmbeddedNetwork] =
    &[network!("hand"), network!("body"), network!("hand-quick"), network!("body-quick")];
