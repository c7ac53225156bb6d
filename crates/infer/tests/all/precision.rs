//! Networks in bf16 and int8: their error relative to f32, and equal bits in every run.

use burn::tensor::Device;
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, InferError, Level, Precision};
use evpose_nn::graph::Graph;
use evpose_nn::parameters::with_matched_variances;
use evpose_nn::{HandRegressor, HandRegressorConfig, MoveEnetConfig, Network, backbone_by_name};

/// Pseudo-random values between 0 and `most`.
fn image(seed: u32, count: usize, most: f32) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| most * next()).collect()
}

fn hand(backbone: &str) -> HandRegressor {
    // VGG-19 computes ten times as much as the others.
    let is_large = backbone.starts_with("vgg") || backbone.starts_with("inception");
    let config = HandRegressorConfig {
        backbone: backbone.to_owned(),
        width: if is_large { 0.25 } else { 0.5 },
        ..HandRegressorConfig::default()
    };
    with_matched_variances(config.init(7, &Device::flex()).unwrap())
}

/// The root of the mean square of differences, over that of the values themselves about their mean.
fn relative_error(ours: &[f32], theirs: &[f32]) -> f32 {
    assert_eq!(ours.len(), theirs.len());
    let mean = theirs.iter().sum::<f32>() / theirs.len() as f32;
    let squares = |values: &mut dyn Iterator<Item = f32>| values.map(|v| v * v).sum::<f32>();
    let differences = squares(&mut ours.iter().zip(theirs).map(|(a, b)| a - b));
    (differences / squares(&mut theirs.iter().map(|value| value - mean))).sqrt()
}

/// Ranges calibrated on some images.
fn calibrated(graph: &Graph, size: [usize; 3], images: &[Vec<f32>]) -> CalibrationRanges {
    let mut engine =
        Engine::compile(graph, size, EngineOptions::default().layer_by_layer()).unwrap();
    let mut ranges = CalibrationRanges::new(graph);
    images.iter().for_each(|image| engine.observe(image, &mut ranges));
    ranges
}

#[test]
fn every_network_is_near_f32_at_low_precision() {
    let networks = Network::names().map(|name| {
        if name == evpose_nn::MOVE_ENET {
            let network = MoveEnetConfig::default().init(7, &Device::flex()).unwrap();
            (name, with_matched_variances(network).graph(), [3, 96, 128], 255.0)
        } else if name == evpose_nn::JOINT_NET {
            let network = Network::untrained(name, 1.0, 7, &Device::flex()).unwrap();
            (name, network.with_matched_variances().graph(), [2, 64, 96], 1.0)
        } else {
            let smallest_px = backbone_by_name(name).unwrap().smallest_px;
            let [height, width] = [61, 83].map(|side: usize| side.max(smallest_px));
            (name, hand(name).graph(), [2, height, width], 1.0)
        }
    });
    for (name, graph, size, most) in networks {
        let count = size.iter().product();
        let input = image(3, count, most);
        let ranges = calibrated(&graph, size, &[input.clone(), image(4, count, most)]);
        let options = EngineOptions::default();
        let want = Engine::compile(&graph, size, options).unwrap().run(&input).to_vec();
        // One map of a body that nobody taught is nearly the same everywhere: what little its
        // values differ by is rounded the most.
        let maps = if name == evpose_nn::MOVE_ENET { 2.0 } else { 1.0 };
        for (precision, off) in [(Precision::Bf16, 0.1 * maps), (Precision::Int8, 0.25 * maps)] {
            for level in Level::available() {
                let mut first = None;
                for threads in [1, 3] {
                    let options =
                        options.with_threads(threads).with_level(level).with_precision(precision);
                    let mut engine =
                        Engine::compile_with(&graph, size, options, Some(&ranges)).unwrap();
                    let what = format!("{name} {precision} {level} {threads}");
                    let ours = engine.run(&input).to_vec();
                    // The presence of a hand is one value, which varies by nothing that an error could be compared with.
                    let compared = ours.iter().zip(&want).filter(|(_, want)| want.len() > 1);
                    for (ours, want) in compared {
                        let error = relative_error(ours, want);
                        assert!(error < off, "{what}: {error}");
                        assert!(error > 0.0, "{what}: nothing was rounded");
                    }
                    let bits = first.get_or_insert_with(|| ours.clone());
                    assert_eq!(&ours, bits, "{what}");
                    assert_eq!(engine.another().run(&input), bits, "{what}");
                    let algorithms = engine.layers().iter().map(|layer| layer.algorithm);
                    let amx = if algorithms.clone().any(|name| name.starts_with("amx")) {
                        " and amx"
                    } else {
                        ""
                    };
                    assert_eq!(engine.instructions(), format!("{level}{amx}"), "{what}");
                    let word = precision.to_string();
                    assert!(algorithms.filter(|name| name.ends_with(&word)).count() > 5, "{what}");
                }
            }
        }
    }
}

#[test]
fn int8_needs_calibration() {
    let graph = hand("resnet18").graph();
    let size = [2, 45, 60];
    let options = EngineOptions::default().with_precision(Precision::Int8);
    let error = Engine::compile(&graph, size, options).err().unwrap();
    assert!(error.to_string().contains("evpose quantize"), "{error}");
    let empty = CalibrationRanges::new(&graph);
    let error = Engine::compile_with(&graph, size, options, Some(&empty)).err().unwrap();
    assert!(matches!(error, InferError::NotCalibrated { .. }), "{error}");
    let other = CalibrationRanges::new(&hand("vgg11_bn").graph());
    let error = Engine::compile_with(&graph, size, options, Some(&other)).err().unwrap();
    assert!(matches!(error, InferError::NotCalibrated { .. }), "{error}");
}
