//! The interface of a backbone: a network and the entry that describes it.

use burn::module::Module;
use burn::tensor::Device;

use crate::NnError;
use crate::channels::check_width;
use crate::graph::Graph;
use crate::initializer::{Initializer, seeded};
use crate::net_ops::NetOps;
use crate::parameters::Slot;

/// Channels of the images that backbones take.
pub(crate) const IMAGE_CHANNELS: usize = 3;

/// A network from images to a vector.
///
/// One generic forward pass serves training, inference and export: see [`NetOps`].
pub trait BackboneNet: Module {
    /// The forward pass.
    ///
    /// # Shapes
    /// - images: `[batch, 3, height, width]`
    /// - output: `[batch, outputs]`
    fn forward<N: NetOps>(&self, images: N) -> N::Vector;

    /// The distribution of the initial values of a tensor of this network.
    fn initializer(&self, slot: &Slot) -> Initializer;

    /// The path in torchvision's network of the layer at `path`. The last part, the tensor's own
    /// name, stays as it is. By default the paths are the same.
    fn torchvision_path(&self, path: &str) -> String {
        path.to_owned()
    }

    /// The layers with their weights, for engines that compile networks.
    fn graph(&self) -> Graph {
        Graph::trace(self, IMAGE_CHANNELS, |images| vec![self.forward(images)])
    }
}

/// The entry of a backbone: its name, its limits and its constructor.
pub struct BackboneSpec<N> {
    /// Name in configs and on the command line.
    pub name: &'static str,
    /// One line for lists: authors, year, and the reason to choose it.
    pub about: &'static str,
    /// The smallest side of an image that it takes, in pixels.
    pub smallest_px: usize,
    /// The relative width at which the smallest layer has one channel.
    pub narrowest: f32,
    /// From the relative width, the number of outputs and the device: the network with all weights
    /// zero.
    pub build: fn(f32, usize, &Device) -> N,
}

impl<N: BackboneNet> BackboneSpec<N> {
    /// The network `width` times as wide as published, its initial weights drawn from `seed`.
    ///
    /// # Errors
    /// [`NnError::Width`].
    pub fn init(
        &self,
        width: f32,
        outputs: usize,
        seed: u64,
        device: &Device,
    ) -> Result<N, NnError> {
        check_width(width, self.narrowest)?;
        let network = (self.build)(width, outputs, device);
        // `seeded` consumes the network, which its initializers describe.
        let layout = network.clone();
        Ok(seeded(network, seed, |slot| layout.initializer(slot)))
    }
}
