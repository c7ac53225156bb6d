//! A backbone whose type is known to another crate only.
//!
//! Burn's traits are generic over visitors and mappers, so they make no trait objects. [`AnyNet`]
//! says the same with objects, with parameters of any rank as [`Any`].

use std::any::Any;
use std::fmt::Debug;

use burn::module::{Devices, Flag, Module, ModuleMapper, ModuleVisitor, Param};
use burn::tensor::{Bool, Device, Int, Tensor};

use super::BackboneNet;
use crate::graph::TracedNode;
use crate::initializer::Initializer;
use crate::net_ops::NetOps;
use crate::ops::Blocked;
use crate::parameters::Slot;

/// A [`BackboneNet`] as an object: see there and in [`Module`].
pub(super) trait AnyNet: Debug + Send + Sync {
    fn boxed_clone(&self) -> Box<dyn AnyNet>;
    /// From a `NetOps` to its `Vector`.
    fn forward(&self, images: Box<dyn Any>) -> Box<dyn Any>;
    fn initializer(&self, slot: &Slot) -> Initializer;
    fn torchvision_path(&self, path: &str) -> String;
    fn collect_devices(&self, devices: Devices) -> Devices;
    fn fork(self: Box<Self>, device: &Device) -> Box<dyn AnyNet>;
    fn to_device(self: Box<Self>, device: &Device) -> Box<dyn AnyNet>;
    fn train(self: Box<Self>) -> Box<dyn AnyNet>;
    fn valid(&self) -> Box<dyn AnyNet>;
    fn materialize(self: Box<Self>) -> Box<dyn AnyNet>;
    fn visit(&self, visitor: &mut dyn AnyVisitor);
    fn map(self: Box<Self>, mapper: &mut dyn AnyMapper) -> Box<dyn AnyNet>;
}

impl<N: BackboneNet + Sync + 'static> AnyNet for N {
    fn boxed_clone(&self) -> Box<dyn AnyNet> {
        Box::new(self.clone())
    }

    fn forward(&self, images: Box<dyn Any>) -> Box<dyn Any> {
        let images = match forward_of::<_, Tensor<4>>(self, images) {
            Ok(output) => return output,
            Err(images) => images,
        };
        // A trait object cannot be generic: the kinds of tensors that there are, are tried in turn.
        let images = match forward_of::<_, Blocked>(self, images) {
            Ok(output) => return output,
            Err(images) => images,
        };
        let output = forward_of::<_, TracedNode>(self, images);
        output.expect("networks compute with tensors or blocks, or are traced")
    }

    fn initializer(&self, slot: &Slot) -> Initializer {
        BackboneNet::initializer(self, slot)
    }

    fn torchvision_path(&self, path: &str) -> String {
        BackboneNet::torchvision_path(self, path)
    }

    fn collect_devices(&self, devices: Devices) -> Devices {
        Module::collect_devices(self, devices)
    }

    fn fork(self: Box<Self>, device: &Device) -> Box<dyn AnyNet> {
        Box::new(Module::fork(*self, device))
    }

    fn to_device(self: Box<Self>, device: &Device) -> Box<dyn AnyNet> {
        Box::new(Module::to_device(*self, device))
    }

    fn train(self: Box<Self>) -> Box<dyn AnyNet> {
        Box::new(Module::train(*self))
    }

    fn valid(&self) -> Box<dyn AnyNet> {
        Box::new(Module::valid(self))
    }

    fn materialize(self: Box<Self>) -> Box<dyn AnyNet> {
        Box::new(Module::materialize(*self))
    }

    fn visit(&self, visitor: &mut dyn AnyVisitor) {
        Module::visit(self, &mut ToAny(visitor));
    }

    fn map(self: Box<Self>, mapper: &mut dyn AnyMapper) -> Box<dyn AnyNet> {
        Box::new(Module::map(*self, &mut ToAny(mapper)))
    }
}

/// The output for images of type `N`; images of another type come back.
fn forward_of<B: BackboneNet, N: NetOps>(
    network: &B,
    images: Box<dyn Any>,
) -> Result<Box<dyn Any>, Box<dyn Any>> {
    let images = images.downcast::<N>()?;
    Ok(Box::new(network.forward(*images)))
}

/// A [`ModuleVisitor`] as an object. Parameters are `Param<Tensor<D, _>>`, with `D` beside them.
pub(super) trait AnyVisitor {
    fn enter(&mut self, name: &str, container: &str);
    fn exit(&mut self, name: &str, container: &str);
    fn float(&mut self, rank: usize, param: &dyn Any);
    fn int(&mut self, rank: usize, param: &dyn Any);
    fn bool(&mut self, rank: usize, param: &dyn Any);
    fn flag(&mut self, flag: &Param<Flag>);
}

/// A [`ModuleMapper`] as an object. Parameters are `Param<Tensor<D, _>>`, with `D` beside them.
pub(super) trait AnyMapper {
    fn enter(&mut self, name: &str, container: &str);
    fn exit(&mut self, name: &str, container: &str);
    fn float(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any>;
    fn int(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any>;
    fn bool(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any>;
    fn flag(&mut self, flag: Param<Flag>) -> Param<Flag>;
}

/// Passes what Burn's generic traits say on to an object.
struct ToAny<'a, T: ?Sized>(&'a mut T);

impl ModuleVisitor for ToAny<'_, dyn AnyVisitor + '_> {
    fn enter_module(&mut self, name: &str, container: &str) {
        self.0.enter(name, container);
    }

    fn exit_module(&mut self, name: &str, container: &str) {
        self.0.exit(name, container);
    }

    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0.float(D, param);
    }

    fn visit_int<const D: usize>(&mut self, param: &Param<Tensor<D, Int>>) {
        self.0.int(D, param);
    }

    fn visit_bool<const D: usize>(&mut self, param: &Param<Tensor<D, Bool>>) {
        self.0.bool(D, param);
    }

    fn visit_flag(&mut self, flag: &Param<Flag>) {
        self.0.flag(flag);
    }
}

impl ModuleMapper for ToAny<'_, dyn AnyMapper + '_> {
    fn enter_module(&mut self, name: &str, container: &str) {
        self.0.enter(name, container);
    }

    fn exit_module(&mut self, name: &str, container: &str) {
        self.0.exit(name, container);
    }

    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        typed(self.0.float(D, Box::new(param)))
    }

    fn map_int<const D: usize>(&mut self, param: Param<Tensor<D, Int>>) -> Param<Tensor<D, Int>> {
        typed(self.0.int(D, Box::new(param)))
    }

    fn map_bool<const D: usize>(
        &mut self,
        param: Param<Tensor<D, Bool>>,
    ) -> Param<Tensor<D, Bool>> {
        typed(self.0.bool(D, Box::new(param)))
    }

    fn map_flag(&mut self, flag: Param<Flag>) -> Param<Flag> {
        self.0.flag(flag)
    }
}

/// Passes what an object says on to Burn's generic traits.
pub(super) struct FromAny<'a, T>(pub(super) &'a mut T);

/// Evaluates an expression with the rank of a parameter as the constant `$D`.
macro_rules! by_rank {
    ($rank:ident, $D:ident => $call:expr) => {
        by_rank!(@ $rank, $D, $call, 1 2 3 4 5 6)
    };
    (@ $rank:ident, $D:ident, $call:expr, $($value:literal)+) => {
        match $rank {
            $($value => {
                const $D: usize = $value;
                $call
            })+
            rank => panic!("parameters of networks have 1 to 6 dimensions, not {rank}"),
        }
    };
}

impl<V: ModuleVisitor> AnyVisitor for FromAny<'_, V> {
    fn enter(&mut self, name: &str, container: &str) {
        self.0.enter_module(name, container);
    }

    fn exit(&mut self, name: &str, container: &str) {
        self.0.exit_module(name, container);
    }

    fn float(&mut self, rank: usize, param: &dyn Any) {
        by_rank!(rank, D => self.0.visit_float::<D>(borrowed(param)));
    }

    fn int(&mut self, rank: usize, param: &dyn Any) {
        by_rank!(rank, D => self.0.visit_int::<D>(borrowed(param)));
    }

    fn bool(&mut self, rank: usize, param: &dyn Any) {
        by_rank!(rank, D => self.0.visit_bool::<D>(borrowed(param)));
    }

    fn flag(&mut self, flag: &Param<Flag>) {
        self.0.visit_flag(flag);
    }
}

impl<M: ModuleMapper> AnyMapper for FromAny<'_, M> {
    fn enter(&mut self, name: &str, container: &str) {
        self.0.enter_module(name, container);
    }

    fn exit(&mut self, name: &str, container: &str) {
        self.0.exit_module(name, container);
    }

    fn float(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any> {
        by_rank!(rank, D => Box::new(self.0.map_float::<D>(typed(param))))
    }

    fn int(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any> {
        by_rank!(rank, D => Box::new(self.0.map_int::<D>(typed(param))))
    }

    fn bool(&mut self, rank: usize, param: Box<dyn Any>) -> Box<dyn Any> {
        by_rank!(rank, D => Box::new(self.0.map_bool::<D>(typed(param))))
    }

    fn flag(&mut self, flag: Param<Flag>) -> Param<Flag> {
        self.0.map_flag(flag)
    }
}

const MISMATCH: &str = "the method and the rank say the type";

fn borrowed<P: Any>(param: &dyn Any) -> &P {
    param.downcast_ref().expect(MISMATCH)
}

pub(super) fn typed<P: Any>(param: Box<dyn Any>) -> P {
    *param.downcast().expect(MISMATCH)
}
