//! Translation of operations to ONNX operators.

use evpose_nn::graph::{Activation, ConvLayer, LinearLayer, NodeId, Operation};

use crate::onnx::OnnxError;
use crate::onnx::writer::{Writer, int, ints, string};

/// Adds the operators of a node.
///
/// # Errors
/// [`OnnxError::Unsupported`] for an operation without a translation.
pub(crate) fn add_operators(writer: &mut Writer<'_>, id: NodeId) -> Result<(), OnnxError> {
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
            avg_pool(writer, inputs, name, [height, width], *fields)
        }
        Operation::Flatten => writer.operator("Flatten", inputs, name, vec![int("axis", 1)]),
        Operation::Linear(layer) => linear(writer, inputs, name, layer),
        Operation::Add => writer.operator("Add", inputs, name, vec![]),
        Operation::Relu => writer.operator("Relu", inputs, name, vec![]),
        Operation::Channels(range) => {
            // Since opset 10 the bounds of a slice are tensors, not attributes.
            let mut inputs = inputs;
            let bounds = [("starts", range.start as i64), ("ends", range.end as i64), ("axes", 1)];
            for (input, value) in bounds {
                inputs.push(writer.integers(format!("{name}.{input}"), &[value]));
            }
            writer.operator("Slice", inputs, name, vec![])
        }
        Operation::Interleave => {
            let [channels, height, width] = writer.shape(id);
            interleave(writer, inputs, name, [channels, height, width])
        }
        Operation::Concat => writer.operator("Concat", inputs, name, vec![int("axis", 1)]),
        Operation::Upsample => {
            let scales = writer.floats(format!("{name}.scales"), &[4], &[1.0, 1.0, 2.0, 2.0]);
            // The empty name leaves out the optional region of interest.
            let inputs = vec![inputs[0].clone(), String::new(), scales];
            // Both together are PyTorch's bilinear interpolation without aligned corners.
            let attributes = vec![
                string("coordinate_transformation_mode", "half_pixel"),
                string("mode", "linear"),
            ];
            writer.operator("Resize", inputs, name, attributes)
        }
        Operation::Sigmoid => writer.operator("Sigmoid", inputs, name, vec![]),
        Operation::Affine { factor, offset } => {
            let factor = writer.scalar(format!("{name}.factor"), *factor);
            let offset = writer.scalar(format!("{name}.offset"), *offset);
            let inputs = vec![inputs[0].clone(), factor];
            let scaled = writer.operator("Mul", inputs, format!("{name}.products"), vec![]);
            writer.operator("Add", vec![scaled, offset], name, vec![])
        }
        other => {
            // The name of the variant, without its weights.
            let debug = format!("{other:?}");
            let operation = debug.split(['(', '{', ' ']).next().unwrap_or_default().to_owned();
            return Err(OnnxError::Unsupported { layer: node.name.clone(), operation });
        }
    };
    Ok(())
}

/// Conv with its activation: Relu, or Clip for ReLU6.
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
        // ONNX's convolution has no activation: another operator takes its sums.
        Activation::Relu => {
            let sums = writer.operator("Conv", inputs, format!("{name}.sums"), attributes);
            writer.operator("Relu", vec![sums], name, vec![])
        }
        Activation::Relu6 => {
            let sums = writer.operator("Conv", inputs, format!("{name}.sums"), attributes);
            // Since opset 11, bounds are inputs.
            let min = writer.scalar(format!("{name}.least"), 0.0);
            let max = writer.scalar(format!("{name}.most"), 6.0);
            writer.operator("Clip", vec![sums, min, max], name, vec![])
        }
    }
}

/// Gemm: a fully connected layer.
fn linear(
    writer: &mut Writer<'_>,
    mut inputs: Vec<String>,
    name: String,
    layer: &LinearLayer,
) -> String {
    // The weight is stored as inputs by outputs, as Gemm takes it without `transB`.
    inputs.push(writer.floats(format!("{name}.weight"), &layer.shape, &layer.weight));
    inputs.push(writer.floats(format!("{name}.bias"), &[layer.bias.len()], &layer.bias));
    writer.operator("Gemm", inputs, name, vec![])
}

/// Adaptive average pooling to `fields` rows and columns. ONNX has no operator for it if windows
/// differ in size: it is then a product with a matrix of means over rows, and one with a matrix of
/// means over columns.
fn avg_pool(
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
    // Means over rectangles separate: two small products do for one of all pixels.
    let row_weights = averaging_matrix(height, fields[0]);
    let rows = writer.floats(format!("{name}.rows"), &[fields[0], height], &row_weights);
    let column_weights = transposed(&averaging_matrix(width, fields[1]), width);
    let columns = writer.floats(format!("{name}.columns"), &[width, fields[1]], &column_weights);
    let over_rows = vec![rows, inputs[0].clone()];
    let over_rows = writer.operator("MatMul", over_rows, format!("{name}.over_rows"), vec![]);
    writer.operator("MatMul", vec![over_rows, columns], name, vec![])
}

/// Matrix `[fields][pixels]` that averages a line of pixels over each of its fields. Of `n` fields,
/// field `i` is the range `floor(i pixels / n)..ceil((i + 1) pixels / n)`, as in PyTorch's
/// `adaptive_avg_pool2d`.
fn averaging_matrix(pixels: usize, fields: usize) -> Vec<f32> {
    let mut matrix = vec![0.0; fields * pixels];
    for (field, weights) in matrix.chunks_mut(pixels).enumerate() {
        let start = field * pixels / fields;
        let end = ((field + 1) * pixels).div_ceil(fields);
        weights[start..end].fill(1.0 / (end - start) as f32);
    }
    matrix
}

/// Transpose of a row-major matrix.
fn transposed(rows: &[f32], columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|column| rows.iter().skip(column).step_by(columns).copied()).collect()
}

/// Interleaves the channels of two images: concatenated, reshaped to `[2, channels / 2]`, and
/// transposed. A size of 0 in a shape is that of the input: any batch.
fn interleave(
    writer: &mut Writer<'_>,
    inputs: Vec<String>,
    name: String,
    [channels, height, width]: [usize; 3],
) -> String {
    let sizes = |of: &[usize]| of.iter().map(|size| *size as i64).collect::<Vec<_>>();
    let concatenated =
        writer.operator("Concat", inputs, format!("{name}.both"), vec![int("axis", 1)]);
    let pairs =
        writer.integers(format!("{name}.pairs"), &sizes(&[0, 2, channels / 2, height, width]));
    let halves =
        writer.operator("Reshape", vec![concatenated, pairs], format!("{name}.halves"), vec![]);
    let perm = vec![ints("perm", &[0, 2, 1, 3, 4])];
    let transposed = writer.operator("Transpose", vec![halves], format!("{name}.turned"), perm);
    let shape = writer.integers(format!("{name}.shape"), &sizes(&[0, channels, height, width]));
    writer.operator("Reshape", vec![transposed, shape], name, vec![])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_may_overlap_and_each_is_a_mean() {
        // 5 pixels in 3 fields: 0..2, 1..4, 3..5.
        let third = 1.0 / 3.0;
        let expected =
            [[0.5, 0.5, 0.0, 0.0, 0.0], [0.0, third, third, third, 0.0], [0.0, 0.0, 0.0, 0.5, 0.5]];
        let matrix = averaging_matrix(5, 3);
        assert_eq!(matrix, expected.concat());
        let by_pixel = transposed(&matrix, 5);
        assert_eq!(by_pixel[..6], [0.5, 0.0, 0.0, 0.5, third, 0.0]);
    }
}
