//! The programs of `examples/` run without arguments. `cargo test` builds them beside the tests.

use std::path::Path;
use std::process::Command;

/// Standard output of an example.
fn output_of(example: &str) -> String {
    let programs = Path::new(env!("CARGO_BIN_EXE_evpose")).parent().unwrap();
    let path = programs.join("examples").join(example);
    let output = Command::new(&path).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    let output = output.unwrap_or_else(|error| {
        panic!("{}: {error}; `cargo build --examples` makes it", path.display())
    });
    assert!(output.status.success(), "{example}:\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn windows_of_a_recording_become_lnes() {
    let output = output_of("lnes_windows");
    assert!(output.lines().count() >= 8, "{output}");
    assert!(output.contains("3072"), "every window holds the same stretch of the bar:\n{output}");
}

#[test]
fn frames_become_events() {
    let output = output_of("frames_to_events");
    assert!(output.contains("of them ON"), "{output}");
}

#[test]
fn the_custom_effect_costs_events_the_more_the_stronger_it_is() {
    let output = output_of("custom_effect");
    let counts = output.lines().map(|line| line.split_whitespace().nth(2).unwrap().parse());
    let counts: Vec<u64> = counts.collect::<Result<_, _>>().unwrap();
    assert!(counts.len() == 4 && counts.is_sorted_by(|a, b| a > b), "{output}");
}

#[test]
fn the_custom_representation_shows_the_sign_of_the_latest_events() {
    let output = output_of("custom_representation");
    // ON at the front of the bar, OFF behind it, forgotten after four milliseconds.
    assert_eq!(output.lines().last(), Some("5000 us   0  0 -1 -1 -1 -1  1  1"), "{output}");
}

#[test]
fn a_small_network_learns_in_sixty_steps() {
    let output = output_of("train_network");
    let losses = output.lines().filter_map(|line| line.split_once("steps: "));
    let losses: Vec<f64> = losses.map(|(_, loss)| loss.parse().unwrap()).collect();
    assert!(losses.len() == 4 && losses[3] < 0.7 * losses[0], "{output}");
}

#[test]
fn the_checkpoint_predicts_the_wrist_of_a_simulated_hand() {
    let output = output_of("run_checkpoint");
    assert!(output.contains("mean error of the wrist"), "{output}");
}

#[test]
fn a_sink_of_ones_own_takes_poses() {
    let output = output_of("live_sink");
    assert!(output.contains("late") && output.trim_end().ends_with("poses"), "{output}");
}

/// The lines of a code without indentation: a page shows parts of it.
fn flush_left(code: &str) -> String {
    code.lines().map(|line| line.trim_start().to_owned() + "\n").collect()
}

#[test]
fn code_of_the_contributors_page_is_of_the_examples() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let page = read(&root.join("CONTRIBUTING.md"));
    let folders =
        ["examples", "examples/plugin/src", "examples/task/src"].map(|folder| root.join(folder));
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let files = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
    let examples: Vec<String> = files.map(|path| flush_left(&read(&path))).collect();
    let blocks: Vec<&str> = page.split("```rust\n").skip(1).collect();
    // If a page loses a block, its example is no longer compared.
    assert_eq!(blocks.len(), 6);
    for block in blocks {
        let code = flush_left(block.split_once("```").unwrap().0);
        assert!(examples.iter().any(|example| example.contains(&code)), "of no example:\n{code}");
    }
    for name in ["custom_effect", "custom_representation", "custom_format", "custom_backbone"] {
        assert!(page.contains(&format!("(examples/{name}.rs)")), "{name} is not linked");
    }
}

#[test]
fn the_custom_backbone_learns_and_is_compiled() {
    let output = output_of("custom_backbone");
    let losses = output.lines().filter_map(|line| line.split_once("loss "));
    let losses: Vec<f64> = losses.map(|(_, loss)| loss.parse().unwrap()).collect();
    assert!(losses.len() == 4 && losses[3] < 0.1 * losses[0], "{output}");
    let (_, values) = output.split_once("Burn ").unwrap();
    let (burn, engine) = values.trim_end().split_once(", engine ").unwrap();
    let [burn, engine] = [burn, engine].map(|value| value.parse::<f64>().unwrap());
    assert!((burn - engine).abs() < 0.002, "{output}");
}

#[test]
fn the_custom_format_is_detected_decoded_and_reports_the_byte_of_a_fault() {
    let output = output_of("custom_format");
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(
        lines,
        [
            "event-stream: 2 events",
            "3 µs at (33, 6), On",
            "37 µs at (34, 6), Off",
            "two-events.es: byte 20: the file ends 2 bytes into a record (1 events readable before it)",
        ]
    );
}
