//! Small networks with inputs and outputs as those of the systems, as the bytes of ONNX files.

use evpose_infer::onnx::Message as _;
use evpose_infer::onnx::proto::{
    AttributeProto, AttributeType, DataType, Dimension, DimensionValue, GraphProto, ModelProto,
    NodeProto, OperatorSetIdProto, TensorProto, TensorShapeProto, TensorType, TypeProto,
    ValueInfoProto,
};
use evpose_pose::body::{MOVENET_VALUES, OpenPoseModel};

const INT32: i32 = 6;
const FLOAT: i32 = DataType::Float as i32;
const OPSET: i64 = 13;

/// How a network outputs its maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Maps {
    Apart,
    Together,
    /// Fields and heatmaps of a first stage, without anybody, before those that count.
    Stages,
    ChannelsLast,
}

fn value(name: &str, elem_type: i32, dims: &[i64]) -> ValueInfoProto {
    let dim = |(axis, size): (usize, &i64)| Dimension {
        value: Some(match size {
            0 => DimensionValue::Name(format!("side{axis}")),
            size => DimensionValue::Size(*size),
        }),
    };
    let shape = TensorShapeProto { dim: dims.iter().enumerate().map(dim).collect() };
    let tensor = TensorType { elem_type, shape: Some(shape) };
    let r#type = Some(TypeProto { tensor_type: Some(tensor) });
    ValueInfoProto { name: name.to_owned(), r#type }
}

fn floats(name: &str, dims: &[i64], values: &[f32]) -> TensorProto {
    assert_eq!(dims.iter().product::<i64>(), values.len() as i64);
    TensorProto {
        dims: dims.to_vec(),
        data_type: FLOAT,
        name: name.to_owned(),
        raw_data: values.iter().flat_map(|value| value.to_le_bytes()).collect(),
    }
}

fn integers(name: &str, values: &[i64]) -> TensorProto {
    TensorProto {
        dims: vec![values.len() as i64],
        data_type: DataType::Int64 as i32,
        name: name.to_owned(),
        raw_data: values.iter().flat_map(|value| value.to_le_bytes()).collect(),
    }
}

fn node(op_type: &str, inputs: &[&str], output: &str, attribute: Vec<AttributeProto>) -> NodeProto {
    NodeProto {
        input: inputs.iter().map(|name| (*name).to_owned()).collect(),
        output: vec![output.to_owned()],
        name: output.to_owned(),
        op_type: op_type.to_owned(),
        attribute,
    }
}

fn ints(name: &str, ints: &[i64]) -> AttributeProto {
    let (name, ints) = (name.to_owned(), ints.to_vec());
    AttributeProto { name, ints, r#type: AttributeType::Ints.into(), ..AttributeProto::default() }
}

fn int(name: &str, i: i64) -> AttributeProto {
    let name = name.to_owned();
    AttributeProto { name, i, r#type: AttributeType::Int.into(), ..AttributeProto::default() }
}

fn file(graph: GraphProto) -> Vec<u8> {
    let graph = GraphProto { name: "network".to_owned(), ..graph };
    let opset = OperatorSetIdProto { domain: String::new(), version: OPSET };
    let model = ModelProto {
        ir_version: 7,
        graph: Some(graph),
        opset_import: vec![opset],
        ..ModelProto::default()
    };
    model.encode_to_vec()
}

/// A network like MoveNet of `side` pixels: y, x and score of each keypoint are the greys in rows
/// 2, 3 and 3 of column 8, over 255. Input as integers, channels last, or as floats, channels first.
pub(crate) fn movenet(side: usize, has_integers: bool) -> Vec<u8> {
    let inputs = 3 * side * side;
    let mut weights = vec![0.0; inputs * MOVENET_VALUES];
    for k in 0..MOVENET_VALUES {
        let row = if k % 3 == 0 { 2 } else { 3 };
        // Another channel for each keypoint.
        let channel = k % 2;
        let pixel = row * side + 8;
        let at = if has_integers { 3 * pixel + channel } else { channel * side * side + pixel };
        weights[at * MOVENET_VALUES + k] = 1.0 / 255.0;
    }
    let side = side as i64;
    let (elem_type, dims) =
        if has_integers { (INT32, [1, side, side, 3]) } else { (FLOAT, [1, 3, side, side]) };
    file(GraphProto {
        node: vec![
            node("Cast", &["image"], "greys", vec![int("to", i64::from(FLOAT))]),
            node("Flatten", &["greys"], "row", vec![int("axis", 1)]),
            node("MatMul", &["row", "weights"], "values", vec![]),
            node("Reshape", &["values", "shape"], "keypoints", vec![]),
        ],
        initializer: vec![
            floats("weights", &[inputs as i64, MOVENET_VALUES as i64], &weights),
            integers("shape", &[1, 1, 17, 3]),
        ],
        input: vec![value("image", elem_type, &dims)],
        output: vec![value("keypoints", FLOAT, &[1, 1, 17, 3])],
        ..GraphProto::default()
    })
}

const ROWS: usize = 12;
const COLUMNS: usize = 16;
const CELLS: usize = ROWS * COLUMNS;

/// A network like OpenPose for 128x96 pixels, with one person: a nose in column 8 and row 1, a neck
/// below it in row 4, the right shoulder in column 4, the left one in column 12. Peaks are `height`
/// minus the mean of the input where they are.
pub(crate) fn openpose(model: OpenPoseModel, layout: Maps, height: f32) -> Vec<u8> {
    let (parts, channels) = (model.heatmap_channels(), model.field_channels());
    let mut heatmaps = vec![-10.0; parts * CELLS];
    for (part, x, y) in [(0, 8, 1), (1, 8, 4), (2, 4, 4), (5, 12, 4)] {
        heatmaps[part * CELLS + y * COLUMNS + x] = height;
    }
    // Far from peaks there is nothing, whatever the input.
    for value in &mut heatmaps {
        *value = value.max(-1.0);
    }
    let mut fields = vec![0.0; channels * CELLS];
    // Channels of x of the limbs from the neck to the right shoulder, the left one and the nose.
    let [right, left, nose] = match model {
        OpenPoseModel::Coco18 => [12, 20, 28],
        OpenPoseModel::Body25 => [14, 22, 30],
    };
    fields[right * CELLS..][..CELLS].fill(-0.8);
    fields[left * CELLS..][..CELLS].fill(0.8);
    fields[(nose + 1) * CELLS..][..CELLS].fill(-0.8);
    let dims = |channels: usize| [1, channels as i64, ROWS as i64, COLUMNS as i64];
    // The mean of 8 x 8 pixels of the first channel, negative, for each heatmap.
    let mut kernel = vec![0.0; parts * 3 * 64];
    for filter in kernel.chunks_mut(3 * 64) {
        filter[..64].fill(-1.0 / 64.0);
    }
    let strides = || vec![ints("strides", &[8, 8]), ints("kernel_shape", &[8, 8])];
    let mut nodes = vec![
        node("Conv", &["image", "kernel"], "means", strides()),
        node("Add", &["means", "constant_heatmaps"], "signed_heatmaps", vec![]),
        node("Relu", &["signed_heatmaps"], "heatmaps", vec![]),
        node("Conv", &["image", "no_kernel"], "nothing", strides()),
        node("Add", &["nothing", "constant_fields"], "fields", vec![]),
    ];
    let outputs = match layout {
        Maps::Apart => vec![("heatmaps", dims(parts)), ("fields", dims(channels))],
        Maps::Stages => vec![
            ("nothing", dims(channels)),
            ("means", dims(parts)),
            ("fields", dims(channels)),
            ("heatmaps", dims(parts)),
        ],
        Maps::Together => {
            nodes.push(node("Concat", &["heatmaps", "fields"], "maps", vec![int("axis", 1)]));
            vec![("maps", dims(parts + channels))]
        }
        Maps::ChannelsLast => {
            let last = || vec![ints("perm", &[0, 2, 3, 1])];
            nodes.push(node("Transpose", &["heatmaps"], "heatmaps_last", last()));
            nodes.push(node("Transpose", &["fields"], "fields_last", last()));
            let dims = |channels: usize| [1, ROWS as i64, COLUMNS as i64, channels as i64];
            vec![("fields_last", dims(channels)), ("heatmaps_last", dims(parts))]
        }
    };
    file(GraphProto {
        node: nodes,
        initializer: vec![
            floats("kernel", &[parts as i64, 3, 8, 8], &kernel),
            floats("no_kernel", &[channels as i64, 3, 8, 8], &vec![0.0; channels * 192]),
            floats("constant_heatmaps", &dims(parts), &heatmaps),
            floats("constant_fields", &dims(channels), &fields),
        ],
        input: vec![value("image", FLOAT, &[1, 3, 96, 128])],
        output: outputs.iter().map(|(name, dims)| value(name, FLOAT, dims)).collect(),
        ..GraphProto::default()
    })
}

/// A network like OpenPose's COCO for images of any size, which shows nobody.
pub(crate) fn openpose_of_any_size() -> Vec<u8> {
    let strides = || vec![ints("strides", &[8, 8]), ints("kernel_shape", &[8, 8])];
    file(GraphProto {
        node: vec![
            node("Conv", &["image", "kernel"], "heatmaps", strides()),
            node("Conv", &["image", "field_kernel"], "fields", strides()),
        ],
        initializer: vec![
            floats("kernel", &[19, 3, 8, 8], &[0.0; 19 * 192]),
            floats("field_kernel", &[38, 3, 8, 8], &[0.0; 38 * 192]),
        ],
        input: vec![value("image", FLOAT, &[0, 3, 0, 0])],
        output: vec![
            value("heatmaps", FLOAT, &[0, 19, 0, 0]),
            value("fields", FLOAT, &[0, 38, 0, 0]),
        ],
        ..GraphProto::default()
    })
}

/// A network of one channel.
pub(crate) fn of_grey_images() -> Vec<u8> {
    file(GraphProto {
        node: vec![node("Relu", &["image"], "positive", vec![])],
        input: vec![value("image", FLOAT, &[1, 1, 16, 16])],
        output: vec![value("positive", FLOAT, &[1, 1, 16, 16])],
        ..GraphProto::default()
    })
}
