//! The programs of `examples/` run without arguments. `cargo test` builds them beside the tests.

use std::path::Path;
use std::process::Command;

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
fn code_of_the_contributors_page_is_that_of_the_files_it_links() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let page = read(&root.join("CONTRIBUTING.md"));
    let folders = ["examples/plugin/src", "examples/task/src", "crates/io/src/es"];
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap());
    let examples: Vec<String> =
        entries.map(|entry| flush_left(&read(&entry.unwrap().path()))).collect();
    let blocks: Vec<&str> = page.split("```rust\n").skip(1).collect();
    // If a page loses a block, its example is no longer compared.
    assert_eq!(blocks.len(), 6);
    for block in blocks {
        let code = flush_left(block.split_once("```").unwrap().0);
        assert!(examples.iter().any(|example| example.contains(&code)), "of no example:\n{code}");
    }
}
