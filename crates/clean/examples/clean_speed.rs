//! Events a second through each cleaner, on one core:
//! `cargo run --release -p evpose-clean --example clean_speed [REQUEST...]`. The best of many
//! passes over ten million events of 640x480 pixels: an edge that moves, and a tenth of noise.

use std::time::Instant;

use evpose_clean::{CleanError, CleanRequest, CleanerChain};
use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};

const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };
const EVENTS: usize = 10_000_000;
const BATCH: usize = 1 << 16;
const PASSES: usize = 15;

fn recording() -> Vec<EventStream> {
    let mut rng = CounterRng::new(1, "edge", 0);
    let batch = |start: usize, rng: &mut CounterRng| {
        let mut events = EventStream::empty(SENSOR);
        for i in start..(start + BATCH).min(EVENTS) {
            let is_noise = rng.chance(0.1);
            let x = if is_noise { rng.below(640) } else { i / 4_000 % 630 + rng.below(8) };
            let y = rng.below(480);
            let polarity = Polarity::from_on(rng.chance(0.5));
            let event = Event { t: Micros(i as i64 / 10), x: x as u16, y: y as u16, polarity };
            if events.push(event).is_err() {
                unreachable!("events in order and on the sensor");
            }
        }
        events
    };
    (0..EVENTS).step_by(BATCH).map(|start| batch(start, &mut rng)).collect()
}

fn main() -> Result<(), CleanError> {
    let mut requests: Vec<String> = std::env::args().skip(1).collect();
    if requests.is_empty() {
        requests = ["background", "background:own=yes,polarity=same", "background:preset=dhp19"]
            .into_iter()
            .chain(["hot", "deflicker"])
            .map(str::to_owned)
            .collect();
    }
    let batches = recording();
    for text in requests {
        let request: CleanRequest = text.parse()?;
        let (mut best_s, mut left) = (f64::INFINITY, 0);
        for _ in 0..PASSES {
            let mut chain = CleanerChain::new(SENSOR, std::slice::from_ref(&request))?;
            for _ in 0..chain.surveys() {
                batches.iter().try_for_each(|batch| chain.survey(batch))?;
                chain.end_survey()?;
            }
            let mut seconds = 0.0;
            for batch in &batches {
                let mut batch = batch.clone();
                let start = Instant::now();
                chain.clean(&mut batch)?;
                seconds += start.elapsed().as_secs_f64();
            }
            let start = Instant::now();
            chain.finish()?;
            best_s = best_s.min(seconds + start.elapsed().as_secs_f64());
            left = chain.report()[0].left;
        }
        let rate = EVENTS as f64 * 1e-6 / best_s;
        #[expect(clippy::print_stdout, reason = "what it is for")]
        {
            println!("{text}: {rate:.0} M events/s, {left} of {EVENTS} left");
        }
    }
    Ok(())
}
