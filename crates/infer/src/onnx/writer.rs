//! Initializers, nodes and names of a model.

use std::collections::HashMap;

use crate::infer_shapes;
use evpose_nn::graph::{Graph, Node, NodeId, Operation};
use prost::Message as _;

use crate::onnx::OnnxError;
use crate::onnx::nodes::add_operators;
use crate::onnx::proto::{
    AttributeProto, AttributeType, DataType, Dimension, DimensionValue, GraphProto, ModelProto,
    NodeProto, OperatorSetIdProto, StringStringEntryProto, TensorProto, TensorShapeProto,
    TensorType, TypeProto, ValueInfoProto,
};

/// Version of the default operator set (opset).
pub const OPSET: i64 = 13;
/// Version of the file format (IR version): that of ONNX 1.8, the first release with opset 13.
const IR_VERSION: i64 = 7;

/// Name of the first dimension of an [`Interface`].
pub const BATCH: &str = "batch";

/// An interface for programs that know nothing of the layers: any number of inputs at once, tensors named by
/// their meaning, and what the file says about itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Interface {
    /// Name of the input.
    pub input: String,
    /// Names of the outputs, in the order of the graph's.
    pub outputs: Vec<String>,
    /// Names and values of `metadata_props`.
    pub metadata: Vec<(String, String)>,
}

/// Exports a network as an ONNX model with the input `[1, channels, height, width]`, its tensors named by their
/// layers. With an interface the input is `[batch, channels, height, width]`, where `batch` is any number, and the
/// names and the metadata are those of the interface; outputs without a name there are named by their layers.
///
/// # Errors
/// [`OnnxError::Unsupported`] for an operation without a translation, [`OnnxError::Shape`] for a
/// size that a layer cannot take.
pub fn model(
    graph: &Graph,
    input: [usize; 3],
    interface: Option<&Interface>,
) -> Result<ModelProto, OnnxError> {
    let shapes = infer_shapes(graph, input)?;
    let batch = match interface {
        Some(_) => DimensionValue::Name(BATCH.to_owned()),
        None => DimensionValue::Size(1),
    };
    let names = names(graph, interface);
    let mut writer = Writer { graph, names, shapes, batch, file: GraphProto::default() };
    for id in 0..graph.nodes.len() {
        add_operators(&mut writer, id)?;
    }
    let is_input = |id: &NodeId| graph.nodes[*id].operation == Operation::Input;
    let of = |ids: &mut dyn Iterator<Item = NodeId>| ids.map(|id| writer.value_info(id)).collect();
    let all = 0..graph.nodes.len();
    let input = of(&mut all.clone().filter(is_input));
    let output = of(&mut graph.outputs.iter().copied());
    // Optional, but viewers show shapes by them.
    let value_info = of(&mut all.filter(|id| !is_input(id) && !graph.outputs.contains(id)));
    let name = "network".to_owned();
    let file = GraphProto { name, input, output, value_info, ..writer.file };
    Ok(ModelProto {
        ir_version: IR_VERSION,
        producer_name: "evpose".to_owned(),
        producer_version: env!("CARGO_PKG_VERSION").to_owned(),
        graph: Some(file),
        opset_import: vec![OperatorSetIdProto { domain: String::new(), version: OPSET }],
        metadata_props: interface
            .into_iter()
            .flat_map(|known| known.metadata.iter().cloned())
            .map(|(key, value)| StringStringEntryProto { key, value })
            .collect(),
    })
}

/// [`model`] without an interface, encoded as the bytes of a file.
///
/// # Errors
/// As [`model`].
pub fn encoded(graph: &Graph, input: [usize; 3]) -> Result<Vec<u8>, OnnxError> {
    Ok(model(graph, input, None)?.encode_to_vec())
}

/// Unique names of the nodes: those of an interface, and of nodes with one name (layers that share weights, or
/// are named as the interface names others), with the index appended.
fn names(graph: &Graph, interface: Option<&Interface>) -> Vec<String> {
    let mut given: HashMap<NodeId, &str> = HashMap::new();
    if let Some(Interface { input, outputs, .. }) = interface {
        let is_input = |id: &NodeId| graph.nodes[*id].operation == Operation::Input;
        given.extend((0..graph.nodes.len()).filter(is_input).map(|id| (id, input.as_str())));
        given.extend(graph.outputs.iter().copied().zip(outputs.iter().map(String::as_str)));
    }
    let mut seen: HashMap<&str, usize> = HashMap::new();
    graph.nodes.iter().for_each(|node| *seen.entry(node.name.as_str()).or_default() += 1);
    given.values().for_each(|name| *seen.entry(name).or_default() += 1);
    let name = |(id, node): (usize, &Node)| match given.get(&id) {
        Some(name) => (*name).to_owned(),
        None if seen[node.name.as_str()] == 1 => node.name.clone(),
        None => format!("{}.{id}", node.name),
    };
    graph.nodes.iter().enumerate().map(name).collect()
}

/// A model in the making.
pub(crate) struct Writer<'a> {
    graph: &'a Graph,
    names: Vec<String>,
    shapes: Vec<[usize; 3]>,
    /// The first dimension of inputs, outputs and all between.
    batch: DimensionValue,
    file: GraphProto,
}

impl<'a> Writer<'a> {
    pub(crate) fn node(&self, id: NodeId) -> &'a Node {
        &self.graph.nodes[id]
    }

    /// Name of a node and of its output tensor.
    pub(crate) fn name(&self, id: NodeId) -> &str {
        &self.names[id]
    }

    /// Channels, height and width of a node's output.
    pub(crate) fn shape(&self, id: NodeId) -> [usize; 3] {
        self.shapes[id]
    }

    /// Adds an initializer of floats and returns its name.
    pub(crate) fn floats(&mut self, name: String, dims: &[usize], values: &[f32]) -> String {
        let raw_data = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.initializer(name, dims, DataType::Float, raw_data)
    }

    /// Adds an initializer that is a list of integers and returns its name.
    pub(crate) fn integers(&mut self, name: String, values: &[i64]) -> String {
        let raw_data = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.initializer(name, &[values.len()], DataType::Int64, raw_data)
    }

    /// Adds an initializer that is a scalar and returns its name.
    pub(crate) fn scalar(&mut self, name: String, value: f32) -> String {
        self.floats(name, &[], &[value])
    }

    /// Adds an initializer and returns its name.
    fn initializer(
        &mut self,
        name: String,
        dims: &[usize],
        kind: DataType,
        raw_data: Vec<u8>,
    ) -> String {
        self.file.initializer.push(TensorProto {
            dims: signed(dims),
            data_type: kind.into(),
            name: name.clone(),
            raw_data,
        });
        name
    }

    /// Adds a node for an operator, named by its output tensor, and returns that name.
    pub(crate) fn operator(
        &mut self,
        op_type: &str,
        input: Vec<String>,
        output: String,
        attribute: Vec<AttributeProto>,
    ) -> String {
        self.file.node.push(NodeProto {
            input,
            output: vec![output.clone()],
            name: output.clone(),
            op_type: op_type.to_owned(),
            attribute,
        });
        output
    }

    /// Name, element type and shape of a node's output.
    fn value_info(&self, id: NodeId) -> ValueInfoProto {
        let [channels, height, width] = self.shapes[id];
        let dims =
            if is_vector(self.graph, id) { vec![channels] } else { vec![channels, height, width] };
        let sizes = signed(&dims).into_iter().map(DimensionValue::Size);
        let dims = std::iter::once(self.batch.clone()).chain(sizes);
        let dim = dims.map(|value| Dimension { value: Some(value) }).collect();
        let shape = TensorShapeProto { dim };
        let tensor = TensorType { elem_type: DataType::Float.into(), shape: Some(shape) };
        let kind = TypeProto { tensor_type: Some(tensor) };
        ValueInfoProto { name: self.names[id].clone(), r#type: Some(kind) }
    }
}

/// Whether a node's output is `[1, values]` instead of an image.
fn is_vector(graph: &Graph, id: NodeId) -> bool {
    let node = &graph.nodes[id];
    match node.operation {
        Operation::Flatten | Operation::Linear(_) => true,
        Operation::Relu | Operation::Add => is_vector(graph, node.inputs[0]),
        _ => false,
    }
}

pub(crate) fn int(name: &str, value: usize) -> AttributeProto {
    let i = value as i64;
    let kind = AttributeType::Int.into();
    AttributeProto { name: name.to_owned(), i, r#type: kind, ..AttributeProto::default() }
}

pub(crate) fn ints(name: &str, values: &[usize]) -> AttributeProto {
    let kind = AttributeType::Ints.into();
    let (name, ints) = (name.to_owned(), signed(values));
    AttributeProto { name, ints, r#type: kind, ..AttributeProto::default() }
}

pub(crate) fn string(name: &str, value: &str) -> AttributeProto {
    let kind = AttributeType::String.into();
    let (name, s) = (name.to_owned(), value.as_bytes().to_vec());
    AttributeProto { name, s, r#type: kind, ..AttributeProto::default() }
}

fn signed(values: &[usize]) -> Vec<i64> {
    values.iter().map(|value| *value as i64).collect()
}
