//! The comparison of systems, small.

use crate::harness::{Sandbox, bytes, tiny_body};

#[cfg(feature = "onnx")]
#[path = "../../crates/studies/tests/external/onnx.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod onnx;

const SYSTEMS: &str = "move-enet,move-enet-fixed-count,dhp19-cnn,lift-mono,openpose-grey,mean-pose";

fn compare<'a>(out: &'a str, systems: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let steps = ["--steps", "2", "--seeds", "2", "--jobs", "2", "--out", out];
    let mut args = tiny_body(&["compare", "body", "--systems", systems]);
    // Cameras on tripods, whose places are known, as LiftMono-HPE needs them.
    args.extend([
        "--set",
        "simulation.moving_cameras=0.0",
        "--set",
        "evaluation.moving_cameras=0.0",
    ]);
    args.extend(steps);
    args.extend(more);
    args
}

fn outcome(sandbox: &Sandbox, out: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(&sandbox.path(out).join("comparison.json"))).expect("JSON")
}

fn system<'a>(outcome: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let mut systems = outcome["rows"].as_array().expect("systems").iter();
    systems.find(|system| system["name"] == name).expect("a system")
}

#[test]
fn systems_are_trained_evaluated_and_compared_and_kept() {
    let sandbox = Sandbox::new();
    let said = sandbox.ok(&compare("cmp", SYSTEMS, &[]));
    assert!(said.contains("6 networks to train, 2 at once"), "{said}");
    assert!(said.contains("openpose-grey does not run: give --openpose"), "{said}");
    let comparison = outcome(&sandbox, "cmp");
    for name in ["move-enet", "move-enet-fixed-count", "dhp19-cnn", "lift-mono", "mean-pose"] {
        let system = system(&comparison, name);
        assert_eq!(system["per_seed"].as_array().map(Vec::len), Some(2), "{system}");
        assert_eq!(system["curve"].as_array().map(Vec::len), Some(100), "{system}");
        assert!(system["missing"].is_null(), "{system}");
    }
    let measures = |name: &str| -> Vec<String> {
        system(&comparison, name)["means"].as_object().expect("means").keys().cloned().collect()
    };
    // Only one estimates depth; the mean pose takes no time.
    assert!(measures("lift-mono").contains(&"mpjpe_mm".to_owned()));
    assert!(!measures("move-enet").contains(&"mpjpe_mm".to_owned()));
    assert!(measures("dhp19-cnn").contains(&"poses_per_s".to_owned()));
    assert!(!measures("mean-pose").contains(&"poses_per_s".to_owned()));
    // No figure stands for a system that did not run.
    let missing = system(&comparison, "openpose-grey");
    assert_eq!(missing["means"], serde_json::json!({}), "{missing}");
    let findings = comparison["findings"].as_array().expect("findings");
    let verdict = |start: &str| {
        let is_it =
            |o: &&serde_json::Value| o["published"].as_str().unwrap_or("").starts_with(start);
        findings.iter().find(is_it).map(|finding| finding["verdict"].clone())
    };
    assert!(
        verdict("lift-mono worse than move-enet: PCK@0.4")
            .is_some_and(|verdict| verdict.is_string())
    );
    assert!(verdict("move-enet worse than openpose-grey").is_some_and(|verdict| verdict.is_null()));
    let page = sandbox.text("cmp/comparison.html");
    assert!(page.contains("<svg") && page.contains("lift-mono worse than move-enet"));
    let markdown = sandbox.text("cmp/comparison.md");
    let row = |line: &str| line.starts_with("| dhp19-cnn ") && line.contains(" 7500 events |");
    assert!(markdown.lines().any(row), "{markdown}");

    let refused = sandbox.fails(&compare("cmp", SYSTEMS, &[]));
    assert!(refused.contains("--resume"), "{refused}");
    let before = bytes(&sandbox.path("cmp/comparison.json"));
    let again = sandbox.ok(&compare("cmp", SYSTEMS, &["--resume"]));
    assert!(!again.contains("networks to train") && !again.contains("trained,"), "{again}");
    assert_eq!(bytes(&sandbox.path("cmp/comparison.json")), before);

    // The same recordings, given as directories: the networks of another comparison.
    let [train, test] = ["train", "held-out"].map(|set| format!("cmp/data/seed-1/{set}"));
    let given = ["--train", train.as_str(), "--data", test.as_str()];
    let refused =
        sandbox.fails(&compare("cmp", "mean-pose", &[&given[..], &["--resume"]].concat()));
    assert!(refused.contains("data.json differs"), "{refused}");
    sandbox.ok(&compare("given", "mean-pose", &given));
    let of =
        |outcome: &serde_json::Value| system(outcome, "mean-pose")["per_seed"][0]["pck"].clone();
    assert_eq!(of(&outcome(&sandbox, "given")), of(&comparison));
}

#[test]
fn what_cannot_be_compared_is_said_before_anything_is_done() {
    let sandbox = Sandbox::new();
    let message = sandbox.fails(&compare("x", "no-such-system", &[]));
    assert!(message.contains("openpose-pim") && message.contains("dhp19-cnn"), "{message}");
    let message = sandbox.fails(&compare("x", "movenet-grey,openpose-pim", &[]));
    assert!(message.contains("no system can be run") && message.contains("--movenet"), "{message}");
    let message = sandbox.fails(&compare("x", "movenet-grey", &["--movenet", "no.onnx"]));
    let wanted = if cfg!(feature = "onnx") { "no.onnx: " } else { "--features onnx" };
    assert!(message.contains(wanted), "{message}");
    assert!(!sandbox.path("x").exists());
    assert!(sandbox.ok(&["compare", "body", "--help"]).contains("evpose compare body"));
}

#[cfg(feature = "onnx")]
#[test]
fn networks_of_others_run_from_their_files() {
    use evpose_pose::body::OpenPoseModel;

    let sandbox = Sandbox::new();
    let file = |name: &str, bytes: &[u8]| sandbox.write(name, bytes);
    file("movenet.onnx", &onnx::movenet(16, true));
    file("openpose.onnx", &onnx::openpose(OpenPoseModel::Coco18, onnx::Maps::Apart, 0.5));
    let systems = "openpose-grey,openpose-pim,movenet-grey";
    let files = ["--openpose", "openpose.onnx", "--movenet", "movenet.onnx"];
    sandbox.ok(&compare("cmp", systems, &files));
    let comparison = outcome(&sandbox, "cmp");
    for name in ["openpose-grey", "openpose-pim", "movenet-grey"] {
        let system = system(&comparison, name);
        assert!(system["missing"].is_null(), "{system}");
        assert!(system["per_seed"][0]["poses_per_s"].as_f64().is_some_and(|hz| hz > 0.0));
        let digest = system["per_seed"][0]["weights"].as_str();
        assert!(digest.is_some_and(|digest| digest.len() == 64), "{system}");
    }
    // OpenPose of the test sees people of the same place in whatever is mid-grey, as integrated
    // polarities are where nothing happens.
    let curve = |name: &str| system(&comparison, name)["curve"].clone();
    assert_ne!(curve("openpose-grey"), curve("movenet-grey"));
    // Another file is another network.
    file("movenet.onnx", &onnx::movenet(32, true));
    sandbox.ok(&compare("cmp", systems, &[&files[..], &["--resume"]].concat()));
    assert_ne!(
        system(&outcome(&sandbox, "cmp"), "movenet-grey")["per_seed"][0]["weights"],
        system(&comparison, "movenet-grey")["per_seed"][0]["weights"]
    );
}

/// Two clips of three images each: joints on an oblique line, which is drawn.
pub(crate) fn write_clips(sandbox: &Sandbox) {
    for (clip, shift) in [("a", 0.0), ("b", 0.1)] {
        let folder = sandbox.path("clips").join(clip);
        std::fs::create_dir_all(folder.join("images")).expect("folders");
        let label = |index: u32| {
            let name = format!("{clip}_{index:05}.png");
            let bright = |x: u32, y: u32| image::Luma([255 * u8::from(x + index == y)]);
            let image = image::GrayImage::from_fn(64, 48, bright);
            image.save(folder.join("images").join(&name)).expect("an image");
            let place = |k| [0.2 + shift + 0.04 * f64::from(k), 0.1 + 0.06 * f64::from(k), 2.0];
            let keypoints: Vec<f64> = (0..13).flat_map(place).collect();
            serde_json::json!({ "img_name": name, "keypoints": keypoints,
                "center": [0.5, 0.5], "head_size": 0.1, "torso_size": 0.3 })
        };
        let labels = serde_json::json!((0..3).map(label).collect::<Vec<_>>());
        std::fs::write(folder.join("poses.json"), labels.to_string()).expect("labels");
    }
}

#[test]
fn every_clip_is_left_out_once_and_evaluated_with_and_without_fine_tuning() {
    let sandbox = Sandbox::new();
    write_clips(&sandbox);
    let small = tiny_body(&["compare", "clips", "clips", "--config", "pretrain"]);
    // Three steps, the last of them alone behind a validation.
    let short = ["--set", "training.steps=3", "--set", "training.steps_per_validation=2"];
    let clips = |more: &[&'static str]| [&small[..], &short, more].concat();
    let start = ["train", "pretrain", "--data", "clips/a", "--out", "start"];
    let annotated = ["--set", "data.source=annotations", "--data", "clips/b"];
    sandbox.ok(&[&tiny_body(&start)[..], &annotated].concat());
    let in_study = ["--start", "start", "--out", "study"];
    let said = sandbox.ok(&clips(&[&in_study[..], &["--json", "stored.json"]].concat()));
    assert!(said.contains("start, fine-tuned: training on all clips but b"), "{said}");
    let stored = bytes(&sandbox.path("stored.json"));
    let outcome: serde_json::Value = serde_json::from_slice(&stored).expect("JSON");
    let rows = outcome["rows"].as_array().expect("rows");
    let names: Vec<&str> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(names, ["from nothing", "start", "start, fine-tuned"]);
    for row in rows {
        let clips = row["clips"].as_array().expect("clips");
        let of = |field: &'static str| clips.iter().filter_map(move |clip| clip[field].as_f64());
        assert_eq!((clips.len(), of("images").sum::<f64>()), (2, 6.0), "{row}");
        let mean = of("pck_40").sum::<f64>() / 2.0;
        assert!(row["pck_40"].as_f64().is_some_and(|pck| (pck - mean).abs() < 1e-12), "{row}");
        // On the clip that was left out.
        let curve = clips[0]["learning_curve"].as_array();
        let steps = curve.into_iter().flatten().filter_map(|point| point[0].as_u64());
        let wanted: &[u64] = if row["name"] == "start" { &[] } else { &[2, 3] };
        assert_eq!(steps.collect::<Vec<_>>(), wanted, "{row}");
    }
    assert!(outcome["published"].to_string().contains("0.97"), "{outcome}");
    let page = sandbox.text("study/clips.html");
    assert!(page.contains("from nothing") && page.contains("<svg"));

    assert!(sandbox.fails(&clips(&in_study)).contains("--resume"));
    let again = sandbox.ok(&clips(&[&in_study[..], &["--resume"]].concat()));
    assert!(!again.contains("training on"), "{again}");
    // Other inputs are another study, and two networks of one name would be one row.
    let other = ["--start", "start/last.bpk", "--out", "study", "--resume"];
    assert!(sandbox.fails(&clips(&other)).contains("inputs.txt"));
    let twice = ["--start", "start/last.bpk,./start/last.bpk", "--out", "other"];
    assert!(sandbox.fails(&clips(&twice)).contains("one name"));
    std::fs::remove_dir_all(sandbox.path("clips/b")).expect("removed");
    let refused = sandbox.fails(&clips(&["--out", "other"]));
    assert!(refused.contains("two are needed"), "{refused}");
}
