//! The devices of this machine, for `evpose info --devices`.

use evpose_nn::{Availability, DeviceKind};

/// A line for each device that networks can be computed on, as `--device` takes it, and for each kind
/// that is not there, with the reason.
pub(super) fn describe() -> String {
    let mut lines = Vec::new();
    for kind in DeviceKind::ALL {
        let mut line = |name: &str, text: &str| lines.push(format!("{name:<10}{text}"));
        match Availability::of(kind) {
            Availability::NotBuilt => {
                let feature = kind.name();
                line(feature, &format!("not in this build: rebuild with `--features {feature}`"));
            }
            Availability::Missing { reason } => line(kind.name(), &format!("none: {reason}")),
            Availability::Adapters(adapters) => {
                // The CPU is one device, whatever number of cores it has.
                let has_index = matches!(kind, DeviceKind::Wgpu { .. } | DeviceKind::Cuda { .. });
                for (index, adapter) in adapters.iter().enumerate() {
                    let name = if has_index { format!("{kind}:{index}") } else { kind.to_string() };
                    line(&name, &format!("{} ({})", adapter.name, adapter.details));
                }
            }
        }
    }
    lines.push(
        "Without an index, wgpu is the fastest of its list by its own rules, cuda the first."
            .into(),
    );
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_line_and_what_is_not_built_names_its_feature() {
        let text = describe();
        for kind in DeviceKind::ALL {
            assert!(text.lines().any(|line| line.starts_with(kind.name())), "{text}");
        }
        let is_left_out = text.contains("rebuild with `--features ndarray`");
        assert_eq!(is_left_out, Availability::of(DeviceKind::Ndarray) == Availability::NotBuilt);
    }
}
