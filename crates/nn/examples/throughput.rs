use std::time::Instant;
use burn::module::Module;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::nn::PaddingConfig2d;
use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::{Device, Distribution, Tensor};
use evpose_nn::resnet::{ResNet, ResNetConfig};
#[derive(Module, Debug)]
struct Net { conv1: Conv2d, rn: ResNet }
impl Net { fn forward(&self, x: Tensor<4>) -> Tensor<2> { self.rn.forward(self.conv1.forward(x)) } }
fn main() {
    let cpu = Device::flex();
    let dev = Device::flex().autodiff();
    let batch = 64;
    let set: Vec<String> = std::env::args().skip(1).collect();
    let cases: Vec<(usize, usize, usize)> = if set.is_empty() {
        vec![(120, 90, 16), (120, 90, 24), (120, 90, 32), (80, 60, 16), (80, 60, 32), (240, 180, 16)]
    } else { set.iter().map(|s| { let v: Vec<usize> = s.split('x').map(|p| p.parse().unwrap()).collect(); (v[0], v[1], v[2]) }).collect() };
    for (w, h, width) in cases {
        let make = |d: &Device| Net {
            conv1: Conv2dConfig::new([2, 3], [3, 3]).with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1)).init(d),
            rn: ResNetConfig { blocks: [2, 2, 2, 2], width, outputs: 12 }.init(d),
        };
        let mut net = make(&dev);
        let mut optim = AdamConfig::new().init();
        let x = Tensor::<4>::random([batch, 2, h, w], Distribution::Uniform(0., 1.), &dev);
        let y = Tensor::<2>::random([batch, 12], Distribution::Uniform(0., 1.), &dev);
        let (mut tf, mut tb, mut to) = (vec![], vec![], vec![]);
        let steps = if w == 240 { 4 } else { 7 };
        for _ in 0..steps {
            let t = Instant::now();
            let loss = (net.forward(x.clone()) - y.clone()).powi_scalar(2).mean();
            let l: f32 = loss.clone().into_scalar();
            assert!(l.is_finite());
            tf.push(t.elapsed().as_secs_f64());
            let t = Instant::now();
            let g = loss.backward();
            let g = GradientsParams::from_grads(g, &net);
            tb.push(t.elapsed().as_secs_f64());
            let t = Instant::now();
            net = optim.step(1e-3, net, g);
            to.push(t.elapsed().as_secs_f64());
        }
        let med = |v: &mut Vec<f64>| { v.remove(0); v.sort_by(f64::total_cmp); v[v.len() / 2] };
        let (f, b, o) = (med(&mut tf), med(&mut tb), med(&mut to));
        let net = make(&cpu);
        let x1 = Tensor::<4>::random([1, 2, h, w], Distribution::Uniform(0., 1.), &cpu);
        let mut t1 = vec![];
        for _ in 0..30 { let t = Instant::now(); let _ = net.forward(x1.clone()).into_data(); t1.push(t.elapsed().as_secs_f64()); }
        let l = med(&mut t1);
        println!("{w}x{h} width {width}: {:.0} samples/s (fwd {:.0} ms bwd {:.0} ms adam {:.1} ms /batch 64); latency batch1 {:.2} ms", 64. / (f + b + o), f * 1e3, b * 1e3, o * 1e3, l * 1e3);
    }
}
