//! The weights of a module by path: to list, to read, and to fill them.
//!
//! A path joins field names and positions with dots, `backbone.stages.0.1.first.conv.weight`; the
//! names of enum variants are left out. Trained parameters and the running statistics of batch
//! normalisation are treated alike.

use std::collections::HashMap;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::tensor::{Tensor, TensorData};

/// One tensor of a module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slot {
    /// The path, field names joined by dots.
    pub path: String,
    /// The type of the layer that holds it: `Conv2d`, `BatchNorm`, `Linear`.
    pub layer: String,
    /// Extents of the tensor, outermost first.
    pub shape: Vec<usize>,
}

impl Slot {
    /// The last part of the path: `weight`, `bias`, `gamma`, `beta`, `running_mean`, `running_var`.
    pub fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    /// Whether it is trained by gradients; running statistics are not.
    pub fn is_trained(&self) -> bool {
        !self.name().starts_with("running_")
    }

    /// Whether this is the weight of a fully connected layer, `[inputs, outputs]` here and
    /// `[outputs, inputs]` in PyTorch.
    pub fn is_linear_weight(&self) -> bool {
        self.layer == "Linear" && self.name() == "weight"
    }
}

/// Every tensor of `module` in the order of its fields.
pub fn slots<M: Module>(module: &M) -> Vec<Slot> {
    List::of(module, false).into_iter().map(|(_, slot, _)| slot).collect()
}

/// The path of every parameter that training changes, by its id.
pub(crate) fn paths<M: Module>(module: &M) -> HashMap<ParamId, String> {
    List::of(module, false).into_iter().map(|(id, slot, _)| (id, slot.path)).collect()
}

/// The number of trainable parameters, as papers count them.
pub fn trained_count<M: Module>(module: &M) -> usize {
    let trained = slots(module).into_iter().filter(Slot::is_trained);
    trained.map(|slot| slot.shape.iter().product::<usize>()).sum()
}

/// Every tensor of `module` with its values in row-major order.
///
/// Running statistics are those of the last training step: Burn keeps the newest update of each
/// thread aside until the next forward pass, and a plain visit would miss it.
pub fn read<M: Module>(module: &M) -> Vec<(Slot, Vec<f32>)> {
    let tensors = List::of(&module.valid(), true);
    tensors.into_iter().map(|(_, slot, values)| (slot, values)).collect()
}

/// Gives every tensor of `module` the values of `source`, in row-major order.
///
/// Each parameter's id becomes a hash of its path: an optimiser's state, which is kept by id,
/// then fits a network built or loaded anew.
///
/// # Panics
/// If `source` returns another number of values than the slot holds.
pub fn fill<M: Module>(module: M, mut source: impl FnMut(&Slot) -> Vec<f32>) -> M {
    fill_with_data(module, |slot| TensorData::new(source(slot), slot.shape.clone()))
}

/// [`fill`] with the tensors' data, of any shape: on the CPU a tensor keeps the memory of its data, such as
/// a mapped file, until it is written to.
pub(crate) fn fill_with_data<M: Module>(module: M, source: impl FnMut(&Slot) -> TensorData) -> M {
    module.map(&mut Fill { position: Position::default(), source })
}

/// The network with running variances that match its weights, for comparisons of untrained
/// networks.
///
/// Initial running variances are 1, with which the activations of some networks vanish within a few
/// layers: outputs of two implementations would then agree whatever either computes.
pub fn with_matched_variances<M: Module>(network: M) -> M {
    let mut values = read(&network).into_iter();
    let mut variance = 1.0;
    fill(network, |slot| {
        let (_, values) = values.next().unwrap_or_else(|| unreachable!("every slot is read"));
        match slot.name() {
            "weight" => {
                // The variance of a sum whose inputs are half set to zero by a ReLU.
                let squares: f32 = values.iter().map(|value| value * value).sum();
                variance = squares / (2 * slot.shape[0]) as f32;
                values
            }
            "running_var" => vec![variance; values.len()],
            _ => values,
        }
    })
}

/// The network with values of mean 3 and deviation 0.25 behind its normalisations, for comparisons of gradients.
///
/// A value next to the kink of a ReLU falls on either side of it by how sums were rounded, and changes all gradients
/// before it by per cents. Here 0 and 6, the other kink of ReLU6, are twelve deviations away.
pub fn away_from_kinks<M: Module>(network: M) -> M {
    let mut values = read(&network).into_iter();
    fill(network, |slot| {
        let (_, values) = values.next().unwrap_or_else(|| unreachable!("every slot is read"));
        match slot.name() {
            "beta" => vec![3.0; values.len()],
            "gamma" => vec![0.25; values.len()],
            _ => values,
        }
    })
}

/// The position of a traversal among nested modules.
#[derive(Default)]
struct Position {
    names: Vec<String>,
    layers: Vec<String>,
}

impl Position {
    fn enter(&mut self, name: &str, container: &str) {
        self.layers.push(container.trim_start_matches("Struct:").to_owned());
        self.names.push(if is_enum(container) { String::new() } else { name.to_owned() });
    }

    fn exit(&mut self) {
        self.layers.pop();
        self.names.pop();
    }

    fn slot(&self, shape: &[usize]) -> Slot {
        let names: Vec<_> =
            self.names.iter().map(String::as_str).filter(|n| !n.is_empty()).collect();
        Slot {
            path: names.join("."),
            layer: self.layers.last().cloned().unwrap_or_default(),
            shape: shape.to_vec(),
        }
    }
}

fn is_enum(container: &str) -> bool {
    container.starts_with("Enum:")
}

/// The 64-bit FNV-1a hash of a path.
fn id_of(path: &str) -> ParamId {
    let hash = path.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    ParamId::from(hash)
}

/// Ids and slots of all tensors, with their values where `reads_values`.
struct List {
    position: Position,
    reads_values: bool,
    tensors: Vec<(ParamId, Slot, Vec<f32>)>,
}

impl List {
    fn of<M: Module>(module: &M, reads_values: bool) -> Vec<(ParamId, Slot, Vec<f32>)> {
        let mut list = Self { position: Position::default(), reads_values, tensors: Vec::new() };
        module.visit(&mut list);
        list.tensors
    }
}

impl ModuleVisitor for List {
    fn enter_module(&mut self, name: &str, container: &str) {
        self.position.enter(name, container);
    }

    fn exit_module(&mut self, _name: &str, _container: &str) {
        self.position.exit();
    }

    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        // The shape of a parameter that is not initialised yet is known without its values.
        let slot = self.position.slot(&param.lazy_shape());
        let values = self.reads_values.then(|| param.val().into_data().iter::<f32>().collect());
        self.tensors.push((param.id, slot, values.unwrap_or_default()));
    }
}

struct Fill<F> {
    position: Position,
    source: F,
}

impl<F: FnMut(&Slot) -> TensorData> ModuleMapper for Fill<F> {
    fn enter_module(&mut self, name: &str, container: &str) {
        self.position.enter(name, container);
    }

    fn exit_module(&mut self, _name: &str, _container: &str) {
        self.position.exit();
    }

    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let (_, old, mapper) = param.consume();
        let slot = self.position.slot(&old.dims());
        let (bytes, _, dtype) = (self.source)(&slot).into_parts();
        let data = TensorData::from_bytes(bytes, old.dims(), dtype);
        let new = Tensor::from_data(data, &old.device()).set_require_grad(old.is_require_grad());
        Param::from_mapped_value(id_of(&slot.path), new, mapper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::{Linear, LinearConfig};
    use burn::tensor::Device;

    fn linear() -> Linear {
        LinearConfig::new(3, 2).init(&Device::flex())
    }

    #[test]
    fn values_filled_in_are_read_back() {
        let filled = fill(linear(), |slot| {
            let first = if slot.is_linear_weight() { 0 } else { 10 };
            (first..first + slot.shape.iter().product::<usize>()).map(|i| i as f32).collect()
        });
        let read = read(&filled);
        assert_eq!(read[0].0.path, "weight");
        assert_eq!(read[0].0.layer, "Linear");
        assert_eq!(read[0].1, [0., 1., 2., 3., 4., 5.]);
        assert_eq!(read[1].1, [10., 11.]);
        assert_eq!(slots(&filled), read.into_iter().map(|(slot, _)| slot).collect::<Vec<_>>());
    }

    #[test]
    fn two_networks_of_one_layout_share_their_ids() {
        let zeros = |slot: &Slot| vec![0.0; slot.shape.iter().product()];
        let (one, two) = (fill(linear(), zeros), fill(linear(), zeros));
        assert_eq!(one.weight.id, two.weight.id);
        assert!(Some(one.weight.id) != one.bias.map(|bias| bias.id));
    }
}
