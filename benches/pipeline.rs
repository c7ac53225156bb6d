//! The stages of the hand pipeline, each alone: `cargo bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use evpose_core::{EventStream, SensorSize};
use evpose_nn::{DeviceKind, HandRegressorConfig};
use evpose_repr::{ChannelOrder, FrameEvent, FrameWindow, representation_by_name};
use evpose_sim::{SimulationConfig, Simulator};

/// A second of the published scene, as frames.
fn recorded(frames: u64) -> (SensorSize, Vec<EventStream>) {
    let config = SimulationConfig::default();
    let mut simulator = match Simulator::new(&config, 1) {
        Ok(simulator) => simulator,
        Err(error) => panic!("the default simulation: {error}"),
    };
    let streams = (0..frames).map(|_| match simulator.advance() {
        Ok(step) => step.events.clone(),
        Err(error) => panic!("a step of the default simulation: {error}"),
    });
    (config.image_size(), streams.collect())
}

fn simulation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("simulation");
    group.throughput(Throughput::Elements(1));
    for (name, image_scale) in [("step 240x180", 1.0), ("step 120x90", 0.5)] {
        let config = SimulationConfig { image_scale, ..SimulationConfig::default() };
        let Ok(mut simulator) = Simulator::new(&config, 1) else { continue };
        group.bench_function(name, |b| b.iter(|| simulator.advance().map(|step| step.frame)));
    }
    group.finish();
}

fn representations(criterion: &mut Criterion) {
    let (sensor, streams) = recorded(400);
    // The last 100 frames: away from the burst at the start.
    let events: Vec<FrameEvent> = streams[300..]
        .iter()
        .enumerate()
        .flat_map(|(frame, stream)| {
            stream.iter().map(move |event| FrameEvent {
                frame: frame as u32,
                x: event.x,
                y: event.y,
                polarity: event.polarity,
            })
        })
        .collect();
    let window = FrameWindow::new(sensor, 100, ChannelOrder::OffFirst);
    let mut group = criterion.benchmark_group("representation of 100 ms");
    group.throughput(Throughput::Elements(events.len() as u64));
    for name in ["lnes", "eoi", "eci"] {
        let Ok(representation) = representation_by_name(name) else { continue };
        let mut planes = vec![0.0; representation.channels() * sensor.pixels()];
        group.bench_function(name, |b| {
            b.iter(|| representation.fill(&window, &events, &mut planes));
        });
    }
    group.finish();
}

fn network(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("network, one window");
    group.sample_size(20);
    let Ok(device) = DeviceKind::Flex.resolve() else { return };
    for (name, width, [height, columns]) in
        [("published, 240x180", 1.0, [180, 240]), ("quarter width, 120x90", 0.25, [90, 120])]
    {
        let config = HandRegressorConfig { width, ..HandRegressorConfig::default() };
        let Ok(network) = config.init(1, &device) else { continue };
        let input = burn::tensor::Tensor::<4>::zeros([1, 2, height, columns], &device);
        group.bench_function(name, |b| b.iter(|| network.forward(input.clone()).into_data()));
    }
    group.finish();
}

criterion_group!(benches, simulation, representations, network);
criterion_main!(benches);
