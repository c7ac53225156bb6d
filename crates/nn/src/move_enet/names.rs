//! The names of the network's tensors in PyTorch.
//!
//! In the published definition, layers are counted in sequences in which activations count too.

/// Modules of the inverted residuals, finest level first.
const STAGES: [&str; 6] =
    ["features1.2", "features2", "features3", "features4.0", "features4.1", "features4.2"];

/// `backbone.stages.1.repeated.depthwise.norm.gamma` is `backbone.features2.conv2.4.weight`.
pub(super) fn pytorch(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    // A name without a layer is no tensor's.
    let (Some((name, layer)), true) = (parts.split_last(), parts.len() > 1) else {
        return path.to_owned();
    };
    let name = match *name {
        "gamma" => "weight",
        "beta" => "bias",
        other => other,
    };
    // In `Sequential`, convolution, normalisation and ReLU are numbered through.
    let after = |first: usize, kind: &str| first + usize::from(kind == "norm");
    let layer = match *layer {
        ["backbone", "stem", kind] => format!("backbone.features1.0.{}", after(0, kind)),
        ["backbone", "separable", "depthwise", kind] => {
            format!("backbone.features1.1.{}", after(0, kind))
        }
        ["backbone", "separable", "mix", kind] => {
            format!("backbone.features1.1.{}", after(3, kind))
        }
        ["backbone", "stages", index, pass, layer, kind] => {
            // Stages have names in the published code, not indices.
            let stage = index.parse().ok().and_then(|index: usize| STAGES.get(index));
            let pass = if pass == "first" { "conv1" } else { "conv2" };
            let first = match layer {
                "expand" => 0,
                "depthwise" => 3,
                _ => 6,
            };
            format!("backbone.{}.{pass}.{}", stage.unwrap_or(&index), after(first, kind))
        }
        ["backbone", "widen", kind] => format!("backbone.features4.3.{}", after(0, kind)),
        ["backbone", "narrow"] => "backbone.features4.4".to_owned(),
        ["backbone", "laterals", index] => format!("backbone.conv{}", one_more(index)),
        ["backbone", "upsamplings", index, "depthwise"] => {
            format!("backbone.upsample{}.0", one_more(index))
        }
        ["backbone", "upsamplings", index, _, kind] => {
            format!("backbone.upsample{}.2.{}", one_more(index), after(0, kind))
        }
        ["backbone", "smooth", layer, kind] => {
            format!("backbone.conv4.{}", after(if layer == "mix" { 2 } else { 0 }, kind))
        }
        ["header", head, "separable", layer, kind] => {
            let first = if layer == "mix" { 2 } else { 0 };
            format!("header.header_{head}.0.{}", after(first, kind))
        }
        ["header", head, "last"] => format!("header.header_{head}.1"),
        ref other => other.join("."),
    };
    format!("{layer}.{name}")
}

fn one_more(index: &str) -> usize {
    index.parse::<usize>().map_or(0, |index| index + 1)
}
