//! Shape inference.

use evpose_nn::graph::{ConvLayer, Graph, Node, Operation};

use crate::InferError;

/// Channels, height and width.
pub type Shape = [usize; 3];

/// Shape of every node's output for an input image of shape `input`.
///
/// # Errors
/// [`InferError::Shape`] if a layer cannot take its input.
pub fn infer_shapes(graph: &Graph, input: Shape) -> Result<Vec<Shape>, InferError> {
    let mut shapes: Vec<Shape> = Vec::with_capacity(graph.nodes.len());
    for node in &graph.nodes {
        let inputs: Vec<Shape> = node.inputs.iter().map(|id| shapes[*id]).collect();
        shapes.push(output_shape(node, &inputs, input)?);
    }
    Ok(shapes)
}

fn output_shape(node: &Node, inputs: &[Shape], image: Shape) -> Result<Shape, InferError> {
    let fault = |problem: String| InferError::Shape { layer: node.name.clone(), problem };
    let first = inputs.first().copied().unwrap_or(image);
    let [channels, height, width] = first;
    let shape = match &node.operation {
        Operation::Input => {
            if channels != node.channels {
                return Err(fault(format!("{channels} channels instead of {}", node.channels)));
            }
            image
        }
        Operation::Conv(conv) => {
            let [channels_out, channels_per_group, ..] = conv.shape;
            let expected = channels_per_group * conv.groups;
            if channels != expected {
                return Err(fault(format!("{channels} channels instead of {expected}")));
            }
            let [rows, columns] = conv_size(conv, [height, width]);
            [channels_out, rows, columns]
        }
        Operation::MaxPool { window, stride, padding } => {
            let side = |k: usize, pixels: usize| {
                // A window larger than the padded image fits nowhere: 0, which is an error.
                let room = (pixels + 2 * padding[k]).checked_sub(window[k]);
                room.map_or(0, |room| room / stride[k] + 1)
            };
            [channels, side(0, height), side(1, width)]
        }
        Operation::MeanPool { fields } => [channels, fields[0], fields[1]],
        Operation::Flatten => [channels * height * width, 1, 1],
        Operation::Linear(linear) => {
            if channels != linear.shape[0] {
                return Err(fault(format!("{channels} values instead of {}", linear.shape[0])));
            }
            [linear.shape[1], 1, 1]
        }
        Operation::Channels(range) => [range.len(), height, width],
        Operation::Interleave => [2 * channels, height, width],
        Operation::Concat => {
            if inputs.iter().any(|input| input[1..] != [height, width]) {
                return Err(fault("images of different sizes cannot be joined".to_owned()));
            }
            [inputs.iter().map(|input| input[0]).sum(), height, width]
        }
        Operation::Upsample => [channels, 2 * height, 2 * width],
        Operation::Add if inputs[0] != inputs[1] => {
            let [one, other] = [inputs[0], inputs[1]].map(|[channels, height, width]| {
                format!("{channels} channels of {height}x{width} pixels")
            });
            return Err(fault(format!(
                "{one} cannot be added to {other}; images of another size might fit"
            )));
        }
        _ => first,
    };
    if shape.contains(&0) {
        return Err(fault(format!("nothing is left of an image of {height}x{width} pixels")));
    }
    Ok(shape)
}

/// Height and width of a convolution's output.
fn conv_size(conv: &ConvLayer, size: [usize; 2]) -> [usize; 2] {
    let [top, left, bottom, right] = conv.padding;
    let side = |k: usize, padding: usize| {
        // Extent of the dilated kernel.
        let extent = conv.dilation[k] * (conv.shape[2 + k] - 1) + 1;
        let room = (size[k] + padding).checked_sub(extent);
        room.map_or(0, |room| room / conv.stride[k] + 1)
    };
    [side(0, top + bottom), side(1, left + right)]
}
