//! A camera from recordings of unknown light, as a user measures it.

use crate::gap::recorded;
use crate::harness::Sandbox;

#[test]
fn recordings_make_a_sensor_to_simulate_with_and_a_list_of_what_is_not_known() {
    let sandbox = Sandbox::new();
    recorded(&sandbox, "[[effect]]\nname = \"uniform_noise\"\non_hz = 2.0\noff_hz = 1.0\n");
    let said = sandbox.ok(&["gap", "camera", "rec.npz", "--out", "camera"]);
    assert!(said.contains("read      rec.npz") && said.contains("would show: "), "{said}");
    let report = sandbox.json("camera/camera.json");
    assert!(report["commit"].is_string() && report["version"].is_string());
    // Bars pass all the time: how much of the events is background is not known.
    let ratio = &report["quantities"][0];
    assert_eq!(ratio["name"], "threshold_ratio");
    assert!(ratio["value"].is_null() && said.contains("hold the camera still"), "{said}");
    // Something moves: there is no background to be read.
    assert!(said.contains("unknown   background_on_hz"), "{said}");
    let page = sandbox.text("camera/camera.html");
    assert!(["rec.npz", "data:image/png"].iter().all(|part| page.contains(part)));
    let sensor = ["--sensor", "camera/camera.toml", "--out", "again.npz"];
    sandbox
        .ok(&[&["events", "--frames", "scene/frames.npy", "--fps", "1000"], &sensor[..]].concat());
    sandbox.ok(&["gap", "camera", "rec.npz", "--threads", "1", "--out", "one"]);
    assert_eq!(sandbox.text("one/camera.json"), sandbox.text("camera/camera.json"));
}

#[test]
fn recordings_of_two_cameras_end_with_two_and_say_which() {
    let sandbox = Sandbox::new();
    for (name, side) in [("a.txt", 40), ("b.txt", 20)] {
        let lines = (0..side).map(|k| format!("{} {k} {k} 1\n", 10_000 * k));
        sandbox.write(name, lines.collect::<String>());
    }
    let refused = |recordings: &[&str], parts: &[&str]| {
        let (exit, said) = sandbox.ends(&[&["gap", "camera", "--out", "o"], recordings].concat());
        assert_eq!(exit, Some(2), "{said}");
        assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    };
    refused(&["a.txt", "b.txt"], &["a.txt", "b.txt", "40x40", "--sensor"]);
    refused(&["a.txt", "a.txt"], &["a.txt: given twice"]);
    refused(&["nowhere.npz"], &["nowhere.npz"]);
    assert!(!sandbox.path("o").exists());
}
