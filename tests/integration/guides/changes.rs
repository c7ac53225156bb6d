//! How the commands of the pages are made small enough for a test, and which are not run.

/// A change to a command of a page.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Change {
    /// Not run, for this reason.
    Skip(&'static str),
    /// A text in the place of another.
    Replace(&'static str, &'static str),
    /// Words behind it.
    Append(&'static str),
    /// Exit codes that are answers, in the place of 0.
    Answers(&'static [i32]),
}

/// A change to the commands of a page that hold a text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule {
    /// End of the page's name, or nothing for all pages.
    pub(crate) page: &'static str,
    pub(crate) command: &'static str,
    pub(crate) change: Change,
}

impl Rule {
    pub(crate) fn is_of(&self, page: &str, command: &str) -> bool {
        page.ends_with(self.page) && command.contains(self.command)
    }
}

const fn rule(page: &'static str, command: &'static str, change: Change) -> Rule {
    Rule { page, command, change }
}

/// Words of [`Change`] that stand for `--set KEY=VALUE` of each of these.
pub(crate) const WORDS: &[(&str, &[&str])] = &[
    ("{hand}", crate::harness::TINY),
    ("{body}", crate::harness::BODY_TINY),
    // Recordings for shipped networks, whose shape is fixed.
    ("{people}", PEOPLE),
    ("{hands}", HANDS),
    ("{steps}", STEPS),
];

const PEOPLE: &[&str] = &[
    "simulation.sequences=2",
    "simulation.seconds=0.7",
    "simulation.step_hz=250",
    "simulation.label_hz=50",
    "simulation.surroundings.source={ procedural = 3 }",
    "evaluation.sequences=2",
    "evaluation.seconds=0.7",
];

const HANDS: &[&str] =
    &["simulation.sequences=2", "simulation.seconds=0.5", "training.validation_s=0.2"];

const STEPS: &[&str] = &[
    "training.batch_size=2",
    "training.steps=2",
    "training.steps_per_validation=1",
    "training.validation_samples=2",
];

const HARDWARE: Change = Skip("needs a camera");
const GPU: Change = Skip("needs a GPU and the feature cuda");
const WGPU: Change = Skip("needs the feature wgpu and an adapter");
const RERUN: Change = Skip("needs the feature rerun, whose SDK builds for minutes");
const DOWNLOAD: Change = Skip("downloads");
const PEERS: Change = Skip("needs the feature peers and libraries of others");
const LICENCE: Change = Skip("needs a file that its makers alone distribute");
const WHOLE_PLAN: Change = Skip("takes days: a whole plan of the benchmark");
const FRAMES: Change = Skip("needs a recording with frames, which nothing here writes");
/// The exit code of `evpose gap run` where effects are missing.
const EFFECTS: Change = Answers(&[11]);
/// Exit codes of `evpose infer` where it may find nobody.
const NOBODY: Change = Answers(&[0, 3]);

use Change::{Answers, Append, Replace, Skip};

/// In the order in which they are applied.
pub(crate) const RULES: &[Rule] = &[
    // Of all pages.
    rule("", "cargo run --release --features rerun", RERUN),
    rule("", "--rerun", RERUN),
    rule("", "--source camera", HARDWARE),
    rule("", "--device cuda", GPU),
    rule("", "--device wgpu", WGPU),
    rule("gpu.md", "cargo build", Skip("builds for minutes")),
    rule("gpu.md", "cargo xtask gpu", Skip("builds for minutes")),
    rule("gpu.md", "evpose bench gpu", GPU),
    rule("gpu.md", "target/release/evpose", Replace("target/release/evpose", "evpose")),
    rule("", "evpose gap run", EFFECTS),
    rule("", "evpose simulate quick", Append("{hand}")),
    rule("", "evpose train quick", Append("{hand} --plain")),
    rule("", "evpose bench infer", Append("--config small.toml --runs 3")),
    rule("", "--level avx2", Replace("avx2", "portable")),
    rule("", "--real dhp19_eros", Skip("needs images that may not be passed on")),
    rule(
        "",
        "evpose bench accuracy",
        Append(
            "--set development --development foreign --checkpoint body-quick,hand-quick --out stored",
        ),
    ),
    // README.md
    rule("README.md", "git clone", DOWNLOAD),
    rule("README.md", "cargo xtask ci", Skip("runs all tests, this one among them")),
    rule("README.md", "cargo run --release -- demo", Replace("cargo run --release --", "evpose")),
    rule(
        "README.md",
        "demo",
        Append(
            "--minutes 1 --stride-ms 20 --set evaluation.sequences=1 --set evaluation.seconds=0.4",
        ),
    ),
    rule("README.md", "--serve", Replace("--serve", "--serve 127.0.0.1:0 --speed max")),
    rule("README.md", "evpose train pretrain", Append("{body} --plain")),
    rule("README.md", "evpose gap run", Append("--quick")),
    // commands.md
    rule("commands.md", "--json metrics.json", Append("--stride-ms 20")),
    rule("commands.md", "--conditions", Append("--sequences 1 --seconds 0.4 --stride-ms 20")),
    rule("commands.md", "evpose train configs/body", Append("{body} --plain")),
    rule("commands.md", "evpose simulate finetune", Append("{body}")),
    rule("commands.md", "--serve", Replace("--serve", "--serve 127.0.0.1:0 --speed max")),
    rule("commands.md", "evpose prepare mpii", LICENCE),
    rule("commands.md", "evpose check-labels", Replace("data/mpii ", "")),
    rule("commands.md", "evpose bench train", Append("--config small.toml --steps 2 --batch 2")),
    rule(
        "commands.md",
        "evpose ablate hand",
        Append("{hand} --rows no-filter --seeds 1 --stride-ms 10 --set evaluation.seconds=0.5"),
    ),
    rule("commands.md", "evpose sensor gallery", Append("--only leak_on,davis346 --scale 0.2")),
    rule("commands.md", "evpose calibrate threshold", Replace("--fps 60", "--fps 1000")),
    rule("commands.md", "evpose gap run", Append("--quick")),
    rule("commands.md", "evpose gap payoff", Replace("--data recordings/", "--data data/test")),
    rule("commands.md", "evpose gap payoff", Append("{hand} --stride-ms 20")),
    rule("commands.md", "evpose bench sensor", Append("--seconds 0.05")),
    rule(
        "commands.md",
        "evpose bench sim",
        Append("--config small.toml --sequences 1 --seconds 0.3"),
    ),
    rule(
        "commands.md",
        "evpose bench io",
        Append("--frames 100 --events-per-frame 20 --events 3000 --passes 1"),
    ),
    rule(
        "",
        "evpose bench live --checkpoint",
        Append("--speeds 1 --seconds 1 --input 1 --source rec.raw"),
    ),
    rule("commands.md", "evpose bench repr", Append("--events 3000 --passes 1 --only lnes")),
    rule("commands.md", "MANO_RIGHT.pkl", Replace(" MANO_RIGHT.pkl", "")),
    // bench-infer.md
    rule("bench-infer.md", "evpose bench all", Append("--quick --only sensor")),
    rule("bench-infer.md", "cargo build", PEERS),
    rule("bench-infer.md", "DYLIB_PATH=", PEERS),
    rule("bench-infer.md", "--against", PEERS),
    rule("bench-infer.md", "pip download", DOWNLOAD),
    rule("bench-infer.md", "unzip", DOWNLOAD),
    // networks.md
    rule("networks.md", "--rows backbones", Skip("takes ten minutes: all backbones")),
    // people-3d.md
    rule("people-3d.md", "--held-out", Append("{people}")),
    rule("people-3d.md", "data/four", Replace("--sequences 8", "--sequences 4 --seconds 0.7")),
    rule(
        "people-3d.md",
        "left.raw",
        Replace(
            "left.raw right.raw --cameras rig.toml",
            "data/studio/0000.raw data/studio/0001.raw",
        ),
    ),
    // bodies.md
    rule("bodies.md", "evpose train configs/body", Append("{body} --plain")),
    rule("bodies.md", "evpose simulate finetune", Append("{body}")),
    rule("bodies.md", "evpose ablate body", Append("{body} --steps 2 --seeds 1 --rows pim")),
    rule("bodies.md", "data.source=annotations", LICENCE),
    // compare.md
    rule("compare.md", "--out runs/studio", Skip("takes ten minutes: a small comparison, whole")),
    rule("compare.md", "cargo build --release --features onnx", Skip("builds the program again")),
    rule("compare.md", ".onnx", LICENCE),
    rule("compare.md", "evpose compare clips", Skip("needs images that may not be passed on")),
    rule(
        "compare.md",
        "evpose compare body --out",
        Append("{body} --steps 2 --seeds 1 --systems move-enet,dhp19-cnn,mean-pose"),
    ),
    rule(
        "compare.md",
        "--finetune studio",
        Append("{body} --set simulation.sequences=4 --steps 2 --seeds 1 --systems dhp19-cnn"),
    ),
    rule("compare.md", "--out runs/two", Append("{body} --steps 2 --seeds 1")),
    // calibrate.md
    rule("calibrate.md", "--fps 60", Replace("--fps 60", "--fps 1000")),
    rule("calibrate.md", "--skip 0.5", Replace("--skip 0.5", "--skip 0.2")),
    rule("calibrate.md", "evpose gap run", Append("--quick")),
    // cameras.md
    rule("cameras.md", "evpose simulate body-wide", Replace("--sequences 24", "{people}")),
    rule("cameras.md", "evpose train body-wide", Append("{people} {steps} --plain")),
    rule("cameras.md", "evpose train hand-wide", Replace("data/hands &&", "data/hands {hands} &&")),
    rule("cameras.md", "evpose train hand-wide", Append("{hands} {steps} --plain")),
    rule("cameras.md", "--foreign", Append("foreign --stride-ms 50")),
    rule("cameras.md", "--data eros/", Skip("needs images of a data set, or of `prepare`")),
    rule("cameras.md", "evpose bench cameras", Append("--sequences 1 --seconds 0.5")),
    // gap.md
    rule("gap.md", "--plan 7 --shard", WHOLE_PLAN),
    rule("gap.md", "--sets 200", WHOLE_PLAN),
    rule("gap.md", "gapbench score", WHOLE_PLAN),
    rule("gap.md", "gapbench calibrate", WHOLE_PLAN),
    rule("gap.md", "--scene frames", FRAMES),
    rule("ros.md", "--scene frames", FRAMES),
    // The recording shows a bar, and a hot pixel.
    rule("ros.md", "evpose infer", NOBODY),
    rule("ros.md", "evpose check", Answers(&[10])),
    rule("files.md", "evpose check", Answers(&[0, 10])),
    rule("commands.md", "evpose check rec", Answers(&[0, 10])),
    rule("gap.md", "gapbench cases --plan 11", Replace("--limit 3", "--limit 1")),
    rule("gap.md", "gapbench outside", Skip("needs recordings of other simulators")),
    rule("gap.md", "gapbench real", Append("--quick")),
    rule("gap.md", "evpose gap payoff", Append("{hand}")),
    rule("gap.md", "--out runs/guide/payoff", Append("--stride-ms 20")),
    // gap-examples.md
    rule("gap-examples.md", "runs/none-report", Answers(&[12])),
    // No effect explains all structure of these times.
    rule("gap.md", "--scene none", Answers(&[13])),
    // hands-conditions.md
    rule(
        "hands-conditions.md",
        "--conditions",
        Append("--sequences 1 --seconds 0.4 --stride-ms 20"),
    ),
    // live.md
    rule(
        "live.md",
        "evpose bench live --task",
        Append("--speeds 1 --seconds 1 --input 1 --source rec.raw"),
    ),
    rule("live.md", "--soak", Replace("1e9", "1e5")),
    rule("live.md", "--soak", Append("--source rec.raw")),
    // models.md
    rule("models.md", "MANO_RIGHT.pkl", LICENCE),
    rule("models.md", "SMPLH_male.pkl", LICENCE),
    // networks.md
    rule("networks.md", "--sequences 3600", Replace("--sequences 3600", "{hands}")),
    rule(
        "networks.md",
        "evpose train hand-joints",
        Append("{steps} {hands} --set training.presence_samples=48 --plain"),
    ),
    rule(
        "networks.md",
        "--sequences 2000 --seconds 0.78",
        Replace("--sequences 2000 --seconds 0.78", "{people}"),
    ),
    rule(
        "networks.md",
        "--sequences 420 --seconds 2",
        Replace("--sequences 420 --seconds 2", "{people}"),
    ),
    rule(
        "networks.md",
        "--sequences 600 --seconds 0.78",
        Replace("--sequences 600 --seconds 0.78", "{people}"),
    ),
    rule(
        "networks.md",
        "--sequences 400 --seconds 2.5",
        Replace("--sequences 400 --seconds 2.5", "{people}"),
    ),
    rule(
        "networks.md",
        "--sequences 500 --seconds 0.78",
        Replace("--sequences 500 --seconds 0.78", "{people}"),
    ),
    rule("networks.md", "--sequences 240", Replace("--sequences 240", "{people}")),
    rule("networks.md", "studio --sequences 200", Replace("--sequences 200", "{people}")),
    rule("networks.md", "evpose train body-wide", Append("{steps} --plain")),
    // Networks of a few steps, and a bar where a reader has a person.
    rule("README.md", "evpose infer --checkpoint body", NOBODY),
    rule("commands.md", "evpose infer --checkpoint runs/body", NOBODY),
    rule("bodies.md", "evpose infer --checkpoint runs/body", NOBODY),
    rule("onnx.md", "evpose infer --checkpoint body-quick", NOBODY),
    // own-labels.md
    rule("own-labels.md", "evpose check-labels", Answers(&[2])),
    rule("own-labels.md", "evpose train body-wide", Append("{steps} --plain")),
    // The shipped network has a shape of its own.
    rule(
        "own-labels.md",
        "evpose train quick",
        Append("{steps} --set network.width=0.125 --set simulation.image_scale=0.25"),
    ),
    rule("own-labels.md", "foreign/*.joints.csv", Replace("foreign/", "foreign-hands/")),
    rule("own-labels.md", "evpose view data/own", Replace("data/own/0001", "data/own/0000")),
    // precision.md
    rule("precision.md", "evpose quantize", Append("--windows 4")),
    // tune.md
    rule("tune.md", "evpose tune quick", Append("{hand}")),
    rule("tune.md", "--trials 12", Replace("--trials 12", "--trials 2")),
    rule("tune.md", "--trials 8", Replace("--trials 8", "--trials 2")),
    rule("tune.md", "--method halving", Append("--eta 2 --rungs 2")),
    rule("tune.md", "evpose tune pretrain", Append("{body}")),
    rule("tune.md", "--trials 6", Replace("--trials 6", "--trials 2")),
    // scale.md
    rule("scale.md", "evpose simulate eventhands", Append("{hand}")),
    rule("scale.md", "--sequences 1 --seconds 60", Replace("--seconds 60", "--seconds 0.4")),
    rule("scale.md", "--sequences 268", Replace("268 --seconds 600", "67 --seconds 0.2")),
    rule("scale.md", "--sequences 330", Replace("330 --seconds 600", "66 --seconds 0.2")),
    rule("scale.md", "--sequences 8 --seconds 3", Replace("8 --seconds 3", "1 --seconds 0.3")),
];

/// Files that the reader of a page is supposed to have: its name there, and what stands for it among the
/// inputs of the test.
pub(crate) const INPUTS: &[(&str, &[(&str, &str)])] = &[
    (
        "README.md",
        &[
            ("rec.raw", "moving.raw"),
            ("frames", "frames"),
            ("scene", "scene"),
            ("rec.npz", "scene.npz"),
        ],
    ),
    (
        "commands.md",
        &[
            ("rec.raw", "moving.raw"),
            ("rec.aedat4", "moving.aedat4"),
            ("walk.aedat4", "person.aedat4"),
            ("coco.json", "person.coco.json"),
            ("frames", "frames"),
            ("scene", "scene"),
            ("rec.npz", "scene.npz"),
            ("small.toml", "small.toml"),
            ("foreign", "foreign"),
        ],
    ),
    ("bench-infer.md", &[("small.toml", "small.toml"), ("runs/hand", "runs/hand")]),
    ("bodies.md", &[("rec.raw", "moving.raw")]),
    (
        "calibrate.md",
        &[
            ("board.npz", "scene.npz"),
            ("board", "frames"),
            ("wall.npz", "scene.npz"),
            ("rec.npz", "scene.npz"),
            ("scene", "scene"),
        ],
    ),
    (
        "cameras.md",
        &[
            ("rec.aedat4", "short.aedat4"),
            ("calibration.yaml", "calibration.yaml"),
            ("data/people", "people"),
            ("foreign", "foreign"),
        ],
    ),
    (
        "files.md",
        &[
            ("rec.aedat4", "moving.aedat4"),
            ("rec.raw", "moving.raw"),
            ("rec.npz", "moving.npz"),
            ("rec.h5", "moving.h5"),
            ("other.aedat4", "moving.aedat4"),
            ("simulated.npz", "moving.npz"),
            ("camera.toml", "lens.toml"),
        ],
    ),
    (
        "gap.md",
        &[
            ("camera.toml", "leak.toml"),
            ("scene.toml", "scene.toml"),
            ("davis.aedat4", "scene.aedat4"),
        ],
    ),
    ("hands-conditions.md", &[("runs/demo/train", "runs/hand"), ("slow.npz", "hand.npz")]),
    ("live.md", &[("rec.raw", "short.raw"), ("rec.aedat4", "short.aedat4")]),
    ("networks.md", &[("foreign", "foreign"), ("small.toml", "small.toml")]),
    ("onnx.md", &[("rec.npz", "hand.npz"), ("walk.npz", "person.npz")]),
    (
        "own-labels.md",
        &[
            ("walk.aedat4", "person.aedat4"),
            ("jump.raw", "person.raw"),
            ("walk.csv", "person.csv"),
            ("coco.json", "person.coco.json"),
            ("foreign/0000.npz", "person.npz"),
            ("foreign/0000.coco.json", "person.coco.json"),
            ("foreign-hands/0000.npz", "hand.npz"),
            ("foreign-hands/0000.joints.csv", "hand.joints.csv"),
            ("data/own-test", "people"),
            ("rec.aedat4", "hand.aedat4"),
            ("joints.csv", "hand.joints.csv"),
            ("calibration.yaml", "calibration.yaml"),
            ("data/hands-test", "hands"),
        ],
    ),
    ("ros.md", &[("rec.mcap", "moving.mcap"), ("rec.raw", "moving.raw")]),
    (
        "precision.md",
        &[
            ("runs/hand", "runs/hand"),
            ("data/train", "hands"),
            ("data/test", "hands"),
            ("data/walkers", "people"),
            ("rec.aedat4", "hand.aedat4"),
            ("small.toml", "small.toml"),
        ],
    ),
];

/// Files whose content a page has, in its first block of this language.
pub(crate) const FROM_PAGE: &[(&str, &str, &str)] = &[
    ("gap.md", "camera.toml", "toml"),
    ("hands-conditions.md", "dimmed.toml", "toml"),
    ("tune.md", "over.toml", "toml"),
];
