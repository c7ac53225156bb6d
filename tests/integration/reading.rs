//! One policy of reading: every command, with every kind of disorder.

use crate::harness::{Sandbox, stderr};

/// Disorder of a recording, and how commands answer it.
struct Disorder {
    name: &'static str,
    /// Times of 4000 events from those in order.
    times: fn(Vec<i64>) -> Vec<i64>,
    /// Part of the output of every command; of its error if `is_refused`.
    says: &'static str,
    is_refused: bool,
}

const fn sorted(
    name: &'static str,
    times: fn(Vec<i64>) -> Vec<i64>,
    says: &'static str,
) -> Disorder {
    Disorder { name, times, says, is_refused: false }
}

const fn refused(name: &'static str, times: fn(Vec<i64>) -> Vec<i64>) -> Disorder {
    Disorder { name, times, says: "--sort", is_refused: true }
}

const KINDS: [Disorder; 6] = [
    sorted(
        "late",
        |times| {
            times.iter().enumerate().map(|(k, t)| t - 4_000 * i64::from(k % 50 == 49)).collect()
        },
        "behind later ones: sorted",
    ),
    sorted(
        "stale",
        |mut times| {
            times[..3].fill(3_000_000_000);
            times
        },
        "far from all others",
    ),
    sorted(
        "wrapped",
        |times| times.iter().map(|t| (t + (1 << 32) - 1_300_000) % (1 << 32)).collect(),
        "began again 1 times: unwrapped",
    ),
    refused("restarted", |times| {
        let half = times.len() / 2;
        [&times[..half], &times[..half]].concat()
    }),
    refused("reversed", |times| times.into_iter().rev().collect()),
    refused("shuffled", |times| {
        (0..times.len()).map(|k| times[(k * 1_009) % times.len()]).collect()
    }),
];

/// Commands that read `FILE`.
const COMMANDS: [&str; 13] = [
    "info FILE",
    "check FILE",
    "convert FILE OUT.npz",
    "clean FILE",
    "clean FILE OUT.txt --with hot",
    "represent FILE --of lnes --out OUT.npy",
    "represent FILE --checkpoint hand-quick --every-ms 100 --out OUT.npy",
    "view FILE --out OUT.png",
    "calibrate noise --events FILE",
    "gap run --measured FILE --scene none --quick --out OUT",
    "infer --checkpoint hand --events FILE --out OUT.csv --stride-ms 100",
    "infer --checkpoint body --events FILE --out OUT.csv --consensus false --stride-ms 100",
    "live --source FILE --speed max --checkpoint body --stride-ms 100",
];

/// A bar that moves over the sensor.
fn recording(times: &[i64]) -> String {
    let mut text = "96 72\n".to_owned();
    for (k, t) in times.iter().enumerate() {
        text += &format!("{t} {} {} {}\n", (k / 50) % 96, (k * 7) % 72, k % 2);
    }
    text
}

#[test]
fn every_command_answers_every_disorder_alike() {
    let sandbox = Sandbox::new();
    for kind in KINDS {
        let times = (kind.times)((0..4_000).map(|k| 1_000_000 + 150 * k).collect());
        let file = format!("{}.txt", kind.name);
        std::fs::write(sandbox.path(&file), recording(&times)).unwrap();
        for (number, command) in COMMANDS.iter().enumerate() {
            let out = format!("{}-{number}", kind.name);
            let line = command.replace("FILE", &file).replace("OUT", &out);
            let args: Vec<&str> = line.split_whitespace().collect();
            let output = sandbox.evpose(&args).output().unwrap();
            let said = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
            assert!(said.contains(kind.says), "{line}: {said}");
            // 3: nobody is in view. What `gap` finds has codes of its own, and so has what `check` advises.
            let is_good = matches!(output.status.code(), Some(0 | 3))
                || command.starts_with("gap") && said.contains("written to")
                || command.starts_with("check") && output.status.code() == Some(10);
            assert!(is_good != kind.is_refused || command.starts_with("check"), "{line}: {said}");
        }
    }
    // What is sorted is what it would have been in order.
    let in_order: Vec<i64> = (0..4_000).map(|k| 1_000_000 + 150 * k).collect();
    let mut lines: Vec<(i64, String)> = recording(&(KINDS[0].times)(in_order))
        .lines()
        .skip(1)
        .map(|line| (line.split(' ').next().unwrap().parse().unwrap(), format!("{line}\n")))
        .collect();
    lines.sort_by_key(|(t, _)| *t);
    let text: String = lines.into_iter().map(|(_, line)| line).collect();
    std::fs::write(sandbox.path("ordered.txt"), format!("96 72\n{text}")).unwrap();
    for command in &COMMANDS[2..9] {
        let Some((_, out)) = command.split_once("OUT") else { continue };
        let ending = out.split(' ').next().unwrap();
        let result = |name: &str| {
            let line = command.replace("FILE", &format!("{name}.txt"));
            sandbox.run(&line.replace("OUT", &format!("of-{name}")), &[]);
            crate::harness::bytes(&sandbox.path(&format!("of-{name}{ending}")))
        };
        assert!(result("late") == result("ordered"), "{command}");
    }
    // The parts that are asked for, joined, and all by their time stamps.
    for (option, events) in [("--part 1", 2_000), ("--join", 4_000), ("--sort", 4_000)] {
        let line = format!("convert restarted.txt parts.npz {option}");
        let said = sandbox.run(&line, &[]);
        assert!(said.contains(&format!("{events} events of a 96x72 sensor")), "{option}: {said}");
    }
    let message = sandbox.fails(&["info", "restarted.txt", "--part", "3"]);
    assert!(message.contains("there is no part 3"), "{message}");
}

#[test]
fn units_and_axes_that_were_stated_are_those_of_every_command() {
    let sandbox = Sandbox::new();
    let times: Vec<i64> = (0..2_000).map(|k| 1_000_000 + 2_000 * k).collect();
    std::fs::write(sandbox.path("us.txt"), recording(&times)).unwrap();
    let ns: Vec<i64> = times.iter().map(|t| 1_000 * t).collect();
    std::fs::write(sandbox.path("ns.txt"), recording(&ns)).unwrap();
    for command in ["convert FILE OUT.txt", "represent FILE --of lnes --out OUT.npy"] {
        let run = |file: &str, more: &str| {
            let line = command.replace("FILE", file).replace("OUT", "out") + more;
            sandbox.run(&line, &[]);
            let ending = if command.starts_with("convert") { "out.txt" } else { "out.npy" };
            crate::harness::bytes(&sandbox.path(ending))
        };
        assert!(run("us.txt", "") == run("ns.txt", " --time-unit ns"), "{command}");
    }
    // Without the unit, minutes of so few events are doubted.
    let few: Vec<i64> = (0..110).map(|k| 1_500_000 * k).collect();
    std::fs::write(sandbox.path("few.txt"), recording(&few)).unwrap();
    for command in COMMANDS {
        let line = command.replace("FILE", "few.txt").replace("OUT", "doubted");
        let output = sandbox.evpose(&line.split(' ').collect::<Vec<_>>()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
        assert!(said.contains("fewer than one a second"), "{line}: {said}");
    }
    let said = sandbox.run("info us.txt --swap-xy", &[]);
    assert!(said.contains("72x96"), "{said}");
    let message = sandbox.fails(&["info", "us.txt", "--sensor", "40x30"]);
    assert!(message.contains("96x72"), "{message}");
    std::fs::write(sandbox.path("huge.txt"), "65535 65535\n1 1 1 1\n").unwrap();
    for command in
        ["info huge.txt", "represent huge.txt --of lnes --out o.npy", "view huge.txt --out v.png"]
    {
        let message = sandbox.fails(&command.split_whitespace().collect::<Vec<_>>());
        assert!(message.contains("larger than any"), "{command}: {message}");
    }
}

#[test]
fn every_command_wants_one_topic_of_a_recording_of_ros() {
    let sandbox = Sandbox::new();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/io/tests/golden/ros");
    std::fs::copy(format!("{golden}/two-topics.mcap"), sandbox.path("two.mcap")).unwrap();
    for command in COMMANDS {
        let line = command.replace("FILE", "two.mcap").replace("OUT", "out");
        let output = sandbox.evpose(&line.split(' ').collect::<Vec<_>>()).output().unwrap();
        assert!(!output.status.success(), "{line}");
        let message = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
        let is_listed =
            message.contains("choose one with --topic") && message.contains("/caer/events");
        assert!(is_listed, "{line}: {message}");
    }
    sandbox.run("convert two.mcap caer.txt --topic /caer/events", &[]);
    // Written as MCAP and read again, a recording is what it was.
    sandbox.run("convert caer.txt caer.mcap", &[]);
    sandbox.run("convert caer.mcap again.txt", &[]);
    let text = |name: &str| crate::harness::bytes(&sandbox.path(name));
    assert!(text("caer.txt") == text("again.txt") && text("caer.txt").len() > 6_000);
    let said = sandbox.run(&format!("info {golden}/evt3-sqlite"), &[]);
    assert!(said.contains("rosbag2") && said.contains("events    600"), "{said}");
}
