//! The mean of two networks.

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param};
use burn::tensor::{Tensor, TensorData};

/// The network whose weights, and statistics of normalisation, are halfway between those of two of one
/// shape. Of a network and one that was trained further from it, on other data, it often does as well
/// on either as the one made for it.
///
/// # Panics
/// If the shapes differ.
///
/// # Source
/// Wortsman et al., *Robust fine-tuning of zero-shot models*, CVPR 2022.
pub fn average<M: Module>(first: &M, second: M) -> M {
    let mut weights = Weights::default();
    first.visit(&mut weights);
    weights.0.reverse();
    second.map(&mut weights)
}

/// Weights in the order of a network, the next one last once they are mapped.
#[derive(Default)]
struct Weights(Vec<TensorData>);

impl ModuleVisitor for Weights {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0.push(param.val().into_data());
    }
}

impl ModuleMapper for Weights {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let other = self.0.pop().expect("as many weights");
        param.map(|weights| {
            let other = Tensor::from_data(other, &weights.device());
            weights.mul_scalar(0.5).add(other.mul_scalar(0.5))
        })
    }
}

#[cfg(test)]
mod tests {
    use burn::tensor::Device;

    use super::*;
    use crate::{HandRegressor, HandRegressorConfig};

    fn weights(network: &HandRegressor) -> Vec<f32> {
        let mut weights = Weights::default();
        network.visit(&mut weights);
        weights.0.iter().flat_map(|data| data.iter::<f32>().collect::<Vec<_>>()).collect()
    }

    #[test]
    fn every_weight_is_halfway() {
        let config = HandRegressorConfig { width: 0.0625, ..HandRegressorConfig::default() };
        let [first, second] = [1, 2].map(|seed| config.init(seed, &Device::flex()).unwrap());
        let mean = weights(&average(&first, second.clone()));
        let (first, second) = (weights(&first), weights(&second));
        assert!(first.len() > 1000 && first != second);
        for ((mean, first), second) in mean.iter().zip(&first).zip(&second) {
            assert!((mean - 0.5 * (first + second)).abs() < 1e-6);
        }
    }
}
