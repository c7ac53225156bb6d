//! Operations of networks that no engine compiles: in training those run in planes.

use burn::tensor::Tensor;

use crate::net_ops::NetOps;
use crate::ops::Blocked;

/// Operations on `[batch, channels, height, width]` that [`NetOps`] has none for.
pub(crate) trait PlaneOps: NetOps {
    /// Rows and columns.
    fn size(&self) -> [usize; 2];

    /// `layer(self)`, computed by Burn.
    fn in_planes(self, layer: impl FnOnce(Tensor<4>) -> Tensor<4>) -> Self;
}

impl PlaneOps for Tensor<4> {
    fn size(&self) -> [usize; 2] {
        let [_, _, height, width] = self.dims();
        [height, width]
    }

    fn in_planes(self, layer: impl FnOnce(Tensor<4>) -> Tensor<4>) -> Self {
        layer(self)
    }
}

impl PlaneOps for Blocked {
    fn size(&self) -> [usize; 2] {
        self.image_size()
    }

    fn in_planes(self, layer: impl FnOnce(Tensor<4>) -> Tensor<4>) -> Self {
        self.through_planes(layer)
    }
}
