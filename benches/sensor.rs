//! The event camera, effect by effect: `cargo bench --bench sensor`. Times are per step of all
//! pixels; throughput is in pixel steps.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use evpose_bench::sensor::scene::{self, leak, lowpass, mismatch, refractory, shot, with};
use evpose_core::Micros;
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel};

/// Thresholds that nothing reaches: what pixels cost without events.
fn quiet() -> SensorConfig {
    let crossing = EffectConfig::new("level_crossing");
    let effects = vec![crossing.with("threshold_on", 5.0).with("threshold_off", 5.0)];
    SensorConfig { effects }
}

fn chains(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sensor 240x180");
    group.throughput(Throughput::Elements(scene::SIZE.pixels() as u64));
    let frames = scene::frames();
    let mut settings = vec![
        ("ideal".to_owned(), SensorConfig::default()),
        ("no events".to_owned(), quiet()),
        ("thresholds".to_owned(), scene::thresholds()),
        ("thresholds, low-pass".to_owned(), with(&[mismatch(), lowpass()])),
        ("thresholds, leak".to_owned(), with(&[mismatch(), leak()])),
        ("thresholds, shot noise".to_owned(), with(&[mismatch(), shot()])),
        ("thresholds, refractory".to_owned(), with(&[mismatch(), refractory()])),
        ("all".to_owned(), scene::all()),
    ];
    for preset in evpose_sensor::PRESETS {
        if let Ok(config) = SensorConfig::preset(preset.name) {
            settings.push((preset.name.to_owned(), config));
        }
    }
    for (name, config) in settings {
        let Ok(model) = SensorModel::from_config(&config) else { continue };
        let mut run = model.start(scene::SIZE, 1);
        let mut step = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                let frame = &frames[step % frames.len()];
                step += 1;
                run.expose(frame, Micros(step as i64 * 1_000)).map(|events| events.len())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, chains);
criterion_main!(benches);
