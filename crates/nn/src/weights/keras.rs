//! The weights of DHP19's network as distributed: a Keras model in an HDF5 file.
//!
//! Of the file only the group `model_weights` is read: kernels as `LAYER/LAYER/kernel:0`, of shape
//! `[rows, columns, inputs, outputs]`, transposed convolutions with outputs before inputs.
//! Configuration and optimiser state are passed over.

use std::path::Path;

use burn::tensor::Device;

use crate::{Dhp19Cnn, Dhp19CnnConfig, NnError};

const FORMAT: &str = "Keras";

/// Reads the weights of a network of shape `config` from a Keras file such as DHP19's
/// `DHP_CNN.model`. The joints are brought into the order of our networks.
///
/// # Errors
/// [`NnError::Io`] if the file cannot be read, [`NnError::Unreadable`] if it is damaged, of another
/// kind, or the program was built without the feature `hdf5`; [`NnError::Mismatch`] for weights of
/// another network, and those of [`Dhp19CnnConfig::init`].
pub fn load_dhp19_cnn(
    path: &Path,
    config: &Dhp19CnnConfig,
    device: &Device,
) -> Result<Dhp19Cnn, NnError> {
    let network = config.zeros(device)?;
    let bytes =
        std::fs::read(path).map_err(|source| NnError::Io { path: path.to_owned(), source })?;
    imp::filled(network, bytes, path)
}

#[cfg(feature = "hdf5")]
mod imp {
    use std::collections::BTreeMap;
    use std::path::Path;

    use hdf5_reader::Hdf5File;
    use hdf5_reader::error::Error;

    use super::FORMAT;
    use crate::joint_order::NETWORK_FROM_DHP19;
    use crate::parameters::Slot;
    use crate::weights::strict::{Layout, Stored, TensorError, fill_strictly};
    use crate::{Dhp19Cnn, NnError};

    const WEIGHTS: &str = "model_weights";
    const KERNEL: &str = "kernel:0";

    pub(super) fn filled(
        network: Dhp19Cnn,
        bytes: Vec<u8>,
        path: &Path,
    ) -> Result<Dhp19Cnn, NnError> {
        let file = tensors(bytes).map_err(|error| NnError::Unreadable {
            path: path.to_owned(),
            format: FORMAT,
            reason: error.to_string(),
        })?;
        let network = fill_strictly(network, &Keras, file, path, FORMAT)?;
        // Published weights have the joints of DHP19 in its own order, the network has ours.
        let is_dhp19s = network.config().joints == NETWORK_FROM_DHP19.len();
        Ok(if is_dhp19s { network.with_joint_order(&NETWORK_FROM_DHP19) } else { network })
    }

    /// The kernels of all layers that have one, by layer.
    fn tensors(bytes: Vec<u8>) -> Result<BTreeMap<String, Stored>, Error> {
        let file = Hdf5File::from_vec(bytes)?;
        let mut tensors = BTreeMap::new();
        for layer in file.group(WEIGHTS)?.groups()? {
            let name = layer.name().rsplit('/').next().unwrap_or_default().to_owned();
            let (inner, _) = layer.member_names()?;
            // Layers without weights, such as poolings, have an empty group.
            if !inner.contains(&name) {
                continue;
            }
            let kernel = layer.group(&name)?.dataset(KERNEL)?;
            let shape: Vec<usize> = kernel.shape().iter().map(|&side| side as usize).collect();
            let read = move || {
                let values = kernel.read_array::<f32>().map_err(TensorError::of)?;
                Ok(values.iter().copied().collect())
            };
            tensors.insert(name, Stored::new(shape, read));
        }
        Ok(tensors)
    }

    /// Names and axes of Keras.
    struct Keras;

    impl Layout for Keras {
        fn name(&self, slot: &Slot) -> String {
            slot.path.trim_end_matches(".weight").to_owned()
        }

        fn shape(&self, slot: &Slot) -> Vec<usize> {
            match *slot.shape.as_slice() {
                [first, second, rows, columns] => vec![rows, columns, second, first],
                ref other => other.to_vec(),
            }
        }

        fn reordered(&self, slot: &Slot, values: &[f32]) -> Option<Vec<f32>> {
            let [first, second, rows, columns] = *slot.shape.as_slice() else { return None };
            let area = rows * columns;
            let at = |index: usize| {
                let (cell, second_index, first_index) =
                    (index % area, index / area % second, index / area / second);
                // Keras stores kernels as rows, columns, in, out; PyTorch's order is out, in, rows,
                // columns.
                values[(cell * second + second_index) * first + first_index]
            };
            Some((0..values.len()).map(at).collect())
        }
    }
}

#[cfg(not(feature = "hdf5"))]
mod imp {
    use std::path::Path;

    use super::FORMAT;
    use crate::{Dhp19Cnn, NnError};

    pub(super) fn filled(_: Dhp19Cnn, _: Vec<u8>, path: &Path) -> Result<Dhp19Cnn, NnError> {
        Err(NnError::Unreadable {
            path: path.to_owned(),
            format: FORMAT,
            reason: "the program reads HDF5 only if it is built with the feature `hdf5`".to_owned(),
        })
    }
}
