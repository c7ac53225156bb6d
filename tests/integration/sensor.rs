//! `evpose sensor`: what a reader sees of cameras and effects.

use crate::harness::Sandbox;

#[test]
fn lists_chains_and_effects_read_well_at_a_hundred_columns() {
    let sandbox = Sandbox::new();
    let list = sandbox.ok(&["sensor", "list"]);
    let chain = sandbox.ok(&["sensor", "show", "davis346"]);
    let effect = sandbox.ok(&["sensor", "show", "leak_on"]);
    for line in [&list, &chain, &effect].into_iter().flat_map(|text| text.lines()) {
        assert!(line.chars().count() <= 100 && line == line.trim_end(), "{line:?}");
    }
    insta::assert_snapshot!("sensor_list", list);
    insta::assert_snapshot!("sensor_show_davis346", chain);
    insta::assert_snapshot!("sensor_show_leak_on", effect);
}

#[test]
fn machines_get_values() {
    let sandbox = Sandbox::new();
    let json: serde_json::Value =
        serde_json::from_str(&sandbox.ok(&["sensor", "show", "davis346", "--json"])).unwrap();
    let stages = json["stages"].as_array().unwrap();
    let arbiter = stages.iter().find(|stage| stage["name"] == "arbiter").unwrap();
    assert_eq!(arbiter["parameters"][0]["value"], 12e6);
    assert_eq!(arbiter["parameters"][2]["value"], "inf");
    let list: serde_json::Value =
        serde_json::from_str(&sandbox.ok(&["sensor", "list", "--json"])).unwrap();
    assert_eq!(list["presets"].as_array().unwrap().len(), 10);
    assert!(list["effects"].as_array().unwrap().iter().any(|e| e["name"] == "leak_on"));
}

#[test]
fn a_slip_names_what_was_meant() {
    let sandbox = Sandbox::new();
    let message = sandbox.fails(&["sensor", "show", "davis34"]);
    assert!(message.contains("did you mean davis346"), "{message}");
    let message = sandbox.fails(&["sensor", "tap", "leak_on", "--pixel", "1,2"]);
    assert!(message.contains("`leak_on` is an effect, not a sensor"), "{message}");
    sandbox.write("mine.toml", "[[effect]]\nname = \"leek_on\"\n");
    let message = sandbox.fails(&["sensor", "show", "mine.toml"]);
    assert!(message.contains("mine.toml") && message.contains("did you mean leak_on"), "{message}");
    let message = sandbox.fails(&["sensor", "tap", "ideal", "--pixel", "500,2"]);
    assert!(message.contains("not on a 240x180 sensor"), "{message}");
}

/// `V = ln(I + 0.001)` takes 1.59 up and down again: seven thresholds of 0.2 each way.
#[test]
fn a_tapped_step_has_the_events_it_is_worth() {
    let sandbox = Sandbox::new();
    sandbox.ok(&["sensor", "tap", "ideal", "--pixel", "20,30", "--out", "tap.csv"]);
    let csv = sandbox.text("tap.csv");
    let events: Vec<(f64, f64)> = csv
        .lines()
        .filter_map(|line| line.split_once(",event:signal,"))
        .map(|(t_s, sign)| (t_s.parse().unwrap(), sign.parse().unwrap()))
        .collect();
    assert_eq!(events.len(), 14, "{csv}");
    for (k, (t_s, sign)) in events.iter().enumerate() {
        // Seven rises, then seven falls.
        let (edge_s, expected) = if k < 7 { (0.05, 1.0) } else { (0.15, -1.0) };
        assert_eq!(*sign, expected);
        // Events come within the step that ends at the edge.
        assert!((edge_s - 1e-4..=edge_s).contains(t_s), "{t_s}");
    }
}

#[test]
fn a_gallery_is_one_page_that_holds_everything() {
    let sandbox = Sandbox::new();
    let only = "ideal,leak_on,timestamp_quantisation";
    sandbox.ok(&["sensor", "gallery", "--out", "g.html", "--only", only, "--scale", "0.2"]);
    let page = sandbox.text("g.html");
    for text in
        ["leak_on", "rate_hz = 0.1 Hz", "Nozaki", "without", "data:image/png;base64,", "<svg"]
    {
        assert!(page.contains(text), "{text} is missing");
    }
    assert!(!page.contains("src=\"http") && !page.contains("photoreceptor_lowpass"));
    let message = sandbox.fails(&["sensor", "gallery", "--out", "g.html", "--only", "leek_on"]);
    assert!(message.contains("leak_on"), "{message}");
}
