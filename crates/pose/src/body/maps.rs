//! Output maps of a body network.

/// Maps over a coarse grid of the image, as tensors, slices or any other storage.
///
/// # Source
/// *MoveNet* by Google, as in Goyal et al.: *MoveEnet: Online High-Frequency Human Pose Estimation
/// with an Event Camera*, CVPRW 2023.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyMaps<T> {
    /// Probability of a joint in a cell, 0 to 1: one channel for each joint.
    pub heatmaps: T,
    /// Probability of the body's centre in a cell, 0 to 1: one channel.
    pub centers: T,
    /// Displacement of joints from the body's centre, in cells: channel `2n` is x of joint `n`, `2n
    /// + 1` is y.
    pub regs: T,
    /// Offset of a joint within its cell, in cells: channels as those of `regs`.
    pub offsets: T,
}

impl<T> BodyMaps<T> {
    /// Heatmaps, centers, regs, offsets.
    pub fn into_array(self) -> [T; 4] {
        [self.heatmaps, self.centers, self.regs, self.offsets]
    }

    /// The inverse of [`into_array`](Self::into_array).
    pub fn from_array([heatmaps, centers, regs, offsets]: [T; 4]) -> Self {
        Self { heatmaps, centers, regs, offsets }
    }
}
