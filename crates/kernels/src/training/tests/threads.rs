use super::*;
use crate::Level;

/// Results of `each` on one, two and three threads.
fn on_threads<T: Send>(each: impl Fn() -> T + Sync) -> [T; 3] {
    [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(&each)
    })
}

/// A normalised batch of noise.
fn batch(shape: Blocks) -> (Vec<f32>, Norm) {
    let x = shape.from_planes(&noise(1, shape.batch * shape.channels * shape.height * shape.width));
    let ones = vec![1.0; shape.channels];
    let norm = Norm::new(&Norm::statistics(&shape, &x), &ones, &ones, 1e-5, Activation::Relu);
    (x, norm)
}

#[test]
fn results_are_the_same_bits_on_any_number_of_threads() {
    for (channels, size, kernel, stride) in [
        ([64, 64], [45, 60], 3, 1),
        ([40, 80], [12, 15], 3, 2),
        ([3, 64], [31, 40], 7, 2),
        ([16, 40], [24, 24], 1, 1),
    ] {
        let input = Blocks { batch: 5, channels: channels[0], height: size[0], width: size[1] };
        let conv = Conv { input, channels_out: channels[1], kernel, stride, level: Level::best() };
        let depthwise = Depthwise { input, kernel, stride, level: Level::best() };
        let w = noise(2, channels[0] * channels[1] * kernel * kernel);
        let all = on_threads(|| {
            let (x, norm) = batch(input);
            let from = NormalizedInput { values: &x, norm: Some(&norm) };
            let y = conv.forward(from, &w, None);
            let mut dx = conv.backward_input(&w, &y);
            let gradients = norm.backward(&input, &x, &mut dx);
            let of_conv = (conv.backward_weight(from, &y), y, dx, gradients);
            let w = &w[..channels[0] * kernel * kernel];
            let y = depthwise.forward(from, w, None);
            let dx = depthwise.backward_input(w, &y);
            (of_conv, depthwise.backward_weight(from, &y), y, dx)
        });
        assert!(all[0] == all[1] && all[0] == all[2], "{channels:?}");
    }
}
