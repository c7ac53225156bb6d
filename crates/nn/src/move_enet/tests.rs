//! Counts, names, initial weights and the graph of the network.

use super::*;
use crate::graph::Operation;
use crate::parameters::{read, slots, trained_count};

fn small() -> MoveEnetConfig {
    MoveEnetConfig { joints: 5, width: 0.01, expansion: 2 }
}

#[test]
fn parameters_are_as_many_as_published() {
    let published = MoveEnetConfig::default();
    let network = published.zeros(&Device::flex()).unwrap();
    assert_eq!(trained_count(&network), 2_201_106);
    let seventeen = MoveEnetConfig { joints: 17, ..published };
    assert_eq!(trained_count(&seventeen.zeros(&Device::flex()).unwrap()), 2_203_046);
    assert_eq!(trained_count(&network.backbone), 2_183_664);
    let of = |part: &str| {
        let slots = slots(&network).into_iter();
        let slots = slots.filter(|slot| slot.is_trained() && slot.path.starts_with(part));
        slots.map(|slot| slot.shape.iter().product::<usize>()).sum::<usize>()
    };
    let heads =
        ["heatmaps", "centers", "regs", "offsets"].map(|head| of(&format!("header.{head}")));
    assert_eq!(heads, [4_021, 2_857, 5_282, 5_282]);
    assert_eq!(of("backbone.stages.5.repeated"), 627_520);
}

/// The tensors of PyTorch's state dictionary but `num_batches_tracked`, `name shape`, sorted.
const PYTORCH: &str = include_str!("../../tests/data/move_enet_names.txt");

#[test]
fn names_and_shapes_are_those_of_pytorch() {
    let network = MoveEnetConfig::default().zeros(&Device::flex()).unwrap();
    let name = |slot: &Slot| {
        let shape: Vec<_> = slot.shape.iter().map(usize::to_string).collect();
        format!("{} {}", network.pytorch_name(slot), shape.join("x"))
    };
    let mut ours: Vec<_> = slots(&network).iter().map(name).collect();
    ours.sort();
    assert_eq!(ours, PYTORCH.lines().collect::<Vec<_>>());
    assert_eq!(ours.len(), 337 - 52);
}

#[test]
fn a_graph_has_every_layer_as_often_as_it_runs() {
    let network = small().init(3, &Device::flex()).unwrap();
    let graph = network.graph();
    let times = |layer: &str| graph.nodes.iter().filter(|node| node.name == layer).count();
    for slot in slots(&network).iter().filter(|slot| slot.name() == "weight") {
        let layer = slot.path.strip_suffix(".weight").unwrap();
        let layer = layer.strip_suffix(".conv").unwrap_or(layer);
        let repeated = layer.split_once(".repeated.").map(|(stage, _)| stage);
        let expected = match repeated {
            Some("backbone.stages.5") => 0,
            Some("backbone.stages.0") => 1,
            Some("backbone.stages.2") => 3,
            Some(_) => 2,
            None => 1,
        };
        assert_eq!(times(layer), expected, "{layer}");
    }
    assert_eq!([times("upsample"), times("sigmoid"), times("affine")], [3, 2, 1]);
    let channels: Vec<_> = graph.outputs.iter().map(|id| graph.nodes[*id].channels).collect();
    assert_eq!(channels, [5, 1, 10, 10]);
    let outputs = graph.outputs.iter().map(|id| &graph.nodes[*id].operation);
    let is_sigmoid: Vec<_> = outputs.map(|operation| *operation == Operation::Sigmoid).collect();
    assert_eq!(is_sigmoid, [true, true, false, false]);
}

#[test]
fn initial_weights_are_as_published() {
    let network = MoveEnetConfig::default().init(3, &Device::flex()).unwrap();
    for (slot, values) in read(&network) {
        if slot.layer == "BatchNorm" || slot.name() == "bias" {
            let one = matches!(slot.name(), "gamma" | "running_var");
            assert!(values.iter().all(|&value| value == f32::from(one)), "{}", slot.path);
            continue;
        }
        let fan_in: usize = slot.shape[1..].iter().product();
        let square: f64 = values.iter().map(|&value| f64::from(value).powi(2)).sum();
        let deviation = (square / values.len() as f64).sqrt();
        // Six standard errors of a deviation.
        let tolerance = 6.0 / (2.0 * values.len() as f64).sqrt();
        let expected = (2.0 / fan_in as f64).sqrt();
        assert!((deviation / expected - 1.0).abs() < tolerance, "{}", slot.path);
    }
}

#[test]
fn all_weights_matter_but_those_of_a_residual_that_never_runs() {
    let device = Device::flex();
    let network = small().init(3, &device).unwrap();
    let images = Tensor::<4>::ones([1, 3, 64, 32], &device) * 200.0;
    let without = |part: &str| -> Vec<f32> {
        let mut weights = read(&network).into_iter();
        let changed = crate::parameters::fill(network.clone(), |slot| {
            let (_, values) = weights.next().unwrap();
            // Without their gammas, the layers of a part have no output.
            let is_off = slot.path.starts_with(part) && slot.name() == "gamma";
            if is_off { vec![0.0; values.len()] } else { values }
        });
        changed.forward(images.clone()).regs.into_data().iter().collect()
    };
    let whole = without("nothing");
    for stage in 0..5 {
        assert!(without(&format!("backbone.stages.{stage}.repeated")) != whole, "{stage}");
    }
    assert_eq!(without("backbone.stages.5.repeated"), whole);
}

#[test]
fn impossible_shapes_are_refused() {
    let error =
        |config: MoveEnetConfig| config.zeros(&Device::flex()).map(|_| ()).unwrap_err().to_string();
    assert_eq!(error(MoveEnetConfig { joints: 0, ..small() }), "`joints` must be at least 1");
    let no_hidden = MoveEnetConfig { expansion: 0, ..small() };
    assert_eq!(error(no_hidden), "`expansion` must be at least 1");
    for width in [0.0, -1.0, f32::NAN, 1e9] {
        assert!(error(MoveEnetConfig { width, ..small() }).starts_with("`width` must"), "{width}");
    }
}
