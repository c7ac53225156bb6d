//! Prints what the effects do at every strength on every scene, and how long a recording takes:
//! the table from which the strengths were set.
//!
//! Arguments: a seed (1), and a part of the names to show (all).

use std::io::Write;
use std::time::Instant;

use gapbench_pixel::camera::record;
use gapbench_pixel::draw::{Purpose, Sequence};
use gapbench_pixel::evidence::compare;
use gapbench_pixel::oddity::{ODDITIES, install_oddity};
use gapbench_pixel::{CameraStage, Circuit, EFFECTS, SCENE_KINDS, STRENGTHS, Scene, Seeds};

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    let mut arguments = std::env::args().skip(1);
    let seed = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1);
    let part = arguments.next().unwrap_or_default();
    let seeds = Seeds { camera: seed, run: seed + 1 };
    let mut cases: Vec<(String, CameraStage, Circuit)> = Vec::new();
    for effect in EFFECTS {
        for strength in 0..STRENGTHS {
            let mut circuit = Circuit::ideal();
            effect.install(strength, &mut circuit, &mut Sequence::new(seed, Purpose::Plan, 0));
            cases.push((format!("{} {strength}", effect.name()), effect.stage(), circuit));
        }
    }
    for oddity in ODDITIES {
        for round in 0..3 {
            let mut circuit = Circuit::ideal();
            install_oddity(oddity, round, &mut circuit);
            let in_readout = circuit.readout.oddity.is_some();
            let stage = if in_readout { CameraStage::Readout } else { CameraStage::Detector };
            cases.push((format!("{oddity:?} {round}"), stage, circuit));
        }
    }
    cases.retain(|(name, ..)| name.contains(&part));
    for kind in SCENE_KINDS {
        let scene = Scene::new(kind, seed);
        let start = Instant::now();
        let ideal = record(&Circuit::ideal(), &scene, seeds);
        let events = ideal.events.len();
        writeln!(out, "{}: {events} events, {:.2} s", kind.name(), start.elapsed().as_secs_f64())?;
        for (name, stage, circuit) in &cases {
            let start = Instant::now();
            let with = record(circuit, &scene, seeds);
            let seconds = start.elapsed().as_secs_f64();
            let e = compare(&ideal, &with, *stage);
            let net = 100.0 * (e.with as f64 - e.without as f64) / e.without.max(1) as f64;
            writeln!(
                out,
                "{:6} {name:28} {:7.1} % ({net:+7.1} % net, {:6} quiet, {:5.0} us) {} {seconds:.2} s",
                kind.name(),
                100.0 * e.share(),
                e.added_in_quiet,
                e.median_shift_us,
                if e.visible { "visible" } else { "-" },
            )?;
        }
    }
    Ok(())
}
