//! Values that no command can work with, in every argument of every command.

use std::path::Path;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{Arg, Command, value_parser};

use crate::harness::Sandbox;

const VALUES: [&str; 7] = ["-1", "0", "NaN", "inf", "1e308", "1e-308", "9223372036854775807"];

/// Values that no float has as a number.
const UNUSABLE: [&str; 3] = ["NaN", "inf", "1e308"];

/// A command that neither refuses a value nor ends by then hangs.
const LIMIT: Duration = Duration::from_secs(60);

/// Words with which each command works on inputs of [`inputs`], or ends at once since its data are missing: of
/// trainings, studies and benchmarks, whose work takes minutes.
const LINES: &[(&str, &str)] = &[
    ("ablate body", "--out o --set nothing=1"),
    ("ablate hand", "--out o --set nothing=1"),
    ("average", "none.bpk none.bpk --out o.bpk"),
    ("calibrate noise", "--events dot.txt"),
    ("calibrate threshold", "--events dot.txt --frames frames --fps 30"),
    ("check", "dot.txt"),
    ("check-labels", "none.csv"),
    ("clean", "dot.txt o.txt"),
    ("compare body", "--out o --set nothing=1"),
    ("compare clips", "none --out o"),
    ("compare once", ""),
    ("completions", "bash"),
    ("convert", "dot.txt o.csv"),
    ("demo", "--set nothing=1 --out o"),
    ("eval", "--checkpoint none.bpk --data none"),
    ("events", "--frames frames --fps 30 --sensor ideal --out o.txt"),
    ("export", "--checkpoint none.bpk --onnx o.onnx"),
    ("gap ablate", "--measured none.raw --scene none"),
    ("gap correct", "--measured none.raw --scene none --out o.toml"),
    ("gap locate", "--measured none.raw --scene none"),
    ("gap name", "--measured none.raw --scene none"),
    ("gap payoff", "none --out o"),
    ("gap power", "--scene none"),
    ("gap probe", "--measured none.raw --scene none"),
    ("gap report", "none"),
    ("gap run", "--measured none.raw --scene none --out o"),
    ("gap verify", "none"),
    ("infer", "--checkpoint NETWORK --events dot.txt --out o.csv"),
    ("info", "dot.txt"),
    ("live", "--checkpoint NETWORK --source dot.txt --json o.jsonl"),
    ("man", "--out o"),
    ("prepare coco", "none --out o"),
    ("prepare dhp19", "none --out o"),
    ("prepare eh36m", "none --out o"),
    ("prepare h36m", "none --out o"),
    ("prepare hands", "dot.txt --labels none.csv --out o --for quick"),
    ("prepare lsp", "none --out o"),
    ("prepare mpii", "none --out o"),
    ("prepare people", "dot.txt --labels none.csv --out o"),
    ("quantize", "--checkpoint none.bpk --data none"),
    ("represent", "dot.txt --out o.npy"),
    ("sensor gallery", "--out o --only nothing"),
    ("sensor list", ""),
    ("sensor show", "ideal"),
    ("sensor tap", "ideal --pixel 3,3"),
    (
        "simulate",
        "quick --out o --set simulation.image_scale=0.1 --set simulation.sequences=1 \
         --set simulation.seconds=0.05",
    ),
    ("train", "quick --data none --out o"),
    ("tune", "quick --over none.toml --out o"),
    ("view", "dot.txt --out o.png --frames 2"),
];

/// A recording and images, small enough for hundreds of runs.
fn inputs(sandbox: &Sandbox) {
    let mut text = "40 30\n".to_owned();
    for k in 0..300 {
        text += &format!("{} {} {} {}\n", 1_000 + 200 * k, k % 40, k % 30, k % 2);
    }
    std::fs::write(sandbox.path("dot.txt"), text).unwrap();
    std::fs::create_dir(sandbox.path("frames")).unwrap();
    for k in 0..3_u8 {
        let image =
            image::GrayImage::from_fn(40, 30, |x, y| image::Luma([(x + y) as u8 * (k + 1)]));
        image.save(sandbox.path(&format!("frames/{k}.png"))).unwrap();
    }
}

/// All commands without subcommands, by their names in a line.
fn leaves(command: &Command, name: &str, all: &mut Vec<(String, Command)>) {
    let mut is_leaf = true;
    for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
        is_leaf = false;
        leaves(sub, format!("{name} {}", sub.get_name()).trim(), all);
    }
    if is_leaf {
        all.push((name.to_owned(), command.clone()));
    }
}

fn commands() -> Vec<(String, Command)> {
    let mut found = Vec::new();
    leaves(&evpose::command(), "", &mut found);
    found
}

/// The flags of a command that take a value.
fn flags(command: &Command) -> impl Iterator<Item = &Arg> {
    command
        .get_arguments()
        .filter(|arg| arg.get_long().is_some() && arg.get_action().takes_values())
}

fn is(arg: &Arg, kinds: &[ValueParser]) -> bool {
    let is = arg.get_value_parser().type_id();
    kinds.iter().any(|kind| kind.type_id() == is)
}

/// Whether the value is refused by its flag, before anything else is looked at.
fn is_refused(command: &Command, arg: &Arg, value: &str) -> bool {
    let word = format!("--{}={value}", arg.get_long().unwrap());
    let parsed = command.clone().no_binary_name(true).try_get_matches_from([word]);
    let kinds = [ErrorKind::ValueValidation, ErrorKind::InvalidValue];
    parsed.is_err_and(|error| kinds.contains(&error.kind()))
}

#[test]
fn every_number_has_a_range() {
    let floats: [ValueParser; 2] = [value_parser!(f32).into(), value_parser!(f64).into()];
    let integers: [ValueParser; 5] = [
        value_parser!(u8).into(),
        value_parser!(u16).into(),
        value_parser!(u32).into(),
        value_parser!(u64).into(),
        value_parser!(usize).into(),
    ];
    let (mut ranged, mut taken) = (0, Vec::new());
    for (name, command) in &commands() {
        for arg in flags(command) {
            let flag = arg.get_long().unwrap();
            if is(arg, &floats) {
                ranged += 1;
                for value in UNUSABLE.into_iter().chain(["-1e300"]) {
                    if !is_refused(command, arg, value) {
                        taken.push(format!("{name} --{flag}={value}"));
                    }
                }
            }
            // Any integer is a seed.
            if is(arg, &integers) && flag != "seed" {
                ranged += 1;
                for value in ["-1", "9223372036854775807"] {
                    if !is_refused(command, arg, value) {
                        taken.push(format!("{name} --{flag}={value}"));
                    }
                }
            }
        }
    }
    assert!(taken.is_empty(), "taken:\n{}", taken.join("\n"));
    assert!(ranged > 100, "{ranged}");
}

/// Runs a command with one word more. Returns what is wrong with how it ends.
fn fault(name: &str, line: &str, word: &str) -> Option<String> {
    let sandbox = Sandbox::new();
    inputs(&sandbox);
    let network = Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/body-quick.bpk");
    let flag = word.split_once('=').unwrap().0;
    let mut words: Vec<&str> = name.split(' ').collect();
    let mut given = line.split_whitespace().peekable();
    while let Some(next) = given.next() {
        // The flag itself comes once.
        if next == flag {
            given.next();
            continue;
        }
        words.push(if next == "NETWORK" { network.to_str().unwrap() } else { next });
    }
    words.push(word);
    let mut command = sandbox.evpose(&words);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = child.stderr.take().unwrap();
    let reader = std::thread::spawn(move || std::io::read_to_string(stderr).unwrap_or_default());
    let began = Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if began.elapsed() > LIMIT => {
                child.kill().unwrap();
                child.wait().unwrap();
                return Some(format!("{name} {line} {word}: does not end"));
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let said = reader.join().unwrap();
    let is_fault = status.code().is_none_or(|code| code == 101) || said.contains("panicked at");
    is_fault.then(|| format!("{name} {line} {word}: {status}\n{said}"))
}

#[test]
#[ignore = "runs a thousand commands: minutes"]
#[expect(clippy::print_stdout, reason = "how much was run")]
fn no_number_in_any_argument_makes_a_command_panic_or_hang() {
    let (mut all, mut parsed, mut refused, mut flag_count) = (Vec::new(), 0, 0, 0);
    let commands = commands();
    for (name, command) in &commands {
        let line = LINES.iter().find(|(known, _)| known == name);
        // Benchmarks measure for minutes whatever they are given: their flags are parsed alone.
        assert!(line.is_some() || name.starts_with("bench "), "no line for `{name}`");
        for arg in flags(command) {
            flag_count += 1;
            for value in VALUES {
                parsed += 1;
                if is_refused(command, arg, value) {
                    refused += 1;
                } else if let Some((_, line)) = line {
                    all.push((name, *line, format!("--{}={value}", arg.get_long().unwrap())));
                }
            }
        }
    }
    let (next, faults) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while let Some((name, line, word)) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
                    faults.lock().unwrap().extend(fault(name, line, word));
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
    println!(
        "{flag_count} flags, {parsed} values, {refused} refused by the flag, {} run",
        all.len()
    );
    assert!(all.len() > 300 && refused > 500, "{} run, {refused} refused", all.len());
}
