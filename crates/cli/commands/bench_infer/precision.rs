//! In which numbers networks are computed: the one place for it.

use clap::ValueEnum;
use evpose_infer::EngineOptions;

/// Numbers that networks are computed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Precision {
    /// 32 bits: nothing is rounded that the network as trained does not round
    F32,
}

impl Precision {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
        }
    }

    /// The engine's options for it.
    pub(super) fn options(self, options: EngineOptions) -> EngineOptions {
        match self {
            Self::F32 => options,
        }
    }

    /// By how much outputs may differ from those of others in 32 bits, relative to the largest.
    pub(super) fn tolerance(self) -> f64 {
        match self {
            Self::F32 => 1e-3,
        }
    }
}
