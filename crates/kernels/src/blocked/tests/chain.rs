//! Fused layers give the same bits as layers run one by one.

use proptest::prelude::*;

use super::{activations, image, random_values};
use crate::Level;
use crate::blocked::*;

/// Kind of a layer and its random parameters.
type Drawn = (u8, usize, usize, Activation);

/// A layer for an input of `channels` channels.
fn link((kind, size, stride, activation): Drawn, channels: usize, level: Level, seed: u64) -> Link {
    let values = |count: usize| random_values(seed, count);
    match kind {
        0 => {
            let channels_out = 1 + size * 9;
            let kernel = [1, 3, 5][size % 3];
            let shape = ConvShape::square(channels, channels_out, kernel, stride);
            let weight = values(channels * channels_out * kernel * kernel);
            Link::Conv(
                Conv::new(shape, &weight, &random_values(seed ^ 1, channels_out), level),
                activation,
            )
        }
        1 => {
            let kernel = [3, 5][size % 2];
            let shape = DepthwiseShape { channels, kernel, stride };
            let (weight, bias) =
                (values(channels * kernel * kernel), random_values(seed ^ 1, channels));
            Link::Depthwise(Depthwise::new(shape, &weight, &bias, level), activation)
        }
        _ => Link::MaxPool(MaxPool { window: 2 + size % 2, stride, padding: size % 2 }),
    }
}

/// Output of one layer run by itself.
fn alone(
    thread_pool: &ThreadPool,
    level: Level,
    link: &Link,
    input: &Image,
    residual: Option<&Image>,
) -> Image {
    let chain = Chain::new(vec![link.clone()], sizes(input), level);
    let [channels, height, width] = chain.output();
    let mut output = Image::zeros(channels, height, width, 2);
    match link {
        Link::Conv(conv, activation) => {
            conv.run(thread_pool, input, residual, *activation, &mut output);
        }
        Link::Depthwise(conv, activation) => {
            conv.run(thread_pool, input, *activation, TensorViewMut::F32(&mut output));
        }
        Link::MaxPool(pool) => pool.run(thread_pool, level, input, &mut output),
        Link::Nchw(..) => unreachable!("not drawn"),
    }
    output
}

fn sizes(image: &Image) -> [usize; 3] {
    [image.channels(), image.height(), image.width()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn fused_layers_match_layers_one_by_one(
        seed in any::<u64>(),
        drawn in prop::collection::vec((0_u8..3, 0_usize..4, 1_usize..=2, activations()), 1..5),
        (channels, height, width) in (1_usize..40, 8_usize..40, 8_usize..20),
        (threads, has_residual) in (1_usize..4, any::<bool>()),
    ) {
        let thread_pool = ThreadPool::new(threads);
        for level in Level::available() {
            let input = image(&random_values(seed, channels * height * width), channels, [height, width], 2);
            let (mut links, mut now, mut before) = (Vec::new(), input.clone(), input.clone());
            for (at, drawn) in drawn.iter().enumerate() {
                let link = link(*drawn, now.channels(), level, seed ^ (at as u64) << 8);
                before = now;
                now = alone(&thread_pool, level, &link, &before, None);
                prop_assume!(now.height() > 0 && now.width() > 0);
                links.push(link);
            }
            let [out, rows, columns] = sizes(&now);
            let residual = (has_residual && matches!(links.last(), Some(Link::Conv(..))))
                .then(|| image(&random_values(seed ^ 9, out * rows * columns), out, [rows, columns], 0));
            if let (Some(residual), Some(last)) = (&residual, links.last()) {
                now = alone(&thread_pool, level, last, &before, Some(residual));
            }
            let chain = Chain::new(links, sizes(&input), level);
            let mut output = Image::zeros(out, rows, columns, 2);
            // Memory holds whatever another layer left.
            let mut scratch = Scratch::default();
            for _ in 0..2 {
                let source = ChainInput::Image(&input);
                chain.run(&thread_pool, source, residual.as_ref(), &mut output, &mut scratch);
                prop_assert_eq!(output.lines(), now.lines(), "{}", level);
            }
        }
    }

    #[test]
    fn the_first_layer_may_take_nchw(seed in any::<u64>(), rows in 4_usize..40, threads in 1_usize..4) {
        let (thread_pool, size) = (ThreadPool::new(threads), [2, rows, 21]);
        for level in Level::available() {
            let few = ConvShape::square(2, 3, 3, 1);
            let few = NchwConv::new(few, &random_values(seed, 54), &random_values(seed, 3), level);
            let stem = ConvShape::square(3, 20, 7, 2);
            let stem = Conv::new(stem, &random_values(seed, 3 * 20 * 49), &random_values(seed, 20), level);
            let mut planes = NchwImage::zeros(size, 1);
            planes.copy_from(&thread_pool, level, &random_values(seed, size.iter().product()), [1.0, 0.0]);

            let mut between = Image::zeros(3, rows, 21, 3);
            few.run(&thread_pool, &planes, Activation::Relu, TensorViewMut::F32(&mut between));
            let mut one_by_one = Image::zeros(20, rows.div_ceil(2), 11, 0);
            stem.run(&thread_pool, &between, None, Activation::Relu, &mut one_by_one);

            let links = vec![Link::Nchw(few, Activation::Relu), Link::Conv(stem, Activation::Relu)];
            let chain = Chain::new(links, size, level);
            let mut fused = Image::zeros(20, rows.div_ceil(2), 11, 0);
            let mut scratch = Scratch::default();
            chain.run(&thread_pool, ChainInput::Nchw(&planes), None, &mut fused, &mut scratch);
            prop_assert_eq!(fused.lines(), one_by_one.lines());
        }
    }

    #[test]
    fn convolutions_of_nchw_and_nchw16c_agree(
        seed in any::<u64>(),
        (channels_in, channels_out) in (1_usize..6, 1_usize..40),
        (half, stride) in (0_usize..4, 1_usize..=2),
        (height, width) in (4_usize..40, 4_usize..30),
        threads in 1_usize..4,
    ) {
        let (thread_pool, size) = (ThreadPool::new(threads), [channels_in, height, width]);
        let values = random_values(seed, size.iter().product());
        for level in Level::available() {
            let kernel = 2 * half + 1;
            let shape = ConvShape::square(channels_in, channels_out, kernel, stride);
            let weight = random_values(seed ^ 1, channels_in * channels_out * kernel * kernel);
            let conv = Conv::new(shape, &weight, &random_values(seed ^ 2, channels_out), level);
            let [rows, columns] = shape.output([height, width]);
            let mut outputs = [(); 3].map(|()| Image::zeros(channels_out, rows, columns, 1));
            let [of_blocks, of_planes, of_chain] = &mut outputs;
            let blocks = image(&values, channels_in, [height, width], half);
            conv.run(&thread_pool, &blocks, None, Activation::Relu, of_blocks);
            let mut planes = NchwImage::zeros(size, half);
            planes.copy_from(&thread_pool, level, &values, [1.0, 0.0]);
            conv.run_nchw(&thread_pool, &planes, Activation::Relu, of_planes);
            let chain = Chain::new(vec![Link::Conv(conv, Activation::Relu)], size, level);
            let source = ChainInput::Nchw(&planes);
            chain.run(&thread_pool, source, None, of_chain, &mut Scratch::default());
            prop_assert_eq!(outputs[0].lines(), outputs[1].lines(), "{}", level);
            prop_assert_eq!(outputs[0].lines(), outputs[2].lines(), "{}", level);
        }
    }
}
