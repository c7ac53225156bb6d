//! Files of every network of the registry, read back.

use std::collections::{HashMap, HashSet};

use burn::tensor::Device;
use evpose_infer::onnx::proto::{DimensionValue, ModelProto, TensorProto, ValueInfoProto};
use evpose_infer::onnx::{BATCH, Interface, Message, OPSET, OnnxError, encoded, model};
use evpose_nn::graph::{Graph, Operation};
use evpose_nn::{JOINT_NET, MOVE_ENET, Network, backbone_by_name};

fn network(name: &str) -> Network {
    Network::untrained(name, 0.25, 7, &Device::flex()).unwrap()
}

fn graph(name: &str) -> Graph {
    network(name).graph()
}

fn dims(info: &ValueInfoProto) -> Vec<i64> {
    let tensor = info.r#type.as_ref().unwrap().tensor_type.as_ref().unwrap();
    let size = |value: &Option<DimensionValue>| match value {
        Some(DimensionValue::Size(size)) => *size,
        other => panic!("{other:?}"),
    };
    tensor.shape.as_ref().unwrap().dim.iter().map(|dim| size(&dim.value)).collect()
}

fn values(tensor: &TensorProto) -> Vec<f32> {
    let (values, rest) = tensor.raw_data.as_chunks::<4>();
    assert!(rest.is_empty());
    values.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

#[test]
fn a_file_is_read_back_with_every_weight_and_shape() {
    for name in Network::names() {
        let (graph, input) = (graph(name), network(name).input());
        let read = ModelProto::decode(&*encoded(&graph, input).unwrap()).unwrap();
        assert_eq!(read, model(&graph, input, None).unwrap());
        assert_eq!(read.opset_import[0].version, OPSET);
        let file = read.graph.unwrap();
        let image = input.map(|side| side as i64);
        assert_eq!(dims(&file.input[0]), [&[1], image.as_slice()].concat());
        let maps = [13, 1, 26, 26].map(|channels| vec![1, channels, 48, 48]);
        let outputs = match name {
            MOVE_ENET => maps.to_vec(),
            JOINT_NET => vec![vec![1, 21, 24, 32], vec![1, 21, 24, 32], vec![1, 1]],
            _ => vec![vec![1, 12]],
        };
        assert_eq!(file.output.iter().map(dims).collect::<Vec<_>>(), outputs);
        let constants: HashMap<&str, &TensorProto> =
            file.initializer.iter().map(|tensor| (tensor.name.as_str(), tensor)).collect();
        assert_eq!(constants.len(), file.initializer.len(), "{name}: names are unique");
        for (id, node) in graph.nodes.iter().enumerate() {
            let (shape, weight, bias): (&[usize], _, _) = match &node.operation {
                Operation::Conv(conv) => (&conv.shape, &conv.weight, &conv.bias),
                Operation::Linear(linear) => (&linear.shape, &linear.weight, &linear.bias),
                _ => continue,
            };
            let constant = |part: &str| {
                // Layers of one name, as those that share weights, have their number in it.
                let numbered = format!("{}.{id}.{part}", node.name);
                let plain = format!("{}.{part}", node.name);
                constants.get(plain.as_str()).unwrap_or_else(|| &constants[numbered.as_str()])
            };
            let written = constant("weight");
            let dims: Vec<usize> = written.dims.iter().map(|dim| *dim as usize).collect();
            assert_eq!(dims, shape, "{}", node.name);
            assert_eq!(values(written), *weight, "{}", node.name);
            assert_eq!(values(constant("bias")), *bias);
        }
    }
}

#[test]
fn every_tensor_is_made_once_before_it_is_taken() {
    for network in Network::names() {
        let [channels, ..] = self::network(network).input();
        let smallest_px = backbone_by_name(network).map_or(0, |backbone| backbone.smallest_px);
        let size = if [MOVE_ENET, JOINT_NET].contains(&network) { [64, 96] } else { [61, 83] };
        let size = size.map(|side: usize| side.max(smallest_px));
        let file =
            model(&graph(network), [channels, size[0], size[1]], None).unwrap().graph.unwrap();
        let mut known: HashSet<&str> = HashSet::new();
        let outside = file.initializer.iter().map(|tensor| tensor.name.as_str());
        known.extend(outside.chain(file.input.iter().map(|info| info.name.as_str())));
        for node in &file.node {
            // What is left out has no name.
            for name in node.input.iter().filter(|name| !name.is_empty()) {
                assert!(known.contains(name.as_str()), "{network}: {name}");
            }
            for name in &node.output {
                assert!(known.insert(name), "{network}: {name} is made twice");
            }
        }
        let shown = file.output.iter().chain(&file.value_info);
        for info in shown {
            assert!(known.contains(info.name.as_str()), "{network}: {}", info.name);
        }
    }
}

#[test]
fn images_that_a_layer_cannot_take_are_refused_by_its_name() {
    let error = model(&graph("resnet18"), [3, 45, 60], None).unwrap_err();
    assert_eq!(error.to_string(), "layer `input`: 3 channels instead of 2");
    let error = model(&graph("vgg11_bn"), [2, 20, 20], None).unwrap_err();
    assert!(matches!(&error, OnnxError::Shape(_)), "{error}");
}

/// The first dimension of every tensor is symbolic, and names that collide with those of layers replace these.
#[test]
fn an_interface_names_tensors_and_leaves_the_batch_open() {
    for name in Network::names() {
        let (graph, input) = (graph(name), network(name).input());
        let taken = graph.nodes[1].name.clone();
        let interface = Interface {
            input: "events".to_owned(),
            outputs: graph
                .outputs
                .iter()
                .enumerate()
                .map(|(k, _)| match k {
                    // As a layer is named.
                    0 => taken.clone(),
                    k => format!("output_{k}"),
                })
                .collect(),
            metadata: vec![("task".to_owned(), "a test".to_owned())],
        };
        let file = model(&graph, input, Some(&interface)).unwrap();
        assert_eq!(file.metadata_props[0].key, "task");
        assert_eq!(file.metadata_props[0].value, "a test");
        let file = file.graph.unwrap();
        assert_eq!(file.input[0].name, "events");
        let outputs: Vec<&str> = file.output.iter().map(|info| info.name.as_str()).collect();
        assert_eq!(outputs, interface.outputs);
        for info in file.input.iter().chain(&file.output).chain(&file.value_info) {
            let tensor = info.r#type.as_ref().unwrap().tensor_type.as_ref().unwrap();
            let first = tensor.shape.as_ref().unwrap().dim[0].value.clone();
            assert_eq!(first, Some(DimensionValue::Name(BATCH.to_owned())), "{}", info.name);
        }
        let made: HashSet<&str> =
            file.node.iter().flat_map(|node| &node.output).map(String::as_str).collect();
        assert_eq!(made.len(), file.node.iter().map(|node| node.output.len()).sum::<usize>());
        assert!(outputs.iter().all(|name| made.contains(name)), "{name}");
        // No shape may hold the number of images.
        let shapes = file.initializer.iter().filter(|tensor| tensor.name.ends_with(".shape"));
        for shape in shapes {
            assert_eq!(shape.raw_data[..8], [0; 8], "{name}: {}", shape.name);
        }
    }
}
