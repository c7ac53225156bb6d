//! The network of bodies on its device: our engine on the CPU, Burn on others.

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, Precision};
use evpose_nn::MoveEnet;
use evpose_pose::body::BodyMaps;

use crate::TaskError;

/// The maps of a network of bodies, by whatever computes them on the device of its weights.
pub(super) enum BodyInference {
    /// On the CPU.
    Engine(Box<Engine>),
    /// On other devices: all images of a call at once.
    Burn(Box<MoveEnet>, Device),
}

impl BodyInference {
    /// Compiles `network` for images of `shape`, channels, rows and columns, or leaves it on its
    /// device.
    ///
    /// # Errors
    /// [`TaskError::Precision`] for another precision than f32 on another device than the CPU, or if
    /// the network cannot be compiled.
    pub(super) fn new(
        network: &MoveEnet,
        shape: [usize; 3],
        options: EngineOptions,
        precision: Precision,
        ranges: Option<&CalibrationRanges>,
    ) -> Result<Self, TaskError> {
        let device = network.devices().into_iter().next().unwrap_or_else(Device::flex);
        if device == Device::flex() {
            let options = options.with_precision(precision);
            let engine = Engine::compile_with(&network.graph(), shape, options, ranges)?;
            return Ok(Self::Engine(Box::new(engine)));
        }
        // Burn computes in f32 whatever is asked for, which must not pass unnoticed.
        if precision != Precision::F32 {
            return Err(TaskError::Precision { precision });
        }
        Ok(Self::Burn(Box::new(network.clone()), device))
    }

    pub(super) fn another(&self) -> Self {
        match self {
            Self::Engine(engine) => Self::Engine(Box::new(engine.another())),
            Self::Burn(network, device) => Self::Burn(network.clone(), device.clone()),
        }
    }

    /// Whether every count of images is compiled for itself, in seconds: one count should serve all calls.
    pub(super) fn compiles_by_count(&self) -> bool {
        matches!(self, Self::Burn(..))
    }

    /// Calls `take` with the maps of each of `images`, `[channels][rows][columns]` one after another
    /// in the shape of [`Self::new`], in their order.
    pub(super) fn for_each(
        &mut self,
        images: &[f32],
        [channels, height, width]: [usize; 3],
        mut take: impl FnMut(&BodyMaps<&[f32]>),
    ) {
        let size = channels * height * width;
        match self {
            Self::Engine(engine) => {
                for image in images.chunks_exact(size) {
                    let [heatmaps, centers, regs, offsets] = engine.run(image) else {
                        unreachable!("graphs of bodies have four outputs");
                    };
                    let maps = [heatmaps, centers, regs, offsets].map(Vec::as_slice);
                    take(&BodyMaps::from_array(maps));
                }
            }
            Self::Burn(network, device) => {
                let count = images.len() / size;
                let data = TensorData::new(images.to_vec(), [count, channels, height, width]);
                let maps = network.forward(Tensor::from_data(data, &*device)).into_array();
                let maps: [Vec<f32>; 4] = maps.map(|map| map.into_data().iter().collect());
                for k in 0..count {
                    let of_image = maps.each_ref().map(|map| {
                        // Maps differ in their counts of channels, and so in their lengths.
                        let length = map.len() / count;
                        &map[k * length..][..length]
                    });
                    take(&BodyMaps::from_array(of_image));
                }
            }
        }
    }
}
