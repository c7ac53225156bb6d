//! Values that no command can work with, in every argument of every command.

use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{Arg, Command, value_parser};

use crate::harness::{BODY_TINY, Sandbox, TINY, tiny};
use crate::{prepare, reading};

const VALUES: [&str; 7] = ["-1", "0", "NaN", "inf", "1e308", "1e-308", "9223372036854775807"];

/// A value that most numeric arguments take, so that each command is also run with it.
const USABLE: &str = "1";

/// Values that no float has as a number.
const UNUSABLE: [&str; 3] = ["NaN", "inf", "1e308"];

/// A command that neither refuses a value nor ends by then hangs.
const LIMIT: Duration = Duration::from_secs(180);

/// Words with which each command works on inputs of [`inputs`] and [`shared`], or ends at once since its data are
/// missing: of what takes minutes however little it is given.
const LINES: &[(&str, &str)] = &[
    ("ablate body", "--rows fixed-count --steps 2 --seeds 1 --jobs 1 --out o BODY_TINY"),
    (
        "ablate hand",
        "--rows no-filter --seeds 1 --stride-ms 10 --out o TINY --set evaluation.seconds=0.5",
    ),
    ("average", "NETWORK NETWORK --out o.bpk"),
    ("calibrate noise", "--events SHARED/bar.txt"),
    ("calibrate threshold", "--events SHARED/rec.npz --frames SHARED/scene/frames.npy --fps 1000"),
    ("check", "dot.txt"),
    ("check-labels", "SHARED/own/bar.poses.csv"),
    ("clean", "dot.txt o.txt"),
    (
        "compare body",
        "--systems dhp19-cnn,mean-pose --steps 2 --seeds 1 --jobs 1 --out o BODY_TINY",
    ),
    ("compare clips", "none --out o"),
    ("completions", "bash"),
    ("convert", "dot.txt o.csv"),
    ("demo", "--set nothing=1 --out o"),
    ("eval", "--checkpoint SHARED/run --data SHARED/data"),
    ("events", "--frames frames --fps 30 --sensor ideal --out o.txt"),
    ("export", "--checkpoint NETWORK --onnx o.onnx"),
    ("gap ablate", "--measured SHARED/rec.npz --scene SHARED/scene --budget 0"),
    ("gap camera", "SHARED/bar.txt --out o"),
    ("gap correct", "--measured SHARED/rec.npz --scene SHARED/scene --budget 0 --out o.toml"),
    ("gap locate", "--measured SHARED/rec.npz --scene SHARED/scene"),
    ("gap name", "--measured SHARED/rec.npz --scene SHARED/scene --budget 0"),
    ("gap payoff", "SHARED/gap --camera SHARED/camera.toml --stride-ms 20 --out o TINY"),
    ("gap power", "--scene SHARED/scene --seconds 0.2"),
    ("gap probe", "--measured SHARED/rec.npz --scene SHARED/scene"),
    ("gap report", "SHARED/gap"),
    ("gap run", "--measured SHARED/rec.npz --scene SHARED/scene --budget 0 --quick --out o"),
    ("gap verify", "SHARED/gap --runs 2"),
    ("infer", "--checkpoint NETWORK --events dot.txt --out o.csv"),
    ("info", "dot.txt"),
    ("live", "--checkpoint NETWORK --source dot.txt --json o.jsonl"),
    ("man", "--out o"),
    ("prepare coco", "SHARED/COCO --split val2017 --out o"),
    ("prepare dhp19", "SHARED/DHP19 --out o"),
    ("prepare eh36m", "YARP --out o"),
    ("prepare h36m", "SHARED/H36M --out o"),
    ("prepare hands", "SHARED/bar.txt --labels SHARED/hands.csv --out o --for quick"),
    ("prepare lsp", "SHARED/lspet --out o"),
    ("prepare mpii", "SHARED/MPII --out o"),
    ("prepare people", "SHARED/bar.txt --labels SHARED/people.csv --out o"),
    ("quantize", "--checkpoint SHARED/run --data SHARED/data --windows 8"),
    ("represent", "dot.txt --out o.npy"),
    ("sensor gallery", "--out o --only logarithmic --scale 0.2"),
    ("sensor list", ""),
    ("sensor show", "ideal"),
    ("sensor tap", "ideal --pixel 3,3"),
    (
        "simulate",
        "quick --out o --set simulation.image_scale=0.1 --set simulation.sequences=1 \
         --set simulation.seconds=0.05",
    ),
    ("train", "quick --data SHARED/data --out o --plain TINY"),
    ("tune", "quick --over SHARED/over.toml --data SHARED/data --out o --trials 2 TINY"),
    ("view", "dot.txt --out o.png --frames 2"),
];

/// As [`LINES`], for arguments that are text, of commands that take a second or more: these end at once.
const LINES_OF_TEXT: &[(&str, &str)] = &[
    ("ablate body", "--out o --set nothing=1"),
    ("ablate hand", "--out o --set nothing=1"),
    ("compare body", "--out o --set nothing=1"),
    ("eval", "--checkpoint none.bpk --data none"),
    ("export", "--checkpoint none.bpk --onnx o.onnx"),
    ("gap ablate", "--measured none.raw --scene none"),
    ("gap camera", "none.raw --out o"),
    ("gap correct", "--measured none.raw --scene none --out o.toml"),
    ("gap locate", "--measured none.raw --scene none"),
    ("gap name", "--measured none.raw --scene none"),
    ("gap payoff", "none --camera ideal --out o"),
    ("gap power", "--scene none"),
    ("gap probe", "--measured none.raw --scene none"),
    ("gap run", "--measured none.raw --scene none --out o"),
    ("prepare h36m", "none --out o"),
    ("quantize", "--checkpoint none.bpk --data none"),
    ("sensor gallery", "--out o --only nothing"),
    ("train", "quick --data none --out o"),
    ("tune", "quick --over none.toml --out o"),
];

/// A recording and images, small enough for hundreds of runs.
fn inputs(sandbox: &Sandbox) {
    let mut text = "40 30\n".to_owned();
    for k in 0..300 {
        text += &format!("{} {} {} {}\n", 1_000 + 200 * k, k % 40, k % 30, k % 2);
    }
    sandbox.write("dot.txt", text);
    std::fs::create_dir(sandbox.path("frames")).unwrap();
    for k in 0..3_u8 {
        let image =
            image::GrayImage::from_fn(40, 30, |x, y| image::Luma([(x + y) as u8 * (k + 1)]));
        image.save(sandbox.path(&format!("frames/{k}.png"))).unwrap();
    }
}

/// Inputs that take seconds to make, and are read by many runs: a scene with its recording and a run of `gap` on them, a data
/// set with a network, recordings with labels, data sets of others.
fn shared() -> Sandbox {
    let sandbox = Sandbox::new();
    reading::beside(&sandbox);
    let times: Vec<i64> = (0..4_000).map(|k| 150 * k).collect();
    sandbox.write("bar.txt", reading::recording(&times));
    sandbox.run("prepare people bar.txt --labels people.csv --out own", &[]);
    let gap = "gap run --measured rec.npz --scene scene --quick --budget 0 --out gap";
    sandbox.evpose(&gap.split(' ').collect::<Vec<_>>()).output().unwrap();
    assert!(sandbox.path("gap/run.json").is_file());
    // A model that was corrected, for what the correction is worth.
    let corrected = sandbox.path("gap/corrected.toml");
    let leak = "\n[[effect]]\nname = \"leak_on\"\nrate_hz = 6.0\n";
    std::fs::write(&corrected, std::fs::read_to_string(&corrected).unwrap() + leak).unwrap();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    sandbox.ok(&tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]));
    let over = "[training]\nlearning_rate = { log_uniform = [1e-4, 1e-2] }\n";
    sandbox.write("over.toml", over);
    prepare::mpii_in(&sandbox);
    prepare::dhp19_in(&sandbox);
    prepare::lsp_and_coco_in(&sandbox);
    prepare::h36m_in(&sandbox);
    sandbox
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

fn flags(command: &Command) -> impl Iterator<Item = &Arg> {
    command
        .get_arguments()
        .filter(|arg| arg.get_long().is_some() && arg.get_action().takes_values())
}

fn is(arg: &Arg, kinds: &[ValueParser]) -> bool {
    let is = arg.get_value_parser().type_id();
    kinds.iter().any(|kind| kind.type_id() == is)
}

fn floats() -> [ValueParser; 2] {
    [value_parser!(f32).into(), value_parser!(f64).into()]
}

fn integers() -> [ValueParser; 7] {
    [
        value_parser!(u8).into(),
        value_parser!(u16).into(),
        value_parser!(u32).into(),
        value_parser!(u64).into(),
        value_parser!(usize).into(),
        value_parser!(i64).into(),
        value_parser!(NonZeroUsize).into(),
    ]
}

fn is_number(arg: &Arg) -> bool {
    is(arg, &floats()) || is(arg, &integers())
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
    let (mut ranged, mut taken) = (0, Vec::new());
    for (name, command) in &commands() {
        for arg in flags(command) {
            let flag = arg.get_long().unwrap();
            if is(arg, &floats()) {
                ranged += 1;
                for value in UNUSABLE.into_iter().chain(["-1e300"]) {
                    if !is_refused(command, arg, value) {
                        taken.push(format!("{name} --{flag}={value}"));
                    }
                }
            }
            // Any integer is a seed.
            if is(arg, &integers()) && flag != "seed" {
                ranged += 1;
                // A time may be before another.
                let least = if is(arg, &[value_parser!(i64).into()]) { i64::MIN } else { -1 };
                for value in [least.to_string().as_str(), "9223372036854775807"] {
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
fn fault(shared: &Sandbox, name: &str, line: &str, word: &str) -> Option<String> {
    let sandbox = Sandbox::new();
    inputs(&sandbox);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let network = root.join("checkpoints/body-quick.bpk");
    let yarp = root.join("crates/datasets/tests/golden/h36m/yarp");
    let shared = shared.path("");
    let shared = shared.to_str().unwrap().trim_end_matches('/');
    let flag = word.split_once('=').unwrap().0;
    let mut words: Vec<String> = name.split(' ').map(str::to_owned).collect();
    let mut given = line.split_whitespace().peekable();
    while let Some(next) = given.next() {
        // The flag itself comes once.
        if next == flag {
            given.next();
            continue;
        }
        let changes = match next {
            "TINY" => TINY,
            "BODY_TINY" => BODY_TINY,
            _ => {
                let next = next.replace("NETWORK", network.to_str().unwrap());
                let next = next.replace("YARP", yarp.to_str().unwrap());
                words.push(next.replace("SHARED", shared));
                continue;
            }
        };
        words.extend(changes.iter().flat_map(|change| ["--set".to_owned(), (*change).to_owned()]));
    }
    words.push(word.to_owned());
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut command = sandbox.evpose(&words);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = child.stderr.take().unwrap();
    // Standard error is read meanwhile: a command whose pipe is full would seem to hang.
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
    for (line_of, _) in LINES.iter().chain(LINES_OF_TEXT) {
        assert!(commands.iter().any(|(name, _)| name == line_of), "no command `{line_of}`");
    }
    let shared = shared();
    for (name, command) in &commands {
        let of_values = LINES.iter().find(|(known, _)| known == name);
        // Benchmarks measure for minutes whatever they are given: their flags are parsed alone.
        assert!(of_values.is_some() || name.starts_with("bench "), "no line for `{name}`");
        let of_text = LINES_OF_TEXT.iter().find(|(known, _)| known == name).or(of_values);
        for arg in flags(command) {
            flag_count += 1;
            let is_number = is_number(arg);
            let line = if is_number { of_values } else { of_text };
            for value in VALUES.into_iter().chain(is_number.then_some(USABLE)) {
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
                    faults.lock().unwrap().extend(fault(&shared, name, line, word));
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
