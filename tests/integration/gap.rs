//! The gap workflow as a user runs it, on recordings whose hidden effect is known.

use std::path::Path;

use crate::harness::{Sandbox, bytes, stderr};

const WIDTH: usize = 48;
const HEIGHT: usize = 36;
const FRAMES: usize = 601;

/// Light of a scene in which bars of many contrasts move, and pixels rest in between.
fn light(k: usize, x: usize, y: usize) -> f32 {
    let (t, x, y) = (k as f32 / 1000.0, x as f32, y as f32);
    let ground = 0.05 + 0.4 * x / WIDTH as f32;
    let place = (x - 90.0 * t).rem_euclid(24.0) - 8.0;
    let height = 0.1 + 0.5 * y / HEIGHT as f32;
    ground + height * (0.8 * (5.0 - place.abs()) + 0.5).clamp(0.0, 1.0)
}

/// A scene directory, and the recording of a camera with these effects in front of it.
fn recorded(sandbox: &Sandbox, effects: &str) {
    let dir = sandbox.path("scene");
    std::fs::create_dir(&dir).unwrap();
    let header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({FRAMES}, {HEIGHT}, {WIDTH}), }}"
    );
    let mut npy = [b"\x93NUMPY\x01\x00\x76\x00", format!("{header:<117}\n").as_bytes()].concat();
    for k in 0..FRAMES {
        let pixels = (0..WIDTH * HEIGHT).map(|i| light(k, i % WIDTH, i / WIDTH));
        npy.extend(pixels.flat_map(f32::to_le_bytes));
    }
    std::fs::write(dir.join("frames.npy"), npy).unwrap();
    let json = format!(
        "{{\"width\": {WIDTH}, \"height\": {HEIGHT}, \"fps\": 1000, \"duration_s\": 0.6, \
         \"white\": 1.0}}"
    );
    std::fs::write(dir.join("scene.json"), json).unwrap();
    let sensor = format!(
        "[[effect]]\nname = \"logarithmic\"\ndark_offset = 1e-5\n[[effect]]\n\
         name = \"level_crossing\"\nthreshold_on = 0.2\nthreshold_off = 0.2\n{effects}"
    );
    std::fs::write(sandbox.path("camera.toml"), sensor).unwrap();
    let camera = ["--sensor", "camera.toml", "--out", "rec.npz", "--seed", "5"];
    let frames = ["events", "--frames", "scene/frames.npy", "--fps", "1000"];
    sandbox.ok(&[&frames[..], &camera].concat());
}

const RUN: [&str; 6] = ["gap", "run", "--measured", "rec.npz", "--scene", "scene"];

/// The exit code of a run, with what it said.
fn code(sandbox: &Sandbox, args: &[&str]) -> (Option<i32>, String) {
    let output = sandbox.evpose(args).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
    (output.status.code(), said)
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&bytes(path)).unwrap()
}

#[test]
fn a_hidden_leak_is_named_added_and_judged_to_help() {
    let sandbox = Sandbox::new();
    let leak = "rate_hz = 6.0\nspread_decades = 0.1\njitter = 0.1\n";
    recorded(&sandbox, &format!("[[effect]]\nname = \"leak_on\"\n{leak}"));
    let (exit, said) = code(&sandbox, &[&RUN[..], &["--quick", "--out", "gap"]].concat());
    assert_eq!(exit, Some(11), "{said}");
    assert!(said.lines().count() < 45, "{said}");
    let verdict = json(&sandbox.path("gap/verdict.json"));
    assert_eq!(verdict["verdict"], "effects", "{said}");
    assert_eq!(verdict["effects"][0]["name"], "leak_on", "{said}");
    let rate = verdict["effects"][0]["parameters"]["rate_hz"]["value"].as_f64().unwrap();
    assert!((rate / 6.0 - 1.0).abs() < 0.15, "{rate}");
    assert!(verdict["grr"].as_f64().unwrap() > 0.8, "{said}");
    for name in ["run.json", "model.toml", "corrected.toml", "report.json", "report.html"] {
        assert!(sandbox.path(&format!("gap/{name}")).is_file(), "{name}");
    }
    let judged = sandbox.ok(&["gap", "verify", "gap"]);
    assert!(judged.contains("closer"), "{judged}");
    assert_ne!(json(&sandbox.path("gap/verify.json"))["verdict"], "not_closer", "{judged}");
    let page = bytes(&sandbox.path("gap/report.html"));
    std::fs::remove_file(sandbox.path("gap/report.html")).unwrap();
    sandbox.ok(&["gap", "report", "gap"]);
    assert!(page == bytes(&sandbox.path("gap/report.html")));
    // The corrected model is a sensor like any other.
    let out = ["events", "--frames", "scene/frames.npy", "--fps", "1000", "--out", "again.npz"];
    sandbox.ok(&[&out[..], &["--sensor", "gap/corrected.toml"]].concat());
}

#[test]
fn the_same_inputs_give_the_same_bytes_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    recorded(&sandbox, "");
    for (threads, out) in [("1", "a"), ("2", "b")] {
        let more = ["--quick", "--threads", threads, "--out", out];
        let (exit, said) = code(&sandbox, &[&RUN[..], &more].concat());
        assert_eq!(exit, Some(0), "{said}");
    }
    for name in ["verdict.json", "corrected.toml"] {
        assert!(
            bytes(&sandbox.path(&format!("a/{name}")))
                == bytes(&sandbox.path(&format!("b/{name}")))
        );
    }
    // Without a scene there is no gap, and nothing odd in this recording.
    let alone = ["gap", "run", "--measured", "rec.npz", "--scene", "none", "--quick", "--out", "c"];
    let (exit, said) = code(&sandbox, &alone);
    assert!(exit == Some(0) || exit == Some(11), "{said}");
    assert!(json(&sandbox.path("c/verdict.json"))["gap_before"]["value"].is_null());
    sandbox.ok(&["gap", "report", "c"]);
}

#[test]
fn inputs_that_cannot_be_used_end_with_two_and_say_why() {
    let sandbox = Sandbox::new();
    recorded(&sandbox, "");
    let refused = |args: &[&str], part: &str| {
        let (exit, said) = code(&sandbox, args);
        assert_eq!(exit, Some(2), "{args:?}: {said}");
        assert!(said.contains(part), "{args:?}: {said}");
    };
    let run = |measured, scene, more: &[&'static str]| {
        let usual = ["gap", "run", "--out", "gap", "--measured", measured, "--scene", scene];
        [&usual[..], more].concat()
    };
    refused(&run("nowhere.npz", "scene", &[]), "nowhere.npz");
    refused(&run("rec.npz", "nowhere", &[]), "scene.json");
    refused(&run("rec.npz", "scene", &["--model", "idael"]), "ideal");
    refused(&run("rec.npz", "scene", &["--leave-out", "leak"]), "leak_on");
    refused(&run("rec.npz", "scene", &["--validate", "rec.npz"]), "--validate-scene");
    refused(&["gap", "verify", "scene"], "run.json");
    refused(&["gap", "report", "scene"], "report.json");
    refused(&["gap", "bench", "--plan", "7", "--shard", "3/2", "--out", "b"], "--shard");
    refused(&["gap", "bench", "--plan", "nothing.toml", "--out", "b"], "nothing.toml");
    let json = sandbox.path("scene/scene.json");
    let text = std::fs::read_to_string(&json).unwrap();
    std::fs::write(&json, text.replace("\"width\": 48", "\"width\": 36")).unwrap();
    refused(&run("rec.npz", "scene", &[]), "width");
    assert!(!sandbox.path("gap").exists());
}

#[test]
fn twelve_blind_cases_get_their_names_and_nulls_get_none() {
    let sandbox = Sandbox::new();
    let args = ["gap", "bench", "--plan", "7", "--limit", "12", "--out", "bench"];
    let said = sandbox.ok(&args);
    let scores = json(&sandbox.path("bench/scores.json"));
    assert_eq!(scores["cases"], 12, "{said}");
    assert_eq!(scores["nulls_named"]["of"], 0, "{said}");
    let of = |rate: &str, key: &str| scores[rate][key].as_u64().unwrap();
    // Two or three of twelve are visible singles: too few to ask for more than half.
    assert!(2 * of("singles_right", "of") >= of("singles_right", "n"), "{said}");
    assert!(of("wrong_names", "of") <= 1, "{said}");
    assert!(!sandbox.path("bench/cases").exists());
    // All is done already: nothing is named again.
    let again = sandbox.ok(&[&args[..], &["--resume"]].concat());
    assert!(again.contains("0 of 12 cases to do"), "{again}");
}
