//! The networks that MoveEnet is compared with, through the commands, in small.

use evpose_io::poses::read_poses;

use crate::harness::{Sandbox, stderr, tiny_body};

/// Networks of either kind, in small.
pub(crate) const BASELINES: [(&str, &str); 2] =
    [("dhp19-cnn", "width = 0.125"), ("lift-mono", "width = 0.125\nstages = 2")];

/// A network of one kind on images of 64x48 pixels.
pub(crate) fn baseline_config(kind: &str, shape: &str) -> String {
    format!(
        "task = \"baseline\"\n[network]\nkind = \"{kind}\"\n{shape}\n[image]\n\
         representation = \"fixed-count:n=400\"\nwidth_px = 64\nheight_px = 48\n[data]\n\
         first_ms = 100\nmin_joints = 4\nvalidation_share = 0.3\nlabel_at = {{ mean_of = 400 }}\n\
         [training]\nbatch_size = 4\nsteps = 4\nsteps_per_validation = 2\nvalidation_samples = 4\n"
    )
}

#[test]
fn a_baseline_is_trained_scored_inferred_and_live() {
    let sandbox = Sandbox::new();
    let still = ["--set", "simulation.moving_cameras=0"];
    sandbox.ok(&[&tiny_body(&["simulate", "finetune", "--out", "data"])[..], &still].concat());
    for (kind, shape) in BASELINES {
        sandbox.write("baseline.toml", baseline_config(kind, shape));
        let said =
            sandbox.run(&format!("train baseline.toml --data data --out {kind} --plain"), &[]);
        assert!(said.contains("16 images in"), "{said}");
        let said = sandbox.ok(&["info", &format!("{kind}/best.bpk")]);
        assert!(said.contains(&format!("{kind}: 13 joints")), "{said}");
        let said = sandbox.run(&format!("eval --checkpoint {kind} --data data --json s.json"), &[]);
        assert!(said.contains("PCK@0.4"), "{said}");
        let scores = sandbox.text("s.json");
        assert!(scores.contains("\"network\""), "{scores}");
        let of_recording = format!("infer --checkpoint {kind} --events data/0000.raw --out p.csv");
        sandbox.run(&of_recording, &["--stride-ms", "50"]);
        assert!(read_poses(&sandbox.path("p.csv")).unwrap().poses.len() > 5);
        let live = format!("live --checkpoint {kind} --source data/0000.raw --speed max");
        sandbox.run(&live, &["--stride-ms", "50", "--json", "p.jsonl"]);
        assert!(!sandbox.text("p.jsonl").is_empty());
        let words: Vec<&str> = of_recording.split(' ').chain(["--min-score", "0.5"]).collect();
        let refused = sandbox.evpose(&words).output().unwrap();
        assert_eq!(refused.status.code(), Some(2));
        let message = stderr(&refused);
        assert!(message.contains("not for the task `baseline`: it is for `body`"), "{message}");
    }
    let message = sandbox.fails(&["simulate", "baseline.toml", "--out", "x"]);
    assert!(message.contains("simulates nothing"), "{message}");
}
