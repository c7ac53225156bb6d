//! Files of every network of the registry, read back.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::{HashMap, HashSet};

use burn::tensor::Device;
use evpose_nn::graph::{Graph, Operation};
use evpose_nn::{BACKBONES, HandRegressorConfig};
use evpose_onnx::proto::{DimensionValue, ModelProto, TensorProto, ValueInfoProto};
use evpose_onnx::{Message, OPSET, OnnxError, encoded, model};

fn graph(backbone: &str) -> Graph {
    let config = HandRegressorConfig { backbone: backbone.to_owned(), width: 0.25 };
    config.init(7, &Device::flex()).unwrap().graph()
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
    for entry in BACKBONES {
        let graph = graph(entry.name);
        let read = ModelProto::decode(&*encoded(&graph, [2, 180, 240]).unwrap()).unwrap();
        assert_eq!(read, model(&graph, [2, 180, 240]).unwrap());
        assert_eq!(read.opset_import[0].version, OPSET);
        let file = read.graph.unwrap();
        assert_eq!(dims(&file.input[0]), [1, 2, 180, 240]);
        assert_eq!(file.output.iter().map(dims).collect::<Vec<_>>(), [[1, 12]]);
        let constants: HashMap<&str, &TensorProto> =
            file.initializer.iter().map(|tensor| (tensor.name.as_str(), tensor)).collect();
        assert_eq!(constants.len(), file.initializer.len(), "{}: names are unique", entry.name);
        for node in &graph.nodes {
            let (shape, weight, bias): (&[usize], _, _) = match &node.operation {
                Operation::Conv(conv) => (&conv.shape, &conv.weight, &conv.bias),
                Operation::Linear(linear) => (&linear.shape, &linear.weight, &linear.bias),
                _ => continue,
            };
            let written = constants[format!("{}.weight", node.name).as_str()];
            let dims: Vec<usize> = written.dims.iter().map(|dim| *dim as usize).collect();
            assert_eq!(dims, shape, "{}", node.name);
            assert_eq!(values(written), *weight, "{}", node.name);
            assert_eq!(values(constants[format!("{}.bias", node.name).as_str()]), *bias);
        }
    }
}

#[test]
fn every_tensor_is_made_once_before_it_is_taken() {
    for entry in BACKBONES {
        let file = model(&graph(entry.name), [2, 61, 83]).unwrap().graph.unwrap();
        let mut known: HashSet<&str> = HashSet::new();
        let outside = file.initializer.iter().map(|tensor| tensor.name.as_str());
        known.extend(outside.chain(file.input.iter().map(|info| info.name.as_str())));
        for node in &file.node {
            for name in &node.input {
                assert!(known.contains(name.as_str()), "{}: {name}", entry.name);
            }
            for name in &node.output {
                assert!(known.insert(name), "{}: {name} is made twice", entry.name);
            }
        }
        let shown = file.output.iter().chain(&file.value_info);
        for info in shown {
            assert!(known.contains(info.name.as_str()), "{}: {}", entry.name, info.name);
        }
    }
}

#[test]
fn images_that_a_layer_cannot_take_are_refused_by_its_name() {
    let error = model(&graph("resnet18"), [3, 45, 60]).unwrap_err();
    assert_eq!(error.to_string(), "layer `input`: 3 channels instead of 2");
    let error = model(&graph("vgg11_bn"), [2, 20, 20]).unwrap_err();
    assert!(matches!(&error, OnnxError::Shape(_)), "{error}");
}
