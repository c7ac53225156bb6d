//! Threads of engines: several engines at once, under load, and idle.
//!
//! Tests of times need an idle machine: `cargo xtask slow` runs them.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use burn::tensor::Device;
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::HandRegressorConfig;

const SIZE: [usize; 3] = [2, 90, 120];
/// Runs per measurement, of which the median counts.
const RUNS: usize = 15;
/// Interleaved measurements, idle and under load.
const REPEATS: usize = 7;
/// By how much more than its share of the processor an engine may be slower. One whose threads only
/// ever look for work loses whole time slices at each of its layers: tens of times as much.
const MORE: f64 = 3.0;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn median_s(engine: &mut Engine, image: &[f32]) -> f64 {
    let timed = |_| {
        let begin = Instant::now();
        black_box(engine.run(image));
        begin.elapsed().as_secs_f64()
    };
    median((0..RUNS).map(timed).collect())
}

/// How many times as long an engine takes beside a thread that never rests.
fn slower_beside(engine: &mut Engine, image: &[f32]) -> f64 {
    let ratio = |_| {
        // Both are measured in turn, so that a change of the clock rate meets both.
        let alone = median_s(engine, image);
        let is_over = AtomicBool::new(false);
        let beside = thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
            let beside = median_s(engine, image);
            is_over.store(true, Ordering::Relaxed);
            beside
        });
        beside / alone
    };
    median((0..REPEATS).map(ratio).collect())
}

/// Processor time of all threads of this process so far, in seconds.
#[cfg(target_os = "linux")]
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    // The name in parentheses may hold anything; user and system time are the 12th and 13th behind it.
    let (_, fields) = text.rsplit_once(')').unwrap();
    let ticks = fields.split_whitespace().skip(11).take(2);
    ticks.map(|ticks| ticks.parse::<f64>().unwrap()).sum::<f64>() / 100.0
}

fn engine() -> (Engine, Vec<f32>) {
    let config = HandRegressorConfig { width: 0.25, ..HandRegressorConfig::default() };
    let graph = config.init(7, &Device::flex()).unwrap().graph();
    let image: Vec<f32> = (0..SIZE.iter().product()).map(|k| (k % 97) as f32 / 97.0).collect();
    let options = EngineOptions::default().with_threads(2);
    (Engine::compile(&graph, SIZE, options).unwrap(), image)
}

#[test]
#[ignore = "times: `cargo xtask slow` runs it, on a machine that does nothing else"]
fn beside_a_busy_thread_an_engine_is_slower_by_its_share() {
    let (mut engine, image) = engine();
    let cores = thread::available_parallelism().unwrap().get() as f64;
    // Its threads and the other share the cores.
    let fair = (3.0 / cores).max(1.0);
    let slower = slower_beside(&mut engine, &image);
    assert!(slower < MORE * fair, "{slower:.1} times as long");
}

#[test]
fn engines_share_the_machine() {
    let (mut engine, image) = engine();
    let alone = engine.run(&image).to_vec();

    // Side by side each says what it says alone.
    let engines: Vec<Engine> = (0..3).map(|_| engine.another()).collect();
    thread::scope(|scope| {
        for mut engine in engines {
            let (image, alone) = (&image, &alone);
            scope.spawn(move || (0..50).for_each(|_| assert_eq!(engine.run(image), alone)));
        }
    });

    #[cfg(target_os = "linux")]
    {
        // Threads look for work for well below a millisecond.
        thread::sleep(Duration::from_millis(100));
        let before_s = processor_s();
        thread::sleep(Duration::from_millis(1000));
        let used_s = processor_s() - before_s;
        assert!(used_s < 0.05, "{used_s:.2} s of processor time while there was nothing to do");
    }
    assert_eq!(engine.run(&image), alone, "a thread that slept wakes up");
}
