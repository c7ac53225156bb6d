use std::time::Instant;
use burn::nn::conv::Conv2dConfig;
use burn::nn::pool::MaxPool2dConfig;
use burn::nn::{BatchNormConfig, PaddingConfig2d};
use burn::tensor::{Device, Distribution, Tensor};
fn time(name: &str, shape: [usize; 4], req: bool, f: impl Fn(Tensor<4>) -> Tensor<4>) {
    let dev = Device::flex().autodiff();
    let (mut tf, mut tb) = (vec![], vec![]);
    let mut mac = 0;
    for _ in 0..9 {
        let mut x = Tensor::<4>::random(shape, Distribution::Uniform(-1., 1.), &dev);
        if req { x = x.require_grad(); }
        let t = Instant::now();
        let y = f(x);
        mac = y.dims().iter().product::<usize>();
        tf.push(t.elapsed().as_secs_f64());
        let g = Tensor::<4>::random(y.dims(), Distribution::Uniform(-1., 1.), &dev);
        let l = (y * g).sum();
        let t = Instant::now();
        let _ = l.backward();
        tb.push(t.elapsed().as_secs_f64());
    }
    let med = |v: &mut Vec<f64>| { v.remove(0); v.sort_by(f64::total_cmp); v[v.len() / 2] * 1e3 };
    println!("{name:28} {shape:?} fwd {:.2} ms bwd(+mul) {:.2} ms  [{mac} out]", med(&mut tf), med(&mut tb));
}
fn main() {
    let dev = Device::flex().autodiff();
    let conv = |i, o, k: usize, s| Conv2dConfig::new([i, o], [k, k]).with_stride([s, s]).with_bias(false).with_padding(PaddingConfig2d::Explicit(k / 2, k / 2, k / 2, k / 2)).init(&dev);
    let b = 64; let c = 16;
    let l = conv(2, 3, 3, 1); time("conv 2-3", [b, 2, 90, 120], false, |x| l.forward(x));
    let l = conv(3, c, 7, 2); time("stem 7x7", [b, 3, 90, 120], true, |x| l.forward(x));
    let l = conv(3, c, 7, 2); time("stem s2d", [b, 3, 90, 120], true, |x| evpose_nn::resnet::stem(&l, x));
    let x = Tensor::<4>::random([2, 3, 91, 120], Distribution::Uniform(-1., 1.), &dev); println!("diff {}", (l.forward(x.clone()) - evpose_nn::resnet::stem(&l, x)).abs().max().into_scalar::<f32>());
    let l = conv(3, c, 7, 2); time("stem 7x7 no xgrad", [b, 3, 90, 120], false, |x| l.forward(x));
    let l = BatchNormConfig::new(c).init(&dev); time("bn1", [b, c, 45, 60], true, |x| l.forward(x));
    time("relu", [b, c, 45, 60], true, burn::tensor::activation::relu);
    time("identity", [b, c, 45, 60], true, |x| x);
    time("x+x", [b, c, 45, 60], true, |x| x.clone() + x);
    let l = MaxPool2dConfig::new([3, 3]).with_strides([2, 2]).with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1)).init();
    time("maxpool", [b, c, 45, 60], true, |x| l.forward(x));
    let l = conv(c, c, 3, 1); time("l1 3x3 (x4)", [b, c, 23, 30], true, |x| l.forward(x));
    let l = BatchNormConfig::new(c).init(&dev); time("l1 bn (x4)", [b, c, 23, 30], true, |x| l.forward(x));
    let l = conv(c, 2 * c, 3, 2); time("l2 3x3 s2", [b, c, 23, 30], true, |x| l.forward(x));
    let l = conv(c, 2 * c, 1, 2); time("l2 1x1 s2", [b, c, 23, 30], true, |x| l.forward(x));
    let l = conv(2 * c, 2 * c, 3, 1); time("l2 3x3 (x3)", [b, 2 * c, 12, 15], true, |x| l.forward(x));
    let l = BatchNormConfig::new(2 * c).init(&dev); time("l2 bn (x5)", [b, 2 * c, 12, 15], true, |x| l.forward(x));
    let l = conv(4 * c, 4 * c, 3, 1); time("l3 3x3 (x3)", [b, 4 * c, 6, 8], true, |x| l.forward(x));
    let l = conv(8 * c, 8 * c, 3, 1); time("l4 3x3 (x3)", [b, 8 * c, 3, 4], true, |x| l.forward(x));
    let l = BatchNormConfig::new(8 * c).init(&dev); time("l4 bn (x5)", [b, 8 * c, 3, 4], true, |x| l.forward(x));
}
