//! Files that readers of the pages are supposed to have: recordings, labels, frames, a trained network.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use image::{ImageBuffer, Luma};

use crate::gap;
use crate::harness::{Sandbox, tiny};
use crate::own_labels::foreign;

use super::changes::{INPUTS, WORDS};

/// Inputs of some pages, in a directory.
pub(crate) struct Inputs {
    sandbox: Sandbox,
}

/// Names of inputs, and who makes them.
type Group = (&'static [&'static str], fn(&Sandbox));

const GROUPS: [Group; 4] = [
    (&["moving", "short", "lens.toml"], moving),
    (&["scene", "frames", "leak.toml"], scene),
    (&["hand", "runs/hand", "calibration.yaml"], hands),
    (&["people", "person"], people),
];

const SMALL: &str = "task = \"hand\"\n[simulation]\nimage_scale = 0.3\n[network]\nwidth = 0.0625\n";

/// A camera that the hands of the guide to the gap are recorded with.
const SCENE: &str = "task = \"hand\"\nseed = 11\n[training]\nvalidation_s = 0.1\n[simulation]\nsequences = 2\nseconds = \
    1.0\nimage_scale = 0.25\nthreshold_sd = 0.0\nsensor = { effect = [\n  { name = \"logarithmic\", \
    dark_offset = 0.001 },\n  { name = \"level_crossing\", threshold_on = 0.2, threshold_off = 0.2 \
    },\n  { name = \"leak_on\", rate_hz = 15.0 },\n] }\n";

const CALIBRATION: &str = "%YAML:1.0\n---\nimage_width: 346\nimage_height: 260\ncamera_matrix: \
    !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 310., 0., 173., 0., 310., 130., 0., 0., \
    1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.1, \
    0.01, 0., 0., 0. ]\n";

const LENS: &str = "sensor = [346, 260]\nfocal_px = [310.0, 310.0]\nprincipal_px = [173.5, 130.5]\n\
                    distortion = [-0.1, 0.01, 0.0, 0.0, 0.0]\n";

impl Inputs {
    /// Makes what these pages need.
    pub(crate) fn of(pages: &[&str]) -> Self {
        let sandbox = Sandbox::new();
        fs::write(sandbox.path("small.toml"), SMALL).unwrap();
        fs::write(sandbox.path("scene.toml"), SCENE).unwrap();
        // Only what these pages need: inputs take time to make.
        let of_pages = INPUTS.iter().filter(|(page, _)| pages.iter().any(|p| p.ends_with(page)));
        let wanted: Vec<&str> =
            of_pages.flat_map(|(_, inputs)| inputs.iter().map(|i| i.1)).collect();
        for (names, make) in GROUPS {
            if names.iter().any(|name| wanted.iter().any(|input| input.starts_with(name))) {
                make(&sandbox);
            }
        }
        foreign_set(&sandbox.path("foreign"));
        Self { sandbox }
    }

    pub(crate) fn put(&self, page: &str, directory: &Path) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for name in ["configs", "checkpoints"] {
            copy(&root.join(name), &directory.join(name));
        }
        for (_, inputs) in INPUTS.iter().filter(|(of, _)| page.ends_with(of)) {
            for (name, input) in *inputs {
                copy(&self.sandbox.path(input), &directory.join(name));
            }
        }
    }
}

/// `--set` and each of the changes that a word stands for.
fn with(args: &[&'static str], word: &str) -> Vec<&'static str> {
    let changes = WORDS.iter().find(|(known, _)| *known == word).unwrap().1;
    args.iter().copied().chain(changes.iter().flat_map(|change| ["--set", *change])).collect()
}

/// A bar that moves over a DAVIS346 for 3.2 s, and a hot pixel.
fn moving(sandbox: &Sandbox) {
    let mut text = String::new();
    for t_ms in (0..3200).step_by(2) {
        let (t_us, x) = (1000 * t_ms, 12 + t_ms / 10);
        // A pixel that never rests beside edges that move.
        let _ = writeln!(text, "{t_us} 5 5 1");
        for y in (60..200).step_by(4) {
            let _ = writeln!(text, "{t_us} {x} {y} 1\n{t_us} {} {y} 0", x - 12);
        }
    }
    fs::write(sandbox.path("moving.txt"), text).unwrap();
    // Pages read the recording in several formats.
    for out in ["moving.raw", "moving.aedat4", "moving.npz", "moving.h5", "moving.mcap"] {
        sandbox.ok(&["convert", "moving.txt", out, "--sensor", "346x260"]);
    }
    for out in ["short.raw", "short.aedat4"] {
        sandbox.ok(&["convert", "moving.npz", out, "--to", "0.3"]);
    }
    fs::write(sandbox.path("lens.toml"), LENS).unwrap();
}

/// Known light, as a scene and as frames, and what a camera with a leak recorded of it.
fn scene(sandbox: &Sandbox) {
    gap::recorded(sandbox, "[[effect]]\nname = \"leak_on\"\nrate_hz = 8.0\n");
    fs::rename(sandbox.path("camera.toml"), sandbox.path("leak.toml")).unwrap();
    fs::rename(sandbox.path("rec.npz"), sandbox.path("scene.npz")).unwrap();
    sandbox.ok(&["convert", "scene.npz", "scene.aedat4"]);
    fs::create_dir(sandbox.path("frames")).unwrap();
    for k in 0..gap::FRAMES {
        let code =
            |x, y| Luma([(65_535.0 * gap::light(k, x as usize, y as usize).min(1.0)) as u16]);
        let frame = ImageBuffer::from_fn(gap::WIDTH as u32, gap::HEIGHT as u32, code);
        frame.save(sandbox.path(&format!("frames/{k:04}.png"))).unwrap();
    }
}

/// Simulated hands, one of them as a file of another program, and a network trained on them.
fn hands(sandbox: &Sandbox) {
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "hands"]));
    sandbox.ok(&tiny(&["train", "quick", "--data", "hands", "--out", "runs/hand", "--plain"]));
    foreign::export(&sandbox.path("hands"), &sandbox.path("exported-hands")).unwrap();
    let exported = |name: &str| sandbox.path(&format!("exported-hands/0000.{name}"));
    fs::copy(exported("npz"), sandbox.path("hand.npz")).unwrap();
    fs::copy(exported("joints.csv"), sandbox.path("hand.joints.csv")).unwrap();
    sandbox.ok(&["convert", "hand.npz", "hand.aedat4"]);
    fs::write(sandbox.path("calibration.yaml"), CALIBRATION).unwrap();
}

/// Simulated people, one of them as files of other programs.
fn people(sandbox: &Sandbox) {
    sandbox.ok(&with(&["simulate", "finetune", "--held-out", "--out", "people"], "{people}"));
    foreign::export(&sandbox.path("people"), &sandbox.path("exported-people")).unwrap();
    for ending in ["npz", "csv", "coco.json"] {
        let exported = sandbox.path(&format!("exported-people/0000.{ending}"));
        fs::copy(exported, sandbox.path(&format!("person.{ending}"))).unwrap();
    }
    for out in ["person.aedat4", "person.raw"] {
        sandbox.ok(&["convert", "person.npz", out]);
    }
}

/// One hand and one person of the recordings that no simulation of this project made.
fn foreign_set(directory: &Path) {
    let of = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/development");
    for kind in ["hands", "bodies"] {
        fs::create_dir_all(directory.join(kind)).unwrap();
        for path in entries(&of.join(kind)) {
            let name = path.file_name().unwrap().to_owned();
            if name.to_string_lossy().starts_with("00.") {
                fs::copy(&path, directory.join(kind).join(name)).unwrap();
            }
        }
    }
}

fn entries(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().path()).collect()
}

/// Copies a file or a directory, with the directories above it.
fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for path in entries(from) {
            copy(&path, &to.join(path.file_name().unwrap()));
        }
    } else {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(from, to).unwrap_or_else(|error| panic!("{}: {error}", from.display()));
    }
}
