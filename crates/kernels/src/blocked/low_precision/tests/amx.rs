//! Convolution by tiles, on an emulation of AMX: against plain loops and the kernel of vector
//! registers.

use super::*;
use crate::blocked::low_precision::conv::Arithmetic;
use crate::simd::ReducedDispatch;
use crate::simd::tiles::TileElement as _;

/// A convolution and the size of its input.
#[derive(Debug, Clone, Copy)]
struct Case {
    shape: ConvShape,
    size: [usize; 2],
}

/// Channels, rows and columns that fill tiles, and that do not.
fn cases() -> impl Strategy<Value = Case> {
    let channels_in = prop_oneof![Just(16_usize), Just(32), 1..50_usize];
    let channels_out = prop_oneof![Just(16_usize), Just(32), 1..70_usize];
    let kernel = prop::sample::select(vec![1_usize, 3, 3, 5, 7]);
    let width = prop_oneof![Just(16_usize), Just(32), 1..75_usize];
    (channels_in, channels_out, kernel, 1..3_usize, 1..6_usize, width).prop_map(
        |(channels_in, channels_out, kernel, stride, height, width)| Case {
            shape: ConvShape::square(channels_in, channels_out, kernel, stride),
            size: [height, width],
        },
    )
}

impl Case {
    fn input(&self, seed: u64, element_type: LowPrecisionType) -> LowPrecisionImage {
        let [height, width] = self.size;
        let size = [self.shape.channels_in, height, width];
        packed(&random_values(seed, size.iter().product()), size, self.shape.border(), element_type)
    }

    fn weight(&self, seed: u64) -> Vec<f32> {
        let ConvShape { channels_in, channels_out, .. } = self.shape;
        random_values(seed ^ 1, channels_out * channels_in * self.shape.taps())
    }

    /// Channels, height and width of the output.
    fn output(&self) -> [usize; 3] {
        let [height, width] = self.shape.output(self.size);
        [self.shape.channels_out, height, width]
    }
}

/// Outputs of a convolution of `level`, in f32 and of type `to`.
struct Outputs {
    whole: Image,
    packed: LowPrecisionImage,
}

/// Images that a convolution reads and writes.
struct Operands<'a> {
    input: &'a LowPrecisionImage,
    residual: Option<&'a LowPrecisionImage>,
    activation: Activation,
    /// Element type of the output.
    to: LowPrecisionType,
}

impl Operands<'_> {
    fn run(&self, thread_pool: &ThreadPool, conv: &LowPrecisionConv) -> Outputs {
        let [_, height, width] = self.input.size();
        let [height, width] = conv.shape().output([height, width]);
        let channels = conv.shape().channels_out;
        let mut whole = Image::zeros(channels, height, width, 0);
        let mut packed = LowPrecisionImage::zeros([channels, height, width], 1, self.to);
        for output in [TensorViewMut::F32(&mut whole), TensorViewMut::LowPrecision(&mut packed)] {
            let residual = self.residual.map(TensorView::LowPrecision);
            conv.run(thread_pool, self.input, residual, self.activation, output);
        }
        Outputs { whole, packed }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn tiles_match_plain_loops_on_quantised_values(
        case in cases(),
        activation in activations(),
        has_residual: bool,
        element_type in element_types(),
        threads in 1..4_usize,
        seed: u64,
    ) {
        let Case { shape, size } = case;
        let input = case.input(seed, element_type);
        let weight = case.weight(seed);
        let bias = random_values(seed ^ 2, shape.channels_out);
        let residual = random_values(seed ^ 3, case.output().iter().product());
        let residual = packed(&residual, case.output(), 0, element_type);
        let added = unpacked(&residual);
        let after = ReferenceEpilogue { bias: &bias, residual: has_residual.then_some(&added), activation };
        let (from, by) = (unpacked(&input), round_trip_weights(&weight, shape.channels_out, element_type));
        let expected = after.apply(reference_conv(shape, &from, size, &by));
        let magnitude = magnitude(shape, &from, size, &by);
        let operands = Operands {
            input: &input,
            residual: has_residual.then_some(&residual),
            activation,
            to: element_type,
        };
        for level in Level::available() {
            let conv = LowPrecisionConv::with_arithmetic(
                shape, &weight, &bias, element_type, level, Arithmetic::EmulatedAmx,
            );
            prop_assert!(conv.uses_amx());
            let output = operands.run(&ThreadPool::new(threads), &conv).whole;
            let off = max_abs_difference(&planes(&output), &expected);
            prop_assert!(off <= 1e-6 * magnitude, "{level} {element_type:?}: {off}, {magnitude}");
            prop_assert!(output.is_zero_outside());
        }
    }

    #[test]
    fn tiles_of_bytes_give_the_bits_of_vector_registers(
        case in cases(),
        activation in activations(),
        has_residual: bool,
        [low, high] in [-1.5_f32..-0.5, 0.5_f32..1.5],
        threads in 1..4_usize,
        seed: u64,
    ) {
        let element_type = LowPrecisionType::Uint8(QuantizationParams::from_range(low, high));
        let shape = case.shape;
        let (input, weight) = (case.input(seed, element_type), case.weight(seed));
        let bias = random_values(seed ^ 2, shape.channels_out);
        let residual = random_values(seed ^ 3, case.output().iter().product());
        let residual = packed(&residual, case.output(), 0, element_type);
        let operands = Operands {
            input: &input,
            residual: has_residual.then_some(&residual),
            activation,
            to: LowPrecisionType::Uint8(QuantizationParams::from_range(2.0 * low, 2.0 * high)),
        };
        // Where bytes are widened to f32, longer sums are rounded on their way.
        let are_sums_exact = shape.channels_in * shape.taps() * 255 * 127 < 1 << 24;
        for level in Level::available() {
            if !are_sums_exact && <u8 as ReducedDispatch>::dot_depth(level) == 1 { continue; }
            let [vectors, tiles] = [Arithmetic::Vectors, Arithmetic::EmulatedAmx].map(|arithmetic| {
                let conv = LowPrecisionConv::with_arithmetic(
                    shape, &weight, &bias, element_type, level, arithmetic,
                );
                operands.run(&ThreadPool::new(threads), &conv)
            });
            prop_assert_eq!(bits(&planes(&tiles.whole)), bits(&planes(&vectors.whole)), "{}", level);
            prop_assert_eq!(unpacked(&tiles.packed), unpacked(&vectors.packed), "{}", level);
        }
    }

    #[test]
    fn tiles_of_bytes_are_exact(case in cases(), zero_point: u8, threads in 1..4_usize, seed: u64) {
        let Case { shape, size } = case;
        // Steps of 1 for inputs and weights: outputs are the integers of the sums.
        let element_type = LowPrecisionType::Uint8(QuantizationParams { scale: 1.0, zero_point });
        let [height, width] = size;
        let input = random_values(seed, shape.channels_in * height * width);
        let input = input.iter().map(|value| (value * 128.0).round()).collect::<Vec<_>>();
        let input = packed(&input, [shape.channels_in, height, width], shape.border(), element_type);
        let mut weight = case.weight(seed).iter().map(|value| (value * 127.0).round()).collect::<Vec<_>>();
        for kernel in weight.chunks_mut(shape.channels_in * shape.taps()) {
            kernel[0] = 127.0;
        }
        let expected = reference_conv(shape, &unpacked(&input), size, &weight);
        let largest = magnitude(shape, &unpacked(&input), size, &weight);
        prop_assume!(2.0 * largest < f64::from(1 << 23), "sums that f32 holds");
        let operands = Operands {
            input: &input,
            residual: None,
            activation: Activation::Identity,
            to: element_type,
        };
        let bias = vec![0.0; shape.channels_out];
        for level in Level::available() {
            let conv = LowPrecisionConv::with_arithmetic(
                shape, &weight, &bias, element_type, level, Arithmetic::EmulatedAmx,
            );
            let output = planes(&operands.run(&ThreadPool::new(threads), &conv).whole);
            let output = output.into_iter().map(f64::from).collect::<Vec<_>>();
            prop_assert_eq!(&output, &expected, "{}", level);
        }
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn amx_is_chosen_where_it_is_and_a_block_of_channels_is_full() {
    let int8 = LowPrecisionType::Uint8(QuantizationParams::from_range(0.0, 1.0));
    for level in Level::available() {
        for (channels, is_full) in [(15, false), (16, true)] {
            let shape = ConvShape::square(channels, 4, 1, 1);
            let uses_amx = |element_type| {
                let weight = vec![1.0; 4 * channels];
                LowPrecisionConv::new(shape, &weight, &[0.0; 4], element_type, level).uses_amx()
            };
            assert_eq!(uses_amx(int8), is_full && u8::has_amx(level), "{level}");
            assert_eq!(
                uses_amx(LowPrecisionType::Bf16),
                is_full && Bf16::has_amx(level),
                "{level}"
            );
        }
    }
    // Tiles need 16 lanes beside them.
    assert!(!u8::has_amx(Level::Portable) && !Bf16::has_amx(Level::Portable));
}

#[test]
#[ignore = "needs AMX of the processor: `cargo xtask ci` runs it where that has it"]
fn tiles_of_the_processor_match_the_emulated_ones() {
    let level = Level::best();
    assert!(u8::has_amx(level) && Bf16::has_amx(level), "AMX");
    let int8 = LowPrecisionType::Uint8(QuantizationParams::from_range(-1.0, 1.0));
    for element_type in [LowPrecisionType::Bf16, int8] {
        for (kernel, stride, width) in [(1, 1, 20), (3, 1, 33), (3, 2, 50), (7, 2, 40)] {
            let shape = ConvShape::square(40, 72, kernel, stride);
            let case = Case { shape, size: [9, width] };
            let (input, weight) = (case.input(1, element_type), case.weight(1));
            let bias = random_values(2, shape.channels_out);
            let operands = Operands {
                input: &input,
                residual: None,
                activation: Activation::Relu,
                to: element_type,
            };
            let conv = LowPrecisionConv::new(shape, &weight, &bias, element_type, level);
            assert!(conv.uses_amx());
            let emulated = LowPrecisionConv::with_arithmetic(
                shape,
                &weight,
                &bias,
                element_type,
                level,
                Arithmetic::EmulatedAmx,
            );
            let [output, expected] =
                [&conv, &emulated].map(|conv| operands.run(&ThreadPool::new(2), conv));
            assert_eq!(bits(&planes(&output.whole)), bits(&planes(&expected.whole)), "{case:?}");
        }
    }
}
