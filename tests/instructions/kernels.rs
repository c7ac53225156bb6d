//! The kernels whose instructions are counted: small inputs, one thread.

use std::hint::black_box;

use anyhow::{Context, Result};
use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::FORMATS;
use evpose_kernels::Level;
use evpose_kernels::blocked::{
    Activation, Conv, ConvShape, Depthwise, DepthwiseShape, Image, Scratch, TensorViewMut,
    ThreadPool, TileSize, Winograd,
};
use evpose_kernels::training;
use evpose_repr::{ChannelOrder, StreamWindow, representation_by_name};
use evpose_sensor::SensorModel;

use crate::scene;

/// A prepared kernel.
pub(crate) type Run = Box<dyn FnMut()>;

pub(crate) struct CountedKernel {
    pub(crate) name: &'static str,
    pub(crate) prepare: fn() -> Result<Run>,
}

/// All of them.
pub(crate) const KERNELS: &[CountedKernel] = &[
    CountedKernel { name: "convolution", prepare: convolution },
    CountedKernel { name: "winograd", prepare: winograd },
    CountedKernel { name: "pointwise", prepare: pointwise },
    CountedKernel { name: "depthwise", prepare: depthwise },
    CountedKernel { name: "weight-gradient", prepare: weight_gradient },
    CountedKernel { name: "lnes", prepare: || update("lnes") },
    CountedKernel { name: "eros", prepare: || update("eros") },
    CountedKernel { name: "voxel-grid", prepare: || update("voxel-grid") },
    CountedKernel { name: "sensor", prepare: sensor },
    CountedKernel { name: "evt3", prepare: evt3 },
];

const SENSOR: SensorSize = SensorSize::DAVIS240C;

/// The function inside which callgrind counts, which finds it by its name.
#[inline(never)]
pub(crate) fn measured(run: &mut dyn FnMut()) {
    run();
    black_box(());
}

fn values(count: usize) -> Vec<f32> {
    let mut rng = CounterRng::new(3, "kernels", 0);
    (0..count).map(|_| rng.uniform(-0.5, 0.5)).collect()
}

fn image(channels: usize, [height, width]: [usize; 2]) -> Image {
    let mut image = Image::zeros(channels, height, width, 1);
    image.copy_from_nchw(&values(channels * height * width));
    image
}

fn direct(shape: ConvShape, size: [usize; 2]) -> Run {
    let weight = values(shape.channels_in * shape.channels_out * shape.taps());
    let conv = Conv::new(shape, &weight, &values(shape.channels_out), Level::best());
    let input = image(shape.channels_in, size);
    let [height, width] = shape.output(size);
    let mut output = Image::zeros(shape.channels_out, height, width, 1);
    let pool = ThreadPool::new(1);
    Box::new(move || conv.run(&pool, &input, None, Activation::Relu, &mut output))
}

fn convolution() -> Result<Run> {
    Ok(direct(ConvShape::square(32, 64, 3, 2), [24, 32]))
}

fn pointwise() -> Result<Run> {
    Ok(direct(ConvShape::square(96, 192, 1, 1), [12, 12]))
}

fn winograd() -> Result<Run> {
    let weight = values(64 * 64 * 9);
    let conv = Winograd::new([64, 64], &weight, &values(64), TileSize::Four, Level::best());
    let input = image(64, [24, 32]);
    let mut output = Image::zeros(64, 24, 32, 1);
    let (pool, mut scratch) = (ThreadPool::new(1), Scratch::default());
    Ok(Box::new(move || {
        conv.run(&pool, &input, None, Activation::Relu, &mut output, &mut scratch);
    }))
}

fn depthwise() -> Result<Run> {
    let shape = DepthwiseShape { channels: 144, kernel: 5, stride: 1 };
    let conv = Depthwise::new(shape, &values(144 * 25), &values(144), Level::best());
    let mut input = Image::zeros(144, 24, 24, 2);
    input.copy_from_nchw(&values(144 * 24 * 24));
    let mut output = Image::zeros(144, 24, 24, 2);
    let pool = ThreadPool::new(1);
    Ok(Box::new(move || {
        conv.run(&pool, &input, Activation::Relu6, TensorViewMut::F32(&mut output));
    }))
}

fn weight_gradient() -> Result<Run> {
    let input = training::Blocks { batch: 2, channels: 32, height: 16, width: 24 };
    let conv =
        training::Conv { input, channels_out: 32, kernel: 3, stride: 1, level: Level::best() };
    let image = input.from_planes(&values(2 * 32 * 16 * 24));
    let gradient = conv.output().from_planes(&values(2 * 32 * 16 * 24));
    Ok(Box::new(move || {
        black_box(conv.backward_weight(image[..].into(), &gradient));
    }))
}

/// Events everywhere, 20 ms of them.
fn events() -> Result<EventStream> {
    let mut rng = CounterRng::new(8, "events", 0);
    let event = |i: i64| Event {
        t: Micros(i),
        x: rng.below(SENSOR.width.into()) as u16,
        y: rng.below(SENSOR.height.into()) as u16,
        polarity: Polarity::from_on(i % 3 == 0),
    };
    Ok(EventStream::from_events(SENSOR, (0..20_000).map(event))?)
}

fn update(representation: &str) -> Result<Run> {
    let window = StreamWindow::new(SENSOR, Micros(20_000), ChannelOrder::OffFirst)?;
    let mut running = representation_by_name(representation)?.start(window);
    let events = events()?;
    let mut planes = vec![0.0; running.channels() * SENSOR.pixels()];
    Ok(Box::new(move || {
        running.push(&events);
        running.render(&mut planes);
    }))
}

/// All effects of v2e's noisy model, eight steps.
fn sensor() -> Result<Run> {
    let frames = scene::frames();
    let mut run = SensorModel::from_config(&scene::all())?.start(scene::SIZE, 1);
    let mut step = 0;
    Ok(Box::new(move || {
        for _ in 0..8 {
            let events = run.expose(&frames[step % scene::FRAMES], Micros(1_000 * step as i64));
            black_box(events.map(|events| events.len()).unwrap_or_default());
            step += 1;
        }
    }))
}

fn evt3() -> Result<Run> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("events.raw");
    let format = FORMATS.find("evt3").context("evt3 is a format")?;
    format.write(&path, &events()?)?;
    Ok(Box::new(move || {
        let _keep = &folder;
        black_box(
            evpose_io::open(&path).map(|recording| recording.stream.len()).unwrap_or_default(),
        );
    }))
}
