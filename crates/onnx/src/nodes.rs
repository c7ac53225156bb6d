//! What an operation is in operators of ONNX.

use evpose_nn::graph::{Activation, ConvLayer, LinearLayer, NodeId, Operation};

use crate::OnnxError;
use crate::writer::{Writer, int, ints, word};

/// Adds the operators of a node.
///
/// # Errors
/// If there are none for it.
pub(crate) fn operation(writer: &mut Writer<'_>, id: NodeId) -> Result<(), OnnxError> {
    let node = writer.node(id);
    let name = writer.name(id).to_owned();
    let inputs: Vec<String> =
        node.inputs.iter().map(|input| writer.name(*input).to_owned()).collect();
    match &node.operation {
        Operation::Input => return Ok(()),
        Operation::Conv(layer) => conv(writer, inputs, name, layer),
        Operation::MaxPool { window, stride, padding } => {
            let [top, left] = *padding;
            let attributes = vec![
                ints("kernel_shape", window),
                ints("strides", stride),
                ints("pads", &[top, left, top, left]),
            ];
            writer.operator("MaxPool", inputs, name, attributes)
        }
        Operation::MeanPool { fields } => {
            let [_, height, width] = writer.shape(node.inputs[0]);
            means(writer, inputs, name, [height, width], *fields)
        }
        Operation::Flatten => writer.operator("Flatten", inputs, name, vec![int("axis", 1)]),
        Operation::Linear(layer) => linear(writer, inputs, name, layer),
        Operation::Add => writer.operator("Add", inputs, name, vec![]),
        Operation::Relu => writer.operator("Relu", inputs, name, vec![]),
        Operation::Channels(range) => {
            let mut inputs = inputs;
            let settings =
                [("starts", range.start as i64), ("ends", range.end as i64), ("axes", 1)];
            for (setting, value) in settings {
                inputs.push(writer.whole(format!("{name}.{setting}"), &[value]));
            }
            writer.operator("Slice", inputs, name, vec![])
        }
        Operation::Interleave => {
            let [channels, height, width] = writer.shape(id);
            interleave(writer, inputs, name, [channels, height, width])
        }
        Operation::Upsample => {
            let scales = writer.floats(format!("{name}.scales"), &[4], &[1.0, 1.0, 2.0, 2.0]);
            // Without a region of interest.
            let inputs = vec![inputs[0].clone(), String::new(), scales];
            let attributes =
                vec![word("coordinate_transformation_mode", "half_pixel"), word("mode", "linear")];
            writer.operator("Resize", inputs, name, attributes)
        }
        Operation::Sigmoid => writer.operator("Sigmoid", inputs, name, vec![]),
        Operation::Affine { factor, offset } => {
            let factor = writer.scalar(format!("{name}.factor"), *factor);
            let offset = writer.scalar(format!("{name}.offset"), *offset);
            let inputs = vec![inputs[0].clone(), factor];
            let products = writer.operator("Mul", inputs, format!("{name}.products"), vec![]);
            writer.operator("Add", vec![products, offset], name, vec![])
        }
        other => {
            // Weights, if it has any, are no help to anyone who reads this.
            let debug = format!("{other:?}");
            let operation = debug.split(['(', '{', ' ']).next().unwrap_or_default().to_owned();
            return Err(OnnxError::Unsupported { layer: node.name.clone(), operation });
        }
    };
    Ok(())
}

fn conv(
    writer: &mut Writer<'_>,
    mut inputs: Vec<String>,
    name: String,
    layer: &ConvLayer,
) -> String {
    inputs.push(writer.floats(format!("{name}.weight"), &layer.shape, &layer.weight));
    inputs.push(writer.floats(format!("{name}.bias"), &[layer.bias.len()], &layer.bias));
    let attributes = vec![
        ints("dilations", &layer.dilation),
        int("group", layer.groups),
        ints("kernel_shape", &layer.shape[2..]),
        ints("pads", &layer.padding),
        ints("strides", &layer.stride),
    ];
    match layer.activation {
        Activation::Identity => writer.operator("Conv", inputs, name, attributes),
        Activation::Relu => {
            let sums = writer.operator("Conv", inputs, format!("{name}.sums"), attributes);
            writer.operator("Relu", vec![sums], name, vec![])
        }
        Activation::Relu6 => {
            let sums = writer.operator("Conv", inputs, format!("{name}.sums"), attributes);
            let least = writer.scalar(format!("{name}.least"), 0.0);
            let most = writer.scalar(format!("{name}.most"), 6.0);
            writer.operator("Clip", vec![sums, least, most], name, vec![])
        }
    }
}

fn linear(
    writer: &mut Writer<'_>,
    mut inputs: Vec<String>,
    name: String,
    layer: &LinearLayer,
) -> String {
    inputs.push(writer.floats(format!("{name}.weight"), &layer.shape, &layer.weight));
    inputs.push(writer.floats(format!("{name}.bias"), &[layer.bias.len()], &layer.bias));
    writer.operator("Gemm", inputs, name, vec![])
}

/// Means over fields. Where fields are not all of one size, ONNX has no operator for it: means over
/// rows, then over columns, are then two matrices.
fn means(
    writer: &mut Writer<'_>,
    inputs: Vec<String>,
    name: String,
    [height, width]: [usize; 2],
    fields: [usize; 2],
) -> String {
    if fields == [1, 1] {
        return writer.operator("GlobalAveragePool", inputs, name, vec![]);
    }
    if height % fields[0] == 0 && width % fields[1] == 0 {
        let window = [height / fields[0], width / fields[1]];
        let attributes = vec![ints("kernel_shape", &window), ints("strides", &window)];
        return writer.operator("AveragePool", inputs, name, attributes);
    }
    let of_rows = shares(height, fields[0]);
    let rows = writer.floats(format!("{name}.rows"), &[fields[0], height], &of_rows);
    let of_columns = transposed(&shares(width, fields[1]), width);
    let columns = writer.floats(format!("{name}.columns"), &[width, fields[1]], &of_columns);
    let over_rows = vec![rows, inputs[0].clone()];
    let over_rows = writer.operator("MatMul", over_rows, format!("{name}.over_rows"), vec![]);
    writer.operator("MatMul", vec![over_rows, columns], name, vec![])
}

/// `[field][pixel]`: by what pixels of a line count in each of its fields. Field `i` of `n` goes from the
/// pixel in which `i / n` of the line lies to the one in which `(i + 1) / n` ends, as in PyTorch.
fn shares(pixels: usize, fields: usize) -> Vec<f32> {
    let mut shares = vec![0.0; fields * pixels];
    for (field, shares) in shares.chunks_mut(pixels).enumerate() {
        let start = field * pixels / fields;
        let end = ((field + 1) * pixels).div_ceil(fields);
        shares[start..end].fill(1.0 / (end - start) as f32);
    }
    shares
}

fn transposed(rows: &[f32], columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|column| rows.iter().skip(column).step_by(columns).copied()).collect()
}

/// The channels of two images in turn: both in a row, as two rows of channels, column by column.
fn interleave(
    writer: &mut Writer<'_>,
    inputs: Vec<String>,
    name: String,
    [channels, height, width]: [usize; 3],
) -> String {
    let sizes = |of: &[usize]| of.iter().map(|size| *size as i64).collect::<Vec<_>>();
    let both = writer.operator("Concat", inputs, format!("{name}.both"), vec![int("axis", 1)]);
    let pairs = writer.whole(format!("{name}.pairs"), &sizes(&[1, 2, channels / 2, height, width]));
    let halves = writer.operator("Reshape", vec![both, pairs], format!("{name}.halves"), vec![]);
    let perm = vec![ints("perm", &[0, 2, 1, 3, 4])];
    let turned = writer.operator("Transpose", vec![halves], format!("{name}.turned"), perm);
    let shape = writer.whole(format!("{name}.shape"), &sizes(&[1, channels, height, width]));
    writer.operator("Reshape", vec![turned, shape], name, vec![])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_overlap_share_pixels_and_each_is_a_mean() {
        // 5 pixels in 3 fields: 0..2, 1..4, 3..5.
        let third = 1.0 / 3.0;
        let expected =
            [[0.5, 0.5, 0.0, 0.0, 0.0], [0.0, third, third, third, 0.0], [0.0, 0.0, 0.0, 0.5, 0.5]];
        let shares = shares(5, 3);
        assert_eq!(shares, expected.concat());
        let by_pixel = transposed(&shares, 5);
        assert_eq!(by_pixel[..6], [0.5, 0.0, 0.0, 0.5, third, 0.0]);
    }
}
