//! Recordings of the simulator, exported as if they were somebody else's, imported with their
//! labels.

pub(crate) mod foreign;

use std::path::{Path, PathBuf};

use evpose_io::MetaReader;
use evpose_io::poses::read_poses;
use evpose_sim::person::PoseTable;
use evpose_task::Experiment as _;
use evpose_task::hand::{HandConfig, HandView};

use crate::harness::{Sandbox, shipped};

/// A simulated person in `sim`, exported to `foreign`.
pub(crate) fn person() -> Sandbox {
    let sandbox = Sandbox::new();
    let changes = [
        "simulation.sequences=1",
        "simulation.seconds=0.6",
        "simulation.step_hz=250",
        "simulation.label_hz=50",
        "simulation.sensor_size={ width = 128, height = 96 }",
        "simulation.surroundings.source={ procedural = 3 }",
    ];
    let simulate = ["simulate", "finetune", "--out", "sim"];
    let changes = changes.iter().flat_map(|change| ["--set", change]);
    sandbox.ok(&simulate.into_iter().chain(changes).collect::<Vec<_>>());
    assert_eq!(foreign::export(&sandbox.path("sim"), &sandbox.path("foreign")).unwrap(), 1);
    sandbox
}

fn poses(path: &Path) -> PoseTable {
    PoseTable::read(path).unwrap()
}

#[test]
fn people_come_back_as_they_were_exported() {
    let sandbox = person();
    let truth = poses(&sandbox.path("sim/0000.poses.csv"));
    let prepare = ["prepare", "people", "foreign/0000.npz", "--labels"];
    for (labels, out) in [("foreign/0000.coco.json", "coco"), ("foreign/0000.csv", "csv")] {
        let said = sandbox.ok(&[&prepare[..], &[labels, "--out", out]].concat());
        assert!(
            said.contains("sequences: 1, in ") && said.contains("evpose check-labels"),
            "{said}"
        );
        let read = poses(&sandbox.path(&format!("{out}/0000.poses.csv")));
        assert_eq!(read.rows.len(), truth.rows.len());
        for (read, truth) in read.rows.iter().zip(&truth.rows) {
            assert_eq!(read.t, truth.t);
            for (read, truth) in read.joints_px.iter().zip(&truth.joints_px) {
                assert_eq!(read.is_some(), truth.is_some());
                assert!(read.zip(*truth).is_none_or(|(a, b)| a.distance(b) < 0.01));
            }
        }
    }
    let events = |path: &str| evpose_io::open(sandbox.path(path)).unwrap().stream;
    let (imported, simulated) = (events("coco/0000.raw"), events("sim/0000.raw"));
    assert_eq!(imported.iter().next(), simulated.iter().next());
    assert!(imported.len() > simulated.len() * 9 / 10 && imported.sensor() == simulated.sensor());

    // Both commands take the imported files without further arguments.
    let (_, said) = sandbox.ends(&["check-labels", "coco/0000.poses.csv"]);
    assert!(said.contains("1 track"), "{said}");
    let network = shipped("body-quick.bpk");
    let said = sandbox.ok(&["eval", "--checkpoint", &network, "--data", "csv"]);
    assert!(said.contains("PCK"), "{said}");

    let again = sandbox.fails(&[&prepare[..], &["foreign/0000.csv", "--out", "csv"]].concat());
    assert!(again.contains("csv/0000.raw: exists already"), "{again}");
}

#[test]
fn faults_of_labels_are_reported_before_anything_is_written() {
    let sandbox = person();
    let csv = sandbox.text("foreign/0000.csv");
    let late: String = csv.lines().take(1).chain(["9,1,1"]).collect::<Vec<_>>().join("\n");
    let coco = sandbox.text("foreign/0000.coco.json");
    let wrong = "labels.csv: line 3: ankle_r_v_px: `x` is not a finite value";
    let mut lines: Vec<String> = csv.lines().map(str::to_owned).collect();
    lines[2] = lines[2].splitn(3, ',').enumerate().fold(String::new(), |line, (k, cell)| {
        line + if k > 0 { "," } else { "" } + if k == 1 { "x" } else { cell }
    });
    for (name, text, want) in [
        ("labels.csv", lines.join("\n"), wrong),
        ("labels.csv", late, "line 2: 3 cells, expected 27"),
        ("labels.csv", csv.replace("hip_l", "hip"), "no joint `hip`"),
        ("labels.json", coco.replace("\"t_us\"", "\"t\""), "image 0 (`frame_00000.png`): no time"),
        (
            "labels.json",
            coco.replace("\"image_id\":0", "\"image_id\":-5"),
            "annotations[0].image_id",
        ),
        ("labels.json", coco[..coco.len() / 2].to_owned(), "labels.json: line 1 column"),
        ("labels.xml", csv.clone(), "labels of no known format: expected csv"),
    ] {
        sandbox.write(name, text);
        let prepare = ["prepare", "people", "foreign/0000.npz", "--labels", name, "--out", "own"];
        let said = sandbox.fails(&prepare);
        assert!(said.contains(want), "{name}: {said}");
        // Labels are read in full before the first file is written.
        assert!(!sandbox.path("own").exists(), "{name}: something was written");
    }
    let prepare = ["prepare", "people", "foreign/0000.npz", "--labels", "foreign/0000.csv"];
    let said = sandbox.fails(&[&prepare[..], &["--start-us", "90000000", "--out", "own"]].concat());
    assert!(said.contains("labels from 90") && said.contains("--start-us"), "{said}");
    assert!(!sandbox.path("own").exists());
}

/// Joints of the hand of each record, in metres and in pixels of the canonical view.
fn joints(view: &HandView, directory: &Path) -> Vec<evpose_pose::metric::HandPoints> {
    let stem: PathBuf = directory.join("0000");
    let info = evpose_sim::SequenceInfo::beside(&stem).unwrap().unwrap();
    let meta = MetaReader::open(stem.with_extension("meta")).unwrap();
    let point = |frame| view.points(info.hand, &meta.read_hand(frame).unwrap(), &[]);
    (0..meta.records()).map(point).collect()
}

#[test]
fn hands_are_fitted_to_their_joints() {
    let sandbox = Sandbox::new();
    let changes = ["simulation.image_scale=0.5", "simulation.shape_range=0.0"];
    let simulate = ["simulate", "quick", "--sequences", "1", "--seconds", "0.3", "--out", "sim"];
    let changes = changes.iter().flat_map(|change| ["--set", change]);
    sandbox.ok(&simulate.into_iter().chain(changes).collect::<Vec<_>>());
    foreign::export(&sandbox.path("sim"), &sandbox.path("foreign")).unwrap();
    let network = shipped("hand-quick.bpk");
    let prepare = ["prepare", "hands", "foreign/0000.npz", "--labels", "foreign/0000.joints.csv"];
    let network_of = ["--for", network.as_str(), "--camera", "45deg"];
    let config = HandConfig::read(&sandbox.path("sim/config.toml")).unwrap();
    let view = HandView::new(&config).unwrap();
    let truth = joints(&view, &sandbox.path("sim"));
    for (flags, out, max_mm) in
        [(&["--scale", "1"][..], "3d", 1.0), (&["--2d"], "2d", f32::INFINITY)]
    {
        let args = [&prepare[..], &network_of, flags, &["--out", out]].concat();
        let said = sandbox.ok(&args);
        assert!(said.contains("mean residual 0."), "{said}");
        let fitted = joints(&view, &sandbox.path(out));
        // Labels are 10 ms apart, the last at 290 ms.
        assert_eq!(fitted.len(), 291);
        for (frame, (fitted, truth)) in fitted.iter().zip(&truth).enumerate() {
            for joint in 0..21 {
                let mm = 1e3 * fitted.world_m[joint].distance(truth.world_m[joint]);
                assert!(mm < max_mm, "{out}: frame {frame}, joint {joint}: {mm} mm");
                let [a, b] = [fitted, truth].map(|points| points.image_px[joint].unwrap());
                assert!(a.distance(b) < 1.0, "{out}: frame {frame}, joint {joint}: {a} {b}");
            }
        }
    }
    let said = sandbox.ok(&["eval", "--checkpoint", &network, "--data", "3d", "--stride-ms", "40"]);
    assert!(said.contains("AUC"), "{said}");
}

#[test]
fn parameters_come_back_and_left_hands_are_mirrored() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "quick", "--sequences", "1", "--seconds", "0.3", "--out", "sim"];
    sandbox.ok(&simulate);
    let network = shipped("hand-quick.bpk");
    let infer = ["infer", "--checkpoint", &network, "--events", "sim/0000.evc", "--unfiltered"];
    sandbox.ok(&[&infer[..], &["--out", "p.csv"]].concat());
    let convert = ["convert", "sim/0000.evc", "rec.npz"];
    sandbox.ok(&convert);
    let prepare = ["prepare", "hands", "rec.npz", "--labels", "p.csv", "--for", "quick", "--out"];
    sandbox.ok(&[&prepare[..], &["right"]].concat());
    let said = sandbox.ok(&[&prepare[..], &["left", "--side", "left"]].concat());
    assert!(said.contains("mirror image"), "{said}");
    let text = sandbox.text("p.csv");
    let read = |out: &str| {
        MetaReader::open(sandbox.path(&format!("{out}/rec.meta"))).unwrap().read_hand(10).unwrap()
    };
    let poses = read_poses(&sandbox.path("p.csv")).unwrap().poses;
    let (right, left) = (read("right"), read("left"));
    // The first record is the pose at the end of the first frame.
    assert_eq!(Some(right), poses[10].params);
    assert_eq!(left.articulation, right.articulation);
    let config = HandConfig::read(&sandbox.path("sim/config.toml")).unwrap();
    let back = HandView::new(&config).unwrap().mirrored(&left);
    assert!(back.translation_m.distance(right.translation_m) < 1e-5);

    sandbox.write("q.csv", text.replace("rotation_z_rad", "rz"));
    let prepare = ["prepare", "hands", "rec.npz", "--labels", "q.csv", "--for", "quick"];
    let said = sandbox.fails(&[&prepare[..], &["--out", "bad"]].concat());
    assert!(said.contains("q.csv: line 1: no column `rotation_z_rad`"), "{said}");
    assert!(!sandbox.path("bad").exists());
}
