//! Weights of the published PyTorch networks: `.pth` files and Lightning's `.ckpt`.
//!
//! Both containers are read: the zip archive of PyTorch 1.6 and later, and the bare pickles of
//! earlier versions, in which the published checkpoints are written. Nothing in a pickle is
//! executed, and whatever else a checkpoint holds beside the weights is passed over. The weights
//! may stand at the top or, as Lightning puts them, under `state_dict`.

mod container;
mod view;

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use burn::module::Module;
use burn::tensor::Device;

use super::strict::{Layout, Stored, fill_strictly};
use crate::joint_order::NETWORK_FROM_DHP19;
use crate::parameters::Slot;
use crate::{
    HandRegressor, HandRegressorConfig, LiftMono, LiftMonoConfig, MoveEnet, MoveEnetConfig, NnError,
};
use container::Container;
use view::View;

const FORMAT: &str = "PyTorch";
/// The key of the weights in a checkpoint of Lightning.
const LIGHTNING_KEY: &str = "state_dict";
/// Training steps seen by a batch normalisation, which only PyTorch counts.
const STEP_COUNT: &str = ".num_batches_tracked";

/// Reads the weights of a network of shape `config` from a PyTorch file.
///
/// # Errors
/// [`NnError::Io`] if the file cannot be read, [`NnError::Unreadable`] if it is damaged or of
/// another kind, [`NnError::Mismatch`] for weights of another network, and those of
/// [`HandRegressorConfig::init`].
pub fn load_pytorch(
    path: &Path,
    config: &HandRegressorConfig,
    device: &Device,
) -> Result<HandRegressor, NnError> {
    read(path, config.zeros(device)?, HandRegressor::pytorch_name)
}

/// Reads the weights of a network of shape `config` from a PyTorch file, in the form of the
/// published 13-joint checkpoints: inverted residuals share the weights of their repetitions.
///
/// # Errors
/// As [`load_pytorch`].
pub fn load_move_enet(
    path: &Path,
    config: &MoveEnetConfig,
    device: &Device,
) -> Result<MoveEnet, NnError> {
    read(path, config.zeros(device)?, MoveEnet::pytorch_name)
}

/// Reads the weights of a network of shape `config` from a PyTorch file as LiftMono-HPE's published
/// code writes them: checkpoints of Lightning. The joints are brought into the order of our
/// networks.
///
/// # Errors
/// As [`load_pytorch`].
pub fn load_lift_mono(
    path: &Path,
    config: &LiftMonoConfig,
    device: &Device,
) -> Result<LiftMono, NnError> {
    let network = read(path, config.zeros(device)?, LiftMono::pytorch_name)?;
    // Another count of joints means another data set, whose order is not known here.
    let is_dhp19s = config.joints == NETWORK_FROM_DHP19.len();
    Ok(if is_dhp19s { network.with_joint_order(&NETWORK_FROM_DHP19) } else { network })
}

fn read<M: Module>(path: &Path, network: M, name: fn(&M, &Slot) -> String) -> Result<M, NnError> {
    let layout = PyTorch { network: network.clone(), name };
    let bytes =
        std::fs::read(path).map_err(|source| NnError::Io { path: path.to_owned(), source })?;
    let container = Container::read(bytes).map_err(|error| NnError::Unreadable {
        path: path.to_owned(),
        format: FORMAT,
        reason: error.to_string(),
    })?;
    fill_strictly(network, &layout, state_dict(container), path, FORMAT)
}

/// The tensors of the state dictionary by name, those that are no weights left out.
fn state_dict(container: Container) -> BTreeMap<String, Stored> {
    let container = Rc::new(container);
    let pickle = &container.pickle;
    // Checkpoints of Lightning hold the weights below a key; `torch.save` of a model, directly.
    let weights = pickle.get(pickle.root(), LIGHTNING_KEY).unwrap_or(pickle.root());
    let tensors = pickle.entries(weights).iter().filter_map(|&(name, tensor)| {
        let name = pickle.text(name).filter(|name| !name.ends_with(STEP_COUNT))?;
        let (view, container) = (View::from_pickle(pickle, tensor)?, Rc::clone(&container));
        let shape = view.shape.clone();
        let read = move || view.values(&container);
        Some((name.to_owned(), Stored::new(shape, read)))
    });
    tensors.collect()
}

/// PyTorch's names; weights of fully connected layers as `[outputs, inputs]`.
struct PyTorch<M> {
    network: M,
    /// The name of a tensor in the published checkpoints.
    name: fn(&M, &Slot) -> String,
}

impl<M: Module> Layout for PyTorch<M> {
    fn name(&self, slot: &Slot) -> String {
        (self.name)(&self.network, slot)
    }

    fn shape(&self, slot: &Slot) -> Vec<usize> {
        let mut shape = slot.shape.clone();
        if slot.is_linear_weight() {
            shape.reverse();
        }
        shape
    }

    fn reordered(&self, slot: &Slot, values: &[f32]) -> Option<Vec<f32>> {
        let [inputs, outputs] = *slot.shape.as_slice() else { return None };
        slot.is_linear_weight().then(|| {
            (0..inputs)
                .flat_map(|input| values[input..].iter().step_by(inputs).take(outputs).copied())
                .collect()
        })
    }
}
