//! The shipped networks, in the program: an installed one is far from its checkout.

use evpose_app::shipped::EmbeddedNetwork;

/// All of them, by the names that `--checkpoint` takes.
pub(crate) static NETWORKS: &[EmbeddedNetwork] = &[
    EmbeddedNetwork { name: "hand", bytes: include_bytes!("../../checkpoints/hand.bpk") },
    EmbeddedNetwork { name: "body", bytes: include_bytes!("../../checkpoints/body.bpk") },
    EmbeddedNetwork {
        name: "hand-quick",
        bytes: include_bytes!("../../checkpoints/hand-quick.bpk"),
    },
    EmbeddedNetwork {
        name: "body-quick",
        bytes: include_bytes!("../../checkpoints/body-quick.bpk"),
    },
];
