//! The names of the network's tensors in the published PyTorch checkpoints.

use crate::backbone::resnet::torchvision_path;

/// The model inside the Lightning module.
const MODEL: &str = "_model";
/// Layers of the ResNet by their position in the published list: behind the stem, its
/// normalisation, ReLU and pooling.
const FIRST_STAGE: usize = 4;

/// `xy.0.down.1.first.conv.weight` is `_model.xy_hm_cnns.0.down_layers.1.module.0.weight`.
pub(super) fn pytorch(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    let name = match *parts.as_slice() {
        ["stem", "conv", name] => format!("in_cnn.0.{}", torch_name(name)),
        ["stem", _, name] => format!("in_cnn.1.{}", torch_name(name)),
        ["features", stage, ..] => {
            let stage: usize = stage.parse().unwrap_or_default();
            let behind = path.splitn(3, '.').last().unwrap_or_default();
            // The published encoder is cut out of torchvision's ResNet, so that its inner names are
            // the same.
            let layer = torchvision_path(&format!("stages.0.{behind}"));
            let layer = layer.strip_prefix("layer1.").unwrap_or(&layer).to_owned();
            let (layer, name) = layer.rsplit_once('.').unwrap_or((&layer, ""));
            format!("in_cnn.{}.{layer}.{}", FIRST_STAGE + stage, torch_name(name))
        }
        ["combiners", index, ref rest @ ..] => {
            format!("hm_combiners.{index}.combine_block.{}", block(rest))
        }
        [plane, stage, ref rest @ ..] => format!("{plane}_hm_cnns.{stage}.{}", plane_layer(rest)),
        _ => path.to_owned(),
    };
    format!("{MODEL}.{name}")
}

fn plane_layer(parts: &[&str]) -> String {
    // The published code has these three parts in one list.
    let behind =
        |index: &str, first: usize| index.parse::<usize>().map_or(first, |index| first + index);
    match *parts {
        ["down", index, ref rest @ ..] => format!("down_layers.{index}.{}", block(rest)),
        ["middle", index, ref rest @ ..] => format!("up_layers.{index}.{}", block(rest)),
        ["upsampling", ref rest @ ..] => format!("up_layers.2.{}", block(rest)),
        ["up", index, ref rest @ ..] => {
            format!("up_layers.{}.{}", behind(index, 3), block(rest))
        }
        _ => parts.join("."),
    }
}

fn block(parts: &[&str]) -> String {
    // Layer 2 of the published `Sequential` is a ReLU, which has no weights.
    match *parts {
        ["first", "conv", name] => format!("module.0.{}", torch_name(name)),
        ["first", _, name] => format!("module.1.{}", torch_name(name)),
        ["second", "conv", name] => format!("module.3.{}", torch_name(name)),
        ["second", _, name] => format!("module.4.{}", torch_name(name)),
        ["shortcut", "conv", name] => format!("shortcut.0.{}", torch_name(name)),
        ["shortcut", _, name] => format!("shortcut.1.{}", torch_name(name)),
        _ => parts.join("."),
    }
}

fn torch_name(name: &str) -> &str {
    match name {
        "gamma" => "weight",
        "beta" => "bias",
        _ => name,
    }
}
