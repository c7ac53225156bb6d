//! The kinds of outputs that networks of hands have.

use serde::{Deserialize, Serialize};

/// The outputs of a network of hands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HandHead {
    /// The parameters themselves, as published.
    #[default]
    Regressor,
    /// Heatmaps and depths of 21 joints, on a pyramid of [`Self::BACKBONE`].
    Joints,
}

impl HandHead {
    /// The backbone of networks of joints, as configs name it.
    pub const BACKBONE: &'static str = "resnet18";

    /// Whether it is the default.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
