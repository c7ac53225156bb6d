//! The adapters that Burn's wgpu device computes on.
//!
//! # Source
//! `settle` of cubecl-wgpu 0.11.3: the first graphics API that has a GPU, or else the first that has
//! anything. `Device::enumerate` lists the adapters of that API in the same order.

use std::pin::pin;
use std::sync::OnceLock;
use std::task::{Context, Poll, Waker};

use wgpu::{AdapterInfo, Backend, DeviceType, Instance, InstanceDescriptor};

use super::{Adapter, Availability};

/// Graphics APIs, the preferred one first.
const APIS: &[Backend] = if cfg!(target_os = "macos") {
    &[Backend::Metal]
} else {
    &[Backend::Vulkan, Backend::Dx12, Backend::Gl]
};

/// The adapters, asked once: they do not change while the program runs.
pub(super) fn availability() -> Availability {
    static ADAPTERS: OnceLock<Vec<AdapterInfo>> = OnceLock::new();
    let adapters = ADAPTERS.get_or_init(settled);
    if adapters.is_empty() {
        return Availability::Missing { reason: reason() };
    }
    Availability::Adapters(adapters.iter().map(adapter).collect())
}

/// The adapters of the API that Burn settles on.
fn settled() -> Vec<AdapterInfo> {
    let mut software = Vec::new();
    for api in APIS {
        let adapters = adapters_of(*api);
        // A later interface with a GPU is better than an earlier one in software.
        if adapters.iter().any(|adapter| adapter.device_type != DeviceType::Cpu) {
            return adapters;
        }
        if software.is_empty() {
            software = adapters;
        }
    }
    software
}

fn adapters_of(api: Backend) -> Vec<AdapterInfo> {
    let instance = Instance::new(InstanceDescriptor {
        backends: api.into(),
        ..InstanceDescriptor::new_without_display_handle()
    });
    let mut listing = pin!(instance.enumerate_adapters(api.into()));
    // Outside of browsers, the list is ready at once.
    match listing.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(adapters) => adapters.iter().map(wgpu::Adapter::get_info).collect(),
        Poll::Pending => Vec::new(),
    }
}

fn adapter(info: &AdapterInfo) -> Adapter {
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => "discrete GPU",
        DeviceType::IntegratedGpu => "integrated GPU",
        DeviceType::VirtualGpu => "virtual GPU",
        DeviceType::Cpu => "software on the CPU",
        DeviceType::Other => "of an unknown type",
    };
    let mut details = format!("{kind}, {:?}", info.backend);
    for text in [&info.driver, &info.driver_info] {
        if !text.is_empty() {
            details += ", ";
            details += text;
        }
    }
    Adapter { name: info.name.clone(), details }
}

fn reason() -> String {
    if cfg!(target_os = "linux") {
        return super::drivers::missing_vulkan();
    }
    let apis: Vec<String> = APIS.iter().map(|api| format!("{api:?}")).collect();
    format!("no adapter of {}: install the GPU's driver", apis.join(", "))
}
