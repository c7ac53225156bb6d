//! One policy of reading: every command, with every kind of disorder.

use evpose_pose::PARAMETER_NAMES;

use crate::gap;
use crate::harness::Sandbox;

/// Times of events, each with its index among those in order.
type Events = Vec<(i64, usize)>;

/// Disorder of a recording, and how commands answer it.
struct Disorder {
    name: &'static str,
    /// Events as they stand in the file, from those in order.
    of: fn(Events) -> Events,
    /// Part of the output of every command; of its error if `is_refused`.
    says: &'static str,
    is_refused: bool,
}

const fn sorted(name: &'static str, of: fn(Events) -> Events, says: &'static str) -> Disorder {
    Disorder { name, of, says, is_refused: false }
}

const fn refused(name: &'static str, of: fn(Events) -> Events) -> Disorder {
    Disorder { name, of, says: "--sort", is_refused: true }
}

const KINDS: [Disorder; 6] = [
    sorted(
        "late",
        |mut events| {
            for some in events.chunks_exact_mut(50) {
                some[38..].rotate_left(1);
            }
            events
        },
        "behind later ones: sorted",
    ),
    sorted(
        "stale",
        |mut events| {
            events[..3].iter_mut().for_each(|(t, _)| *t = 3_000_000_000);
            events
        },
        "far from all others",
    ),
    sorted(
        "wrapped",
        |mut events| {
            let (middle, _) = events[events.len() / 2];
            events.iter_mut().for_each(|(t, _)| *t = (*t - middle).rem_euclid(1 << 32));
            events
        },
        "began again 1 times: unwrapped",
    ),
    refused("restarted", |events| {
        let half = events.len() / 2;
        [&events[..half], &events[..half]].concat()
    }),
    refused("reversed", |events| events.into_iter().rev().collect()),
    refused("shuffled", |events| {
        (0..events.len()).map(|k| events[(k * 1_009) % events.len()]).collect()
    }),
];

/// Commands that read `FILE`.
const COMMANDS: [&str; 17] = [
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
    "infer --checkpoint body-quick --events FILE --out OUT.csv --fused OUT-500.csv --stride-ms 100",
    "infer --checkpoint body-quick --events FILE FILE --cameras rig.toml --out OUT.csv --stride-ms 100",
    "prepare people FILE --labels people.csv --zero-time --out OUT",
    "prepare hands FILE --labels hands.csv --zero-time --for quick --camera 45deg --out OUT",
];

/// Commands that read `FILE`, the recording of a known scene.
const OF_A_SCENE: [&str; 8] = [
    "calibrate threshold --events FILE --frames scene/frames.npy --fps 1000 --zero-time",
    "gap run --measured FILE --scene scene --zero-time --quick --budget 0 --out OUT",
    "gap probe --measured FILE --scene scene --zero-time",
    "gap probe --measured rec.npz --scene scene --validate FILE --validate-scene scene --zero-time",
    "gap locate --measured FILE --scene scene --zero-time",
    "gap name --measured FILE --scene scene --zero-time --budget 0",
    "gap correct --measured FILE --scene scene --zero-time --budget 0 --out OUT.toml",
    "gap ablate --measured FILE --scene scene --zero-time --budget 0",
];

/// Evaluates a run of [`SCENE_RECORDING`] in order.
const VERIFY: &str = "gap verify verified --runs 2";
const SCENE_RECORDING: &str = "measured.txt";

/// Files that commands take beside a recording: labels, calibrated cameras, a scene with its recording `rec.npz`.
pub(crate) fn beside(sandbox: &Sandbox) {
    let times_us = (1..10).map(|k| 50_000 * k);
    let people: String = times_us.clone().map(|t| format!("{t},40,20,44,50\n")).collect();
    let columns = "t_us,head_u_px,head_v_px,hip_l_u_px,hip_l_v_px";
    sandbox.write("people.csv", format!("{columns}\n{people}"));
    let pose = ",0,0,0,0,0,0,0,0,-0.4,0,0,0";
    let hands: String = times_us.map(|t| format!("{t}{pose}\n")).collect();
    let columns = format!("t_us,{}\n", PARAMETER_NAMES.join(","));
    sandbox.write("hands.csv", columns + &hands);
    let camera = |x_m: f64| {
        format!(
            "[[camera]]\nfocal_px = [100.0, 100.0]\nprincipal_px = [48.0, 36.0]\ndistortion = [0.0, 0.0, \
             0.0, 0.0]\nopencv_camera_from_world = [[1.0, 0.0, 0.0, {x_m:?}], [0.0, -1.0, 0.0, 1.2], \
             [0.0, 0.0, -1.0, 3.0]]\n"
        )
    };
    sandbox.write("rig.toml", camera(0.0) + &camera(0.5));
    gap::recorded_part(sandbox, "", 2, 201);
}

/// The recording of the scene in disorder. It begins at a second, with four events more: that is the begin of the scene,
/// before anything moves.
fn scene_recording(sandbox: &Sandbox, of: fn(Events) -> Events) -> String {
    let text = sandbox.text("rec.txt");
    let (size, lines) = text.split_once('\n').unwrap();
    let begin = ["0 0 0 1"; 4];
    let lines = begin.into_iter().chain(lines.lines()).filter_map(|line| line.split_once(' '));
    let (times, pixels): (Vec<&str>, Vec<&str>) = lines.unzip();
    let in_order = times.iter().enumerate();
    let in_order = in_order.map(|(k, t)| (1_000_000 + t.parse::<i64>().unwrap(), k)).collect();
    let lines = of(in_order).into_iter().map(|(t, k)| format!("{t} {}\n", pixels[k]));
    format!("{size}\n{}", lines.collect::<String>())
}

/// Runs a command on a recording of this disorder; its number makes its outputs its own.
fn answers(sandbox: &Sandbox, kind: &Disorder, command: &str, file: &str, number: usize) {
    let out = format!("{}-{number}", kind.name);
    let line = command.replace("FILE", file).replace("OUT", &out);
    let (code, said) = sandbox.ends(&line.split_whitespace().collect::<Vec<_>>());
    assert!(said.contains(kind.says), "{line}: {said}");
    let ways = ["--part", "--join", "--sort"];
    let is_advice = |said: &str| ways.iter().all(|way| said.contains(way));
    assert!(kind.name != "restarted" || is_advice(&said), "{line}: {said}");
    // 3: nobody is in view. What `gap` finds has codes of its own, and so has what `check` advises.
    let is_good = match code {
        Some(0 | 3) => true,
        Some(10) => command.starts_with("check") || command.starts_with("gap"),
        Some(11..=14) => command.starts_with("gap"),
        _ => false,
    };
    assert!(is_good != kind.is_refused || command.starts_with("check"), "{line}: {said}");
}

/// A bar that moves over the sensor.
fn bar(events: &[(i64, usize)]) -> String {
    let line = |(t, k): &(i64, usize)| format!("{t} {} {} {}\n", k / 50 % 96, k * 7 % 72, k % 2);
    "96 72\n".to_owned() + &events.iter().map(line).collect::<String>()
}

/// The bar, in order of these times.
pub(crate) fn recording(times: &[i64]) -> String {
    bar(&times.iter().copied().zip(0..).collect::<Events>())
}

fn in_order() -> Events {
    (0..4_000).map(|k| (1_000_000 + 150 * k as i64, k)).collect()
}

#[test]
fn every_command_answers_every_disorder_alike() {
    let sandbox = Sandbox::new();
    beside(&sandbox);
    sandbox.ok(&["convert", "rec.npz", "rec.txt"]);
    sandbox.write(SCENE_RECORDING, scene_recording(&sandbox, |times| times));
    let run = OF_A_SCENE[1].replace("FILE", SCENE_RECORDING).replace("OUT", "verified");
    sandbox.evpose(&run.split(' ').collect::<Vec<_>>()).output().unwrap();
    for kind in KINDS {
        let file = format!("{}.txt", kind.name);
        sandbox.write(&file, bar(&(kind.of)(in_order())));
        for (number, command) in COMMANDS.iter().enumerate() {
            answers(&sandbox, &kind, command, &file, number);
        }
        let of_scene = scene_recording(&sandbox, kind.of);
        sandbox.write(SCENE_RECORDING, of_scene);
        for (number, command) in (COMMANDS.len()..).zip(OF_A_SCENE.iter().chain([&VERIFY])) {
            answers(&sandbox, &kind, command, SCENE_RECORDING, number);
        }
    }
    // What is sorted is what it would have been in order.
    sandbox.write("ordered.txt", bar(&in_order()));
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
    sandbox.write("us.txt", recording(&times));
    let ns: Vec<i64> = times.iter().map(|t| 1_000 * t).collect();
    sandbox.write("ns.txt", recording(&ns));
    for command in ["convert FILE OUT.txt", "represent FILE --of lnes --out OUT.npy"] {
        let run = |file: &str, more: &str| {
            let line = command.replace("FILE", file).replace("OUT", "out") + more;
            sandbox.run(&line, &[]);
            let ending = if command.starts_with("convert") { "out.txt" } else { "out.npy" };
            crate::harness::bytes(&sandbox.path(ending))
        };
        assert!(run("us.txt", "") == run("ns.txt", " --time-unit ns"), "{command}");
    }
    // Without the unit, so many seconds of so few events are doubted.
    let few: Vec<i64> = (0..110).map(|k| 150_000 * k).collect();
    sandbox.write("few.txt", recording(&few));
    beside(&sandbox);
    for (number, command) in COMMANDS.iter().chain(&OF_A_SCENE).enumerate() {
        let out = format!("doubted-{number}");
        let line = command.replace("FILE", "few.txt").replace("OUT", &out);
        let (_, said) = sandbox.ends(&line.split(' ').collect::<Vec<_>>());
        assert!(said.contains("fewer than ten a second"), "{line}: {said}");
    }
    let said = sandbox.run("info us.txt --swap-xy", &[]);
    assert!(said.contains("72x96"), "{said}");
    let message = sandbox.fails(&["info", "us.txt", "--sensor", "40x30"]);
    assert!(message.contains("96x72"), "{message}");
    sandbox.write("huge.txt", "65535 65535\n1 1 1 1\n");
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
    beside(&sandbox);
    for command in COMMANDS.iter().chain(&OF_A_SCENE) {
        let line = command.replace("FILE", "two.mcap").replace("OUT", "out");
        let (code, message) = sandbox.ends(&line.split(' ').collect::<Vec<_>>());
        assert_ne!(code, Some(0), "{line}");
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
