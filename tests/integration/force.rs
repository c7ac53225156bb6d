//! Outputs that are inputs, pipes, full disks, signals.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::harness::{Sandbox, bytes, shipped, stderr, tiny};

/// A recording of a second: a dot that runs along the rows.
fn recorded() -> Sandbox {
    let sandbox = Sandbox::new();
    let mut text = "96 72\n".to_owned();
    for k in 0..2_000 {
        text += &format!("{} {} {} {}\n", 500 * k, k / 7 % 96, k / 11 % 72, k % 2);
    }
    sandbox.write("in.txt", text);
    sandbox.ok(&["convert", "in.txt", "in.evs"]);
    sandbox
}

#[test]
fn an_output_that_is_an_input_is_refused_and_nothing_is_lost() {
    let sandbox = recorded();
    let before = bytes(&sandbox.path("in.evs"));
    std::fs::hard_link(sandbox.path("in.evs"), sandbox.path("other.evs")).unwrap();
    let network = shipped("body-quick.bpk");
    let live = ["live", "--source", "in.evs", "--checkpoint", &network];
    let infer = ["infer", "--events", "in.evs", "--checkpoint", &network];
    let refused: [(&[&str], &[&str], [&str; 2]); 6] = [
        (&live, &["--json", "./in.evs"], ["--json", "--source"]),
        (&live, &["--report", "other.evs"], ["--report", "--source"]),
        (&live, &["--json", "new", "--csv", "new"], ["--json", "--csv"]),
        (&infer, &["--out", "other.evs"], ["--out", "--events"]),
        (&["convert", "in.evs", "other.evs"], &[], ["OUT", "INPUT"]),
        (&["view", "in.evs"], &["--out", "in.evs"], ["--out", "INPUT"]),
    ];
    for (line, more, flags) in refused {
        let (code, said) = sandbox.ends(&[line, more].concat());
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("are one file"), "{said}");
        assert!(flags.iter().all(|flag| said.contains(flag)), "{said}");
        assert!(bytes(&sandbox.path("in.evs")) == before);
    }
    assert!(!sandbox.path("new").exists());
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_pipes_are_written_through() {
    let sandbox = recorded();
    let at = |name: &str| sandbox.path(name);
    sandbox.ok(&["convert", "in.txt", "plain.csv"]);
    let made = Command::new("mkfifo").arg(at("pipe.csv")).status().unwrap();
    assert!(made.success());
    std::os::unix::fs::symlink("real.csv", at("link.csv")).unwrap();
    let mut writes = sandbox.start(&["convert", "in.txt", "pipe.csv"]);
    assert!(bytes(&at("pipe.csv")) == bytes(&at("plain.csv")));
    assert!(writes.wait().unwrap().success());
    sandbox.ok(&["convert", "in.txt", "link.csv"]);
    assert!(std::fs::symlink_metadata(at("link.csv")).unwrap().is_symlink());
    assert!(bytes(&at("real.csv")) == bytes(&at("plain.csv")));
    let piped = sandbox.ok(&["convert", "in.txt", "/dev/stdout", "--format", "csv"]);
    assert!(piped.as_bytes().starts_with(&bytes(&at("plain.csv"))), "and a line about it");
    std::fs::create_dir(at("folder.csv")).unwrap();
    let message = sandbox.fails(&["convert", "in.txt", "folder.csv"]);
    assert!(message.contains("folder.csv") && message.contains("directory"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_said() {
    let sandbox = recorded();
    for line in
        [&["info", "in.evs"][..], &["--help"], &["completions", "bash"], &["sensor", "list"]]
    {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = sandbox.evpose(line).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{line:?}");
        let said = stderr(&output);
        assert!(said.contains("No space left on device"), "{line:?}: {said}");
    }
}

/// Times of the poses in a file of lines, in microseconds.
fn times(sandbox: &Sandbox, name: &str) -> Vec<i64> {
    let text = sandbox.text(name);
    let of = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap()["t_us"].as_i64();
    text.lines().map(|line| of(line).unwrap()).collect()
}

#[test]
fn the_clock_of_a_replay_ends_with_the_recording_and_seconds_are_its_own() {
    let sandbox = recorded();
    let network = shipped("body-quick.bpk");
    let live = ["live", "--source", "in.evs", "--checkpoint", &network, "--json", "p.jsonl"];
    let live = [&live[..], &["--stride-ms", "50"]].concat();
    for speed in ["100", "1000", "max"] {
        sandbox.ok(&[&live[..], &["--speed", speed]].concat());
        let times = times(&sandbox, "p.jsonl");
        assert!(times.iter().all(|t| *t < 1_000_000), "{speed}: {:?}", times.iter().max());
        assert!(times.len() <= 1_500, "{speed}: {}", times.len());
    }
    sandbox
        .ok(&[&live[..], &["--speed", "max", "--seconds", "0.25", "--report", "r.json"]].concat());
    let report = sandbox.json("r.json");
    // One event in 500 us.
    assert_eq!(report["events"], 500);
    assert!(times(&sandbox, "p.jsonl").iter().all(|t| *t < 250_000));
}

/// Waits until a live run says how far it is, as it does every second: then all is running. Its standard error is read
/// to the end.
#[cfg(unix)]
fn running(child: &mut Child) -> std::thread::JoinHandle<usize> {
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.by_ref().any(|line| line.unwrap().contains("M events/s")));
    std::thread::spawn(move || lines.map_while(Result::ok).count())
}

#[cfg(unix)]
fn kill(child: &Child, signal: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
}

#[cfg(target_os = "linux")]
#[test]
fn a_hangup_that_was_ignored_when_it_began_does_not_end_a_live_run() {
    let sandbox = recorded();
    let network = shipped("body-quick.bpk");
    // As `nohup` starts it.
    let mut child = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_evpose")])
        .args(["live", "--source", "in.evs", "--times", "100000", "--checkpoint", &network])
        .args(["--report", "r.json"])
        .current_dir(sandbox.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let rest = running(&mut child);
    kill(&child, "-HUP");
    std::thread::sleep(Duration::from_secs(2));
    assert!(child.try_wait().unwrap().is_none());
    kill(&child, "-TERM");
    assert!(child.wait().unwrap().success());
    rest.join().unwrap();
    assert!(sandbox.path("r.json").is_file());
}

#[cfg(unix)]
#[test]
fn signals_end_a_live_run_with_its_report_and_its_poses() {
    let sandbox = recorded();
    // Where these tests were started by `nohup`, so was the program.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let is_hup_ignored =
        ignored.is_some_and(|mask| mask.trim().ends_with(['1', '3', '5', '7', '9', 'b', 'd', 'f']));
    let signals: &[&str] =
        if is_hup_ignored { &["-INT", "-TERM"] } else { &["-INT", "-TERM", "-HUP"] };
    for &signal in signals {
        let (poses, report) = (format!("p{signal}.jsonl"), format!("r{signal}.json"));
        let network = shipped("body-quick.bpk");
        let live = ["live", "--source", "in.evs", "--times", "100000", "--checkpoint", &network];
        let outputs = ["--json", &poses, "--report", &report];
        let mut child = sandbox
            .evpose(&[&live[..], &outputs].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let rest = running(&mut child);
        kill(&child, signal);
        let began = Instant::now();
        let status = child.wait().unwrap();
        assert!(status.success(), "{signal}: {status}");
        assert!(began.elapsed() < Duration::from_secs(20), "{signal}");
        rest.join().unwrap();
        let report = sandbox.json(&report);
        let written = report["network"]["poses"].as_u64().unwrap();
        let written = written + report["propagated"]["poses"].as_u64().unwrap();
        assert!(written > 0);
        assert_eq!(times(&sandbox, &poses).len() as u64, written, "{signal}");
    }
}

/// Runs a training on the dashboard of a terminal, presses keys once it trains, and returns its exit code and what
/// it said.
#[cfg(target_os = "linux")]
fn on_a_terminal(sandbox: &Sandbox, keys: &[&[u8]]) -> (i32, String) {
    let mut train = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    // The last word counts: long enough that keys come before its end.
    train.extend(["--set", "training.steps=100000"]);
    let program = env!("CARGO_BIN_EXE_evpose");
    // Without a size nothing would be drawn.
    let line = format!("stty rows 40 cols 120; exec '{program}' {}", train.join(" "));
    let mut child = Command::new("script")
        .args(["-qefc", &line, "/dev/null"])
        .current_dir(sandbox.path(""))
        .env("TERM", "xterm")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = child.stdout.take().unwrap();
    let (drawn, is_drawn) = std::sync::mpsc::channel();
    let reader = std::thread::spawn(move || {
        let (mut all, mut chunk) = (Vec::new(), [0; 4096]);
        while let Ok(count @ 1..) = output.read(&mut chunk) {
            all.extend_from_slice(&chunk[..count]);
            let _ = drawn.send(());
        }
        String::from_utf8_lossy(&all).into_owned()
    });
    let _ = is_drawn.recv_timeout(Duration::from_secs(60));
    // The first intervals are over, so that there is a checkpoint to go on from.
    let began = Instant::now();
    let metrics = sandbox.path("run/metrics.jsonl");
    while !metrics.exists() && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    let mut input = child.stdin.take().unwrap();
    for key in keys {
        std::thread::sleep(Duration::from_millis(500));
        input.write_all(key).unwrap();
        input.flush().unwrap();
    }
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if began.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it goes on after {keys:?}");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    drop(input);
    (status.code().unwrap_or(-1), reader.join().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn keys_and_signals_end_a_training_on_the_dashboard_and_it_says_so() {
    let sandbox = Sandbox::with_hands();
    for (keys, reason) in [
        (&[b"\x03".as_slice()][..], "interrupted"),
        (&[b"q", b"s"], "stopped"),
        (&[b"q", b"k"], "stopped at once"),
    ] {
        let (code, said) = on_a_terminal(&sandbox, keys);
        let end = &said[said.floor_char_boundary(said.len().saturating_sub(1_500))..];
        assert_eq!(code, 1, "{keys:?}: {end}");
        assert!(said.contains(&format!("{reason}; continue with --resume")), "{keys:?}: {end}");
        assert!(!said.contains("panicked"), "{keys:?}: {end}");
        std::fs::remove_dir_all(sandbox.path("run")).unwrap();
    }
}
