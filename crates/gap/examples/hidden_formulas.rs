//! How much of a gap a formula closes: eight effects that the catalogue does not have, hidden by the small
//! camera below, which shares no code with the sensor model.
//!
//! ```text
//! cargo run --release -p evpose-gap --example hidden_formulas -- benches/gap/formulas.md [few] [NAME ...]
//! ```
//!
//! writes a row for each hidden effect: what was named, the formula, and the gap that is left on a second
//! scene as a share of the gap before. Hidden are events that come again after 20 ms (.3 of them), or in the
//! next column after 5 us (.25); a dead time of 12 ms behind ON events; thresholds that grow by .8 a second, or
//! by three waves over the image; a quarter of the columns, which lose .7 of their events; a fifth of the light,
//! mirrored at the centre; rows that see the light up to 8 ms late. With names, of these alone; with `few`, only the effects of the
//! catalogue that are nearest to what is hidden are tried before.

#![allow(clippy::print_stderr, reason = "a program for the terminal")]

use std::error::Error;
use std::fmt::Write as _;

use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_gap::LightSequence;
use evpose_gap::workflow::{ComparisonCase, HeldOut, Inputs, Prepared, findings_of_answer};
use evpose_sensor::{STAGES, SensorConfig};

const WIDTH: usize = 24;
const HEIGHT: usize = 18;
const FPS: f64 = 500.0;
const FRAMES: usize = 250;
/// Thresholds, those of the model.
const THRESHOLD: f64 = 0.2;
/// Light that the model adds before the logarithm.
const DARK: f64 = 1e-5;

/// Effects, by the names of rows.
const HIDDEN: [&str; 8] = [
    "echo",
    "crosstalk",
    "one-sided refractory",
    "drifting thresholds",
    "smooth thresholds",
    "bad columns",
    "ghost light",
    "rolling exposure",
];

/// Effects of the catalogue that are tried with `few`.
const FEW: [&str; 8] = [
    "formula",
    "threshold_mismatch",
    "hysteresis",
    "refractory",
    "shot_noise_poisson",
    "veiling_glare",
    "dead_pixels",
    "pixel_latency",
];

const HEADER: &str = "\
# What is found of effects that the catalogue does not have

Written by `cargo run --release -p evpose-gap --example hidden_formulas -- benches/gap/formulas.md`, which says how: a small
camera that shares no code with the sensor model, two scenes. *Share* is the gap left on the second scene, which no formula
was fitted to, over the gap before.

| hidden | answer | names | formula | gap before | gap left | share |
|---|---|---|---|---|---|---|
";

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let file = args.next().ok_or("which file is to be written?")?;
    let mut names: Vec<String> = args.collect();
    let is_few = names.first().is_some_and(|name| name == "few");
    names.drain(..usize::from(is_few));
    let mut table = String::from(HEADER);
    let mut shares = Vec::new();
    for hidden in
        HIDDEN.into_iter().filter(|one| names.is_empty() || names.iter().any(|n| n == one))
    {
        let (row, share) = row(hidden, is_few)?;
        eprintln!("{row}");
        writeln!(table, "{row}")?;
        shares.push(share);
        shares.sort_by(f64::total_cmp);
        let median = 0.5 * (shares[(shares.len() - 1) / 2] + shares[shares.len() / 2]);
        std::fs::write(&file, format!("{table}\nMedian share of {}: {median:.2}\n", shares.len()))?;
    }
    Ok(())
}

/// A row of the table, and the share of the gap that is left.
fn row(hidden: &str, is_few: bool) -> Result<(String, f64), Box<dyn Error>> {
    let case = |seed: u64| -> Result<ComparisonCase, Box<dyn Error>> {
        let scene = scene(seed)?;
        Ok(ComparisonCase::new(&recorded(hidden, &scene, seed)?, scene)?)
    };
    let of_catalogue = STAGES.iter().map(|stage| stage.name.to_owned());
    let left_out = of_catalogue.filter(|name| is_few && !FEW.contains(&name.as_str())).collect();
    let prepared = Prepared::new(Inputs {
        train: case(1)?,
        held_out: HeldOut::Recording(case(2)?),
        model: SensorConfig::default(),
        nominal: None,
        left_out,
        seed: 3,
        is_quick: true,
    })?;
    let splits = prepared.data_splits()?;
    let progress = |what: &str| eprintln!("{hidden}: {what}");
    let result = splits.identify(&prepared.model.config, &prepared.left_out, &progress)?;
    let findings = findings_of_answer(&splits, &result)?;
    let of = |is_formula: bool| findings.iter().filter(move |f| f.formula.is_some() == is_formula);
    let named: Vec<String> = of(false).map(|finding| format!("`{}`", finding.name)).collect();
    let formulas: Vec<String> = of(true)
        .filter_map(|finding| finding.formula.as_ref())
        .map(|formula| format!("{} = `{}`: {}", formula.stage, formula.expression, formula.reading))
        .collect();
    let (before, after) = (result.before.gap, result.after.gap);
    let share = after / before;
    let row = format!(
        "| {hidden} | {} | {} | {} | {before:.2} | {after:.2} | {share:.2} |",
        result.answer.key(),
        named.join(", "),
        formulas.join(", ")
    );
    Ok((row, share))
}

/// Two gratings that run over each other, and a bright spot that circles.
fn light(seed: u64, x: f64, y: f64, t_s: f64) -> f64 {
    let turn = 0.9 * seed as f64;
    let (c, s) = (turn.cos(), turn.sin());
    let (u, v) = (c * x + s * y, c * y - s * x);
    let gratings = 0.12 * (0.55 * u - 22.0 * t_s).sin() + 0.08 * (0.35 * v + 15.0 * t_s).sin();
    let angle = 9.0 * t_s + turn;
    let (dx, dy) = (x - 12.0 - 6.0 * angle.cos(), y - 9.0 - 4.0 * angle.sin());
    0.25 + gratings + 0.5 * (-(dx * dx + dy * dy) / 12.0).exp()
}

fn scene(seed: u64) -> Result<LightSequence, Box<dyn Error>> {
    let plane = |frame: usize| {
        let values = (0..WIDTH * HEIGHT).map(|i| {
            light(seed, (i % WIDTH) as f64, (i / WIDTH) as f64, frame as f64 / FPS) as f32
        });
        Plane::from_vec(WIDTH, HEIGHT, values.collect())
    };
    Ok(LightSequence::new(FPS, (0..=FRAMES).map(plane).collect::<Result<_, _>>()?)?)
}

/// A sequence of random numbers in 0..1 (Park and Miller 1988).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }
}

/// Events as time in seconds, pixel and sign.
type Spike = (f64, usize, bool);

/// Events of a camera with the hidden effect.
fn recorded(hidden: &str, scene: &LightSequence, seed: u64) -> Result<EventStream, Box<dyn Error>> {
    let mut draws = Draws(7_919 * seed + 17);
    (0..20).for_each(|_| _ = draws.next());
    let mut spikes = Vec::new();
    for pixel in 0..WIDTH * HEIGHT {
        spikes.extend(crossings(hidden, pixel, &logs(hidden, scene, seed, pixel)));
    }
    spikes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The same columns in both recordings: it is one camera.
    let mut of_columns = Draws(4_711);
    let is_bad: Vec<bool> = (0..WIDTH).map(|_| of_columns.next() < 0.25).collect();
    let mut further = Vec::new();
    spikes.retain(|&(t_s, pixel, is_on)| {
        let draw = draws.next();
        match hidden {
            "echo" if draw < 0.3 => further.push((t_s + 0.02, pixel, is_on)),
            "crosstalk" if draw < 0.25 && pixel % WIDTH + 1 < WIDTH => {
                further.push((t_s + 5e-6, pixel + 1, is_on));
            }
            "bad columns" => return !(is_bad[pixel % WIDTH] && draw < 0.7),
            _ => {}
        }
        true
    });
    spikes.extend(further);
    let mut events: Vec<Event> = spikes
        .into_iter()
        .map(|(t_s, pixel, is_on)| Event {
            t: Micros((1e6 * t_s).ceil() as i64),
            x: (pixel % WIDTH) as u16,
            y: (pixel / WIDTH) as u16,
            polarity: if is_on { Polarity::On } else { Polarity::Off },
        })
        .collect();
    events.retain(|event| event.t.0 <= (1e6 * FRAMES as f64 / FPS) as i64);
    events.sort_by_key(|event| (event.t, event.y, event.x));
    let size = SensorSize { width: WIDTH as u16, height: HEIGHT as u16 };
    Ok(EventStream::from_events(size, events)?)
}

/// Log light of a pixel in every frame.
fn logs(hidden: &str, scene: &LightSequence, seed: u64, pixel: usize) -> Vec<f64> {
    let (x, y) = (pixel % WIDTH, pixel / WIDTH);
    let at = |frame: usize| {
        let own = f64::from(scene.planes()[frame].data()[pixel]);
        let light = match hidden {
            "ghost light" => {
                let mirrored = WIDTH * HEIGHT - 1 - pixel;
                own + 0.2 * f64::from(scene.planes()[frame].data()[mirrored])
            }
            // The last row sees what the first saw 8 ms before; nothing is known of the light before the scene.
            "rolling exposure" => {
                let late_s = 0.008 * y as f64 / (HEIGHT - 1) as f64;
                light(seed, x as f64, y as f64, (frame as f64 / FPS - late_s).max(0.0))
            }
            _ => own,
        };
        (light + DARK).ln()
    };
    (0..=FRAMES).map(at).collect()
}

/// Deviation of the threshold of a pixel, as a fraction: three waves of 14 to 20 pixels.
fn smooth(pixel: usize) -> f64 {
    let (x, y) = ((pixel % WIDTH) as f64, (pixel / WIDTH) as f64);
    let waves = [(0.31, 0.2, 0.5), (-0.25, 0.33, 2.1), (0.1, -0.42, 4.0)];
    0.16 * waves.iter().map(|(a, b, phase)| (a * x + b * y + phase).sin()).sum::<f64>()
}

/// Events of a pixel whose log light runs in lines between frames.
fn crossings(hidden: &str, pixel: usize, logs: &[f64]) -> Vec<Spike> {
    let mut spikes = Vec::new();
    let (mut memory, mut free_s) = (logs[0], f64::NEG_INFINITY);
    for (frame, pair) in logs.windows(2).enumerate() {
        let (start_s, step_s) = (frame as f64 / FPS, 1.0 / FPS);
        let v = |t_s: f64| pair[0] + (pair[1] - pair[0]) * (t_s - start_s) / step_s;
        // Twenty parts of a frame, in each of which a crossing is found on a line.
        for part in 0..20 {
            let (from_s, to_s) = (
                start_s + step_s * f64::from(part) / 20.0,
                start_s + step_s * f64::from(part + 1) / 20.0,
            );
            if to_s <= free_s {
                continue;
            }
            if from_s < free_s {
                memory = v(free_s);
            }
            let threshold = THRESHOLD
                * match hidden {
                    "drifting thresholds" => 1.0 + 0.8 * to_s,
                    "smooth thresholds" => 1.0 + smooth(pixel),
                    _ => 1.0,
                };
            let mut now_s = from_s.max(free_s);
            loop {
                let is_on = v(to_s) > memory;
                let level = if is_on { memory + threshold } else { memory - threshold };
                let is_reached = if is_on { v(to_s) >= level } else { v(to_s) <= level };
                if !is_reached {
                    break;
                }
                let way = (level - v(from_s)) / (v(to_s) - v(from_s));
                now_s = (from_s + (to_s - from_s) * way).clamp(now_s, to_s);
                spikes.push((now_s, pixel, is_on));
                memory = level;
                // Dead behind ON events, and the memory is then what the voltage has become.
                if hidden == "one-sided refractory" && is_on {
                    free_s = now_s + 0.012;
                    break;
                }
            }
        }
    }
    spikes
}
