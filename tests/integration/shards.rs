//! Sequences recorded in parts, by processes that are killed, and onto disks that are full.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use evpose_io::EvcReader;

use crate::harness::{Sandbox, bytes, stderr, tiny};

/// The tiny simulation with more sequences, of `seconds` each.
fn simulate<'a>(out: &'a str, seconds: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let base = tiny(&["simulate", "quick", "--out", out, "--sequences", "6", "--seconds", seconds]);
    [&base[..], more].concat()
}

/// Every file of a directory by its name.
fn tree(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| (path.file_name().unwrap().to_str().unwrap().into(), bytes(&path))).collect()
}

/// Files of a directory that the undisturbed run does not have, or not with these bytes.
fn strays(present: &BTreeMap<String, Vec<u8>>, whole: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let stray = |(name, bytes): &(&String, &Vec<u8>)| whole.get(*name) != Some(*bytes);
    present.iter().filter(stray).map(|(name, _)| name.clone()).collect()
}

#[test]
fn shards_in_one_directory_are_the_whole_run_to_the_byte() {
    let sandbox = Sandbox::new();
    sandbox.ok(&simulate("whole", "0.4", &[]));
    let expected = tree(&sandbox.path("whole"));
    // Four files and their digests for each, the manifest, and what says where they come from.
    assert_eq!(expected.len(), 6 * 5 + 3);
    let said = sandbox.ok(&simulate("parts", "0.4", &["--shard", "2/3", "--threads", "1"]));
    assert!(said.contains("shard 2/3 is complete"), "{said}");
    // Together, as an array job starts them.
    let rest = ["1/3", "3/3"].map(|shard| {
        let mut command = sandbox.evpose(&simulate("parts", "0.4", &["--shard", shard]));
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    });
    let said = rest.map(|child| {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    });
    assert!(said.iter().any(|said| said.contains("all 6 sequences are there")), "{said:?}");
    let present = tree(&sandbox.path("parts"));
    assert!(present == expected, "{:?}", strays(&present, &expected));

    let info = sandbox.ok(&["info", "--verify", "parts"]);
    assert!(info.contains("6 of 6 complete") && info.contains("24 files"), "{info}");
    sandbox.write("parts/0004.meta", "changed");
    let message = sandbox.fails(&["info", "--verify", "parts"]);
    assert!(
        message.contains("files not as recorded: 1 (24 have") && message.contains("0004.meta"),
        "{message}"
    );
}

#[test]
fn a_directory_is_resumed_by_its_own_config_only() {
    let sandbox = Sandbox::new();
    let first = simulate("data", "0.4", &["--shard", "1/2"]);
    sandbox.ok(&first);
    let message = sandbox.fails(&first);
    assert!(
        message.contains("already holds sequences") && message.contains("--resume"),
        "{message}"
    );
    let before = tree(&sandbox.path("data"));
    for (change, named) in [
        (&["--seed", "5"][..], "seed is 1 there, not 5"),
        (&["--set", "simulation.motion.variant=bottom"], "simulation.motion.variant is \"code\""),
        (&["--sequences", "7"], "simulation.sequences is 6 there, not 7"),
    ] {
        for part in [&["--shard", "2/2"][..], &["--shard", "1/2", "--resume"], &["--resume"]] {
            let mut arguments = simulate("data", "0.4", part);
            if change[0] == "--sequences" {
                arguments.retain(|argument| !["--sequences", "6"].contains(argument));
            }
            let message = sandbox.fails(&[&arguments[..], change].concat());
            assert!(message.contains("data/config.toml") && message.contains(named), "{message}");
        }
    }
    let run = sandbox.path("data/run.toml");
    let text = std::fs::read_to_string(&run).unwrap();
    std::fs::write(&run, text.replace("version = \"", "version = \"9")).unwrap();
    let message = sandbox.fails(&simulate("data", "0.4", &["--resume"]));
    assert!(message.contains("run.toml") && message.contains("version"), "{message}");
    std::fs::write(&run, text).unwrap();
    assert!(tree(&sandbox.path("data")) == before, "a refusal changed something");
    // The rest of the same run is welcome.
    let said = sandbox.ok(&simulate("data", "0.4", &["--resume"]));
    assert!(said.contains("kept 3 complete sequences"), "{said}");

    // Sequences of unknown origin are not taken over.
    std::fs::create_dir(sandbox.path("foreign")).unwrap();
    sandbox.write("foreign/0000.evc", "whose?");
    let message = sandbox.fails(&simulate("foreign", "0.4", &["--resume"]));
    assert!(message.contains("no config.toml"), "{message}");
}

#[test]
fn a_killed_recording_leaves_nothing_half_and_resumes_to_the_byte() {
    let sandbox = Sandbox::new();
    sandbox.ok(&simulate("whole", "4", &[]));
    let expected = tree(&sandbox.path("whole"));
    let directory = sandbox.path("killed");
    let arguments = simulate("killed", "4", &["--resume", "--threads", "1"]);
    for kill in 0..4 {
        let started = std::time::SystemTime::now();
        let recording = || {
            let mut files = std::fs::read_dir(&directory).into_iter().flatten().flatten();
            // Newer than what the kill before has left.
            let is_new = |file: &std::fs::DirEntry| {
                file.metadata().and_then(|found| found.modified()).is_ok_and(|at| at > started)
            };
            files.any(|file| {
                let name = file.file_name().into_string().unwrap();
                name.contains(".evc.") && name.ends_with(".tmp") && is_new(&file)
            })
        };
        sandbox.kill(&arguments, recording, Duration::from_millis(11 * kill));
        // What has its name is whole; the rest has names that no reader opens.
        let found = tree(&directory);
        for stray in strays(&found, &expected) {
            assert!(stray.ends_with(".tmp"), "{stray} is not as it should be");
        }
        for name in found.keys().filter(|name| name.ends_with(".evc")) {
            EvcReader::open(directory.join(name)).unwrap();
        }
    }
    assert!(!directory.join("manifest.sha256").exists(), "the kills came too late");
    // Whether the last kill left a file without its digest, or nothing but temporary ones.
    let message = sandbox.fails(&["info", "--verify", "killed"]);
    let why = ["no manifest.sha256", "has no digest: unfinished"];
    assert!(why.iter().any(|why| message.contains(why)), "{message}");
    let leftovers = tree(&directory).keys().any(|name| name.ends_with(".tmp"));
    let said = sandbox.ok(&arguments);
    assert_eq!(said.contains("unfinished files of an interrupted run"), leftovers, "{said}");
    let found = tree(&directory);
    assert!(found == expected, "{:?}", strays(&found, &expected));
}

/// The largest file a process may write stands for the space that is left.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_the_file_and_leaves_nothing_half() {
    let sandbox = Sandbox::new();
    sandbox.ok(&simulate("whole", "2", &[]));
    let expected = tree(&sandbox.path("whole"));
    let sizes = ["0000.evc", "0000.meta"].map(|name| expected[name].len());
    let most = sizes.into_iter().max().unwrap();
    let directory = sandbox.path("full");
    // In the middle of either file, and with its last bytes.
    for bytes in [sizes[0] / 2, sizes[1] / 2, most - 1024] {
        // The shell counts blocks of 512 bytes. A process that ignores the signal gets an error.
        let script = format!("trap '' XFSZ; ulimit -f {}; exec \"$@\"", bytes / 512);
        let output = Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_evpose")])
            .args(simulate("full", "2", &["--resume", "--threads", "1"]))
            .current_dir(sandbox.path("."))
            .output()
            .unwrap();
        assert!(!output.status.success(), "{bytes} bytes were enough");
        let message = stderr(&output);
        assert!(message.contains("full/000") && message.contains("cannot"), "{message}");
        let found = tree(&directory);
        assert_eq!(strays(&found, &expected), Vec::<String>::new());
    }
    sandbox.ok(&simulate("full", "2", &["--resume"]));
    let found = tree(&directory);
    assert!(found == expected, "{:?}", strays(&found, &expected));
}
