//! Every network of the registry through the engine, against Burn's own arithmetic.

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_infer::{Engine, EngineOptions, InferError, Level};
use evpose_nn::graph::{Graph, Operation};
use evpose_nn::{BACKBONES, HandRegressor, HandRegressorConfig, MoveEnetConfig};

/// Pseudo-random values between 0 and 1, the range of representations.
fn image(seed: u32, count: usize) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| next()).collect()
}

fn network(backbone: &str, width: f32) -> HandRegressor {
    let config = HandRegressorConfig {
        backbone: backbone.to_owned(),
        width,
        ..HandRegressorConfig::default()
    };
    with_statistics(&config.init(7, &Device::flex()).unwrap(), 1.0)
}

/// Gives a network statistics that are not those of one that has seen nothing, and normalisations
/// that give values about this size.
fn with_statistics<M: Module>(network: &M, size: f32) -> M {
    evpose_nn::parameters::fill(network.clone(), {
        let mut values = evpose_nn::parameters::read(network).into_iter();
        move |slot| {
            let (_, values) = values.next().unwrap();
            let noise = image(values.len() as u32, values.len());
            // Untrained statistics are 0 and 1, which an engine that ignores them would pass.
            let pairs = values.into_iter().zip(noise);
            match slot.name() {
                "running_var" => pairs.map(|(value, noise)| value * (0.5 + noise)).collect(),
                "running_mean" | "beta" => pairs.map(|(_, noise)| 0.2 * noise - 0.1).collect(),
                "gamma" => {
                    pairs.map(|(value, noise)| size * value * (0.75 + 0.5 * noise)).collect()
                }
                _ => pairs.map(|(value, _)| value).collect(),
            }
        }
    })
}

fn expected(network: &HandRegressor, input: &[f32], [height, width]: [usize; 2]) -> Vec<f32> {
    let data = TensorData::new(input.to_vec(), [1, 2, height, width]);
    let output = network.forward(Tensor::from_data(data, &Device::flex()));
    output.into_data().iter::<f32>().collect()
}

/// The largest difference, relative to the largest value.
fn relative_difference(ours: &[f32], theirs: &[f32]) -> f32 {
    assert_eq!(ours.len(), theirs.len());
    let largest = theirs.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    let pairs = ours.iter().zip(theirs);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / largest
}

#[test]
fn every_network_matches_burn() {
    for entry in &BACKBONES {
        // The published network at its size, the others small: VGG-19 computes sixty times as much.
        let is_published = entry.name == "resnet18";
        let (width, large) = if is_published { (0.5, [180, 240]) } else { (0.25, [96, 128]) };
        let network = network(entry.name, width);
        let graph = network.graph();
        for size in [large, [61, 83]] {
            let [height, width] = size.map(|side: usize| side.max(entry.smallest_px));
            let input = image(3, 2 * height * width);
            let want = expected(&network, &input, [height, width]);
            for level in Level::available() {
                let mut first = None;
                for threads in [1, 3] {
                    let options = EngineOptions::default().with_threads(threads).with_level(level);
                    let mut engine = Engine::compile(&graph, [2, height, width], options).unwrap();
                    let difference = relative_difference(&engine.run(&input)[0], &want);
                    let what = format!("{} {height}x{width} {level} {threads}", entry.name);
                    assert!(difference < 1e-4, "{what}: {difference}");
                    // The same bits in every run, from any number of threads.
                    let bits = first.get_or_insert_with(|| engine.run(&input).to_vec()).clone();
                    assert_eq!(engine.run(&input), bits, "{what}");
                    assert_eq!(engine.another().run(&input), bits, "{what}");
                }
            }
        }
    }
}

#[test]
fn heatmaps_of_move_enet_match_burn() {
    let device = Device::flex();
    // Statistics of no training let every repetition double its values, up to logits of 40,000. Of
    // those, sigmoids would show rounding and nothing else.
    let network = with_statistics(&MoveEnetConfig::default().init(7, &device).unwrap(), 0.6);
    let graph = network.graph();
    // At odd sizes, halves are rounded up, to multiples of what the coarsest level has.
    for [height, width] in [[192, 192], [128, 128], [157, 191]] {
        let input: Vec<f32> =
            image(3, 3 * height * width).into_iter().map(|value| 255.0 * value).collect();
        let data = TensorData::new(input.clone(), [1, 3, height, width]);
        let want: Vec<Vec<f32>> = network
            .forward(Tensor::from_data(data, &device))
            .into_array()
            .map(|map| map.into_data().iter().collect())
            .into();
        for level in Level::available() {
            let mut first = None;
            for threads in [1, 3] {
                let options = EngineOptions::default().with_threads(threads).with_level(level);
                let mut engine = Engine::compile(&graph, [3, height, width], options).unwrap();
                let what = format!("{height}x{width} {level} {threads}");
                let ours = engine.run(&input).to_vec();
                assert_eq!(ours.len(), 4);
                for (ours, want) in ours.iter().zip(&want) {
                    let difference = relative_difference(ours, want);
                    assert!(difference < 1e-4, "{what}: {difference}");
                }
                let bits = first.get_or_insert_with(|| ours.clone());
                assert_eq!(&ours, bits, "{what}");
                assert_eq!(engine.another().run(&input), bits, "{what}");
            }
        }
    }
    let options = EngineOptions::default();
    let engine = Engine::compile(&graph, [3, 192, 192], options).unwrap();
    let macs: u64 = engine.layers().iter().map(|layer| layer.macs).sum();
    assert_eq!(macs / 100_000, 2242, "{macs}, and 224.2 million as published");
    let odd = Engine::compile(&graph, [3, 180, 240], options).err().unwrap();
    assert!(matches!(&odd, InferError::Shape { layer, .. } if layer == "add"), "{odd}");
}

#[test]
fn intermediate_nodes_may_be_outputs() {
    let network = network("resnet18", 0.25);
    let mut graph = network.graph();
    let input = image(3, 2 * 45 * 60);
    let run = |graph: &Graph| {
        let options = EngineOptions::default();
        Engine::compile(graph, [2, 45, 60], options).unwrap().run(&input).to_vec()
    };
    let end = run(&graph);
    // Sums that others take up and change, where nobody asks for them.
    let is_sum = |id: &usize| graph.nodes[*id].operation == Operation::Add;
    let sums: Vec<_> = (0..graph.nodes.len()).filter(is_sum).collect();
    graph.outputs = [sums.clone(), graph.outputs.clone()].concat();
    let outputs = run(&graph);
    assert!(relative_difference(&outputs[sums.len()], &end[0]) < 1e-5);
    for (id, values) in sums.into_iter().zip(outputs) {
        let alone = Graph { nodes: graph.nodes[..=id].to_vec(), outputs: vec![id] };
        assert!(relative_difference(&values, &run(&alone)[0]) < 1e-5, "node {id}");
    }
}

#[test]
fn macs_match_the_published_shapes() {
    let network = network("resnet18", 1.0);
    let options = EngineOptions::default();
    let engine = Engine::compile(&network.graph(), [2, 180, 240], options).unwrap();
    let macs: u64 = engine.layers().iter().map(|layer| layer.macs).sum();
    // Counted by hand from the published shapes: conv1, stem, four stages, head.
    let conv =
        |channels: [u64; 2], taps: u64, pixels: u64| channels[0] * channels[1] * taps * pixels;
    let mut want = conv([2, 3], 9, 180 * 240) + conv([3, 64], 49, 90 * 120) + 512 * 12;
    for (stage, pixels) in [45 * 60, 23 * 30, 12 * 15, 6 * 8].into_iter().enumerate() {
        let channels = 64 << stage;
        let first = if stage == 0 { 64 } else { channels / 2 };
        want += conv([first, channels], 9, pixels) + 3 * conv([channels, channels], 9, pixels);
        want += if stage == 0 { 0 } else { conv([first, channels], 1, pixels) };
    }
    assert_eq!(macs, want);
}

#[test]
fn errors_name_the_layer() {
    let with = |change: &dyn Fn(&mut Graph)| {
        let mut graph = network("resnet18", 0.25).graph();
        change(&mut graph);
        Engine::compile(&graph, [2, 45, 60], EngineOptions::default()).err().unwrap()
    };
    let dilated = with(&|graph| {
        for node in &mut graph.nodes {
            if let ("backbone.stages.1.0.first", Operation::Conv(conv)) =
                (node.name.as_str(), &mut node.operation)
            {
                conv.dilation = [2, 2];
                conv.padding = [2; 4];
            }
        }
    });
    let InferError::Unsupported { layer, operation } = dilated else { panic!("{dilated}") };
    assert_eq!(layer, "backbone.stages.1.0.first");
    assert!(operation.contains("gaps between its taps"), "{operation}");
    let graph = network("resnet18", 0.25).graph();
    let other = Engine::compile(&graph, [3, 45, 60], EngineOptions::default()).err().unwrap();
    assert!(matches!(&other, InferError::Shape { layer, .. } if layer == "input"), "{other}");
    let graph = network("vgg11_bn", 0.25).graph();
    let small = Engine::compile(&graph, [2, 20, 20], EngineOptions::default()).err().unwrap();
    assert!(small.to_string().contains("nothing is left"), "{small}");
}
