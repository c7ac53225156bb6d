//! The mean of two networks.

use burn::module::Module;

use crate::parameters::{fill, read};

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
    let mut pairs = read(first).into_iter().zip(read(&second));
    fill(second, |_| {
        let ((one, first), (other, second)) = pairs.next().expect("as many weights");
        assert_eq!(one, other, "weights of one shape");
        first.iter().zip(second).map(|(first, second)| 0.5 * first + 0.5 * second).collect()
    })
}

#[cfg(test)]
mod tests {
    use burn::tensor::Device;

    use super::*;
    use crate::{HandRegressor, HandRegressorConfig};

    fn weights(network: &HandRegressor) -> Vec<f32> {
        read(network).into_iter().flat_map(|(_, values)| values).collect()
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
