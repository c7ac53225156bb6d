//! Poses online, from a recording and from a socket.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::Duration;

use crate::harness::{Sandbox, bytes, shipped};

/// Somebody who waves, before a small camera, and a network for it.
fn recorded() -> (Sandbox, String) {
    let sandbox = Sandbox::new();
    sandbox.run(
        "simulate finetune --held-out --out held --sequences 2 --seconds 1 --set \
         simulation.step_hz=250 --set simulation.label_hz=50",
        &[],
    );
    (sandbox, shipped("body-quick.bpk"))
}

fn lines(sandbox: &Sandbox, name: &str) -> Vec<serde_json::Value> {
    let text = sandbox.text(name);
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

#[test]
fn a_recording_becomes_poses_with_their_latency_and_a_report() {
    let (sandbox, network) = recorded();
    sandbox.run(
        "live --source held/0001.raw --json poses.jsonl --csv poses.csv \
         --report report.json",
        &["--checkpoint", &network],
    );
    let poses = lines(&sandbox, "poses.jsonl");
    let of = |origin: &str| poses.iter().filter(|pose| pose["origin"] == origin).count() as u64;
    let (by_network, propagated) = (of("network"), of("propagated"));
    assert!(by_network > 3, "{by_network}");
    // A second at 500 Hz, but for what was before the network's first answer.
    assert!((100..=501).contains(&propagated), "{propagated}");
    assert!(poses.iter().all(|pose| pose["latency_ms"].as_f64().is_some_and(|ms| ms >= 0.0)));
    let found =
        poses.iter().find(|pose| pose["origin"] == "network" && pose["score"].as_f64() > Some(0.3));
    let found = found.expect("somebody is there");
    for name in ["u_px", "v_px", "score"] {
        assert!(found["joints"]["shoulder_l"][name].is_number(), "{name}: {found}");
    }
    let report = sandbox.json("report.json");
    assert_eq!(report["network"]["poses"], by_network);
    assert_eq!(report["propagated"]["poses"], propagated);
    let table = sandbox.text("poses.csv");
    assert_eq!(table.lines().count() as u64, 1 + by_network + propagated);
    assert!(table.lines().all(|line| line.split(',').count() == 4 + 3 * 13));
    // Both have the same poses under the same names.
    let [mut table, mut json] = ["poses.csv", "poses.jsonl"]
        .map(|name| evpose_io::poses::read_poses(&sandbox.path(name)).expect("as written").poses);
    assert_eq!(table.len(), json.len());
    for pose in table.iter_mut().chain(&mut json).flat_map(|pose| &mut pose.joints) {
        // JSON leaves out joints without a position.
        pose.score = pose.score.filter(|_| pose.image_px.is_some());
    }
    assert_eq!(table, json);
}

#[test]
fn batches_of_bodies_have_the_poses_of_single_images() {
    let (sandbox, network) = recorded();
    let [single, batched] = ["1", "4"].map(|batch| {
        let live = ["live", "--source", "held/0001.raw", "--speed", "max", "--stride-ms", "20"];
        let to = ["--checkpoint", &network, "--batch", batch, "--json", "poses.jsonl"];
        sandbox.ok(&[&live[..], &to].concat());
        let by_network = lines(&sandbox, "poses.jsonl").into_iter();
        let by_network = by_network.filter(|pose| pose["origin"] == "network");
        by_network.map(|pose| [pose["t_us"].clone(), pose["joints"].clone()]).collect::<Vec<_>>()
    });
    assert!(batched.len() >= 8 && batched.len() % 4 == 0, "{}", batched.len());
    // The last images do not fill a batch.
    assert_eq!(batched[..], single[..batched.len()]);
    assert!(single.len() - batched.len() < 4);
}

#[test]
fn events_come_over_a_socket_and_poses_leave_over_another() {
    let (sandbox, network) = recorded();
    sandbox.ok(&["convert", "held/0000.raw", "held/0000.evs"]);
    let events = bytes(&sandbox.path("held/0000.evs"));
    let (camera, robot) = (listener(), listener());
    let address =
        |listener: &TcpListener| format!("tcp://{}", listener.local_addr().expect("bound"));
    let (source, sink) = (address(&camera), address(&robot));
    let mut program =
        sandbox.start(&["live", "--source", &source, "--checkpoint", &network, "--json", &sink]);
    let sent = std::thread::spawn(move || {
        let (mut socket, _) = camera.accept().expect("the program connects");
        // In pieces that have nothing to do with packets.
        for piece in events.chunks(100_001) {
            socket.write_all(piece).expect("the program reads");
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    let (mut socket, _) = robot.accept().expect("the program connects");
    let mut output = String::new();
    socket.read_to_string(&mut output).expect("text, until it ends");
    sent.join().expect("all is sent");
    assert!(program.wait().expect("it ends").success());
    let origins: Vec<bool> = output
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("a line of JSON"))
        .map(|pose| pose["origin"] == "network")
        .collect();
    assert!(origins.contains(&true) && origins.contains(&false), "{} poses", origins.len());
}

fn listener() -> TcpListener {
    TcpListener::bind("127.0.0.1:0").expect("a free port")
}

#[test]
fn every_loop_has_the_poses_of_the_first_and_no_event_is_lost() {
    let (sandbox, network) = recorded();
    let live = ["live", "--checkpoint", &network, "--stride-ms", "40", "--propagate-hz", "50"];
    let output = ["--json", "poses.jsonl", "--report", "report.json"];
    let report = || -> serde_json::Value { sandbox.json("report.json") };
    let loops = ["--source", "held/0001.raw", "--speed", "max", "--times", "3"];
    sandbox.ok(&[&live[..], &loops, &output].concat());
    let looped = report();
    // Nothing may be lost, however fast it goes.
    for count in ["dropped_events", "dropped_poses", "skipped_strides"] {
        assert_eq!(looped[count], 0, "{count}");
    }
    assert_eq!(looped["events"], looped["followed"]);
    let poses = lines(&sandbox, "poses.jsonl");
    let joints = |origin: &str| -> Vec<&serde_json::Value> {
        poses.iter().filter(|p| p["origin"] == origin).map(|p| &p["joints"]).collect()
    };
    for origin in ["network", "propagated"] {
        let joints = joints(origin);
        // Thirds: each loop has the poses of the first.
        let (first, others) = joints.split_at(joints.len() / 3);
        assert!(first.len() > 20, "{origin}: {}", first.len());
        assert!(others.chunks(first.len()).all(|part| part == first), "{origin}");
    }

    // Through a pipe the same events come only once.
    sandbox.ok(&["convert", "held/0001.raw", "rec.evs"]);
    let input = std::fs::File::open(sandbox.path("rec.evs")).expect("just written");
    let mut piped = sandbox.evpose(&[&live[..], &["--source", "-"], &output].concat());
    assert!(piped.stdin(input).status().expect("it runs").success());
    let piped = report();
    assert_eq!(piped["followed"].as_u64().map(|n| 3 * n), looped["events"].as_u64());
    assert_eq!(piped["dropped_events"], 0);
    assert_eq!(
        piped["network"]["poses"].as_u64().map(|n| 3 * n),
        looped["network"]["poses"].as_u64()
    );
}

#[test]
fn what_cannot_be_followed_is_said_before_anything_begins() {
    let (sandbox, network) = recorded();
    let error = sandbox.fails(&["live", "--source", "nothing.raw", "--checkpoint", &network]);
    assert!(error.contains("nothing.raw"), "{error}");
    let hands = ["--task", "hand", "--checkpoint", &network];
    let error = sandbox.fails(&[&["live", "--source", "held/0000.raw"], &hands[..]].concat());
    assert!(error.contains("`body`, not `hand`"), "{error}");
    let hand = shipped("hand-quick.bpk");
    let live = ["live", "--source", "held/0000.raw", "--checkpoint", &hand];
    let error = sandbox.fails(&[&live[..], &["--camera", "camera.yaml"]].concat());
    assert!(error.contains("camera.yaml"), "{error}");
}

#[test]
fn a_benchmark_of_it_says_how_much_came_through() {
    let (sandbox, network) = recorded();
    let output = sandbox.run(
        "bench live --source held/0001.raw --speeds 1,4 --input 2 \
         --seconds 0.5 --json live.json",
        &["--checkpoint", &network],
    );
    assert!(output.contains("input alone") && output.contains("whole pipeline, 4x"), "{output}");
    let measured = sandbox.json("live.json");
    let rows = measured["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    assert!(rows[1]["report"]["network"]["poses"].as_u64().is_some_and(|poses| poses > 0));
    sandbox.run("bench live --source held/0001.raw --soak 3e6", &["--checkpoint", &network]);
}

#[cfg(not(feature = "rerun"))]
#[test]
fn a_build_without_rerun_says_so_before_anything_begins() {
    let (sandbox, network) = recorded();
    let live = ["live", "--source", "held/0001.raw", "--checkpoint", &network];
    let error = sandbox.fails(&[&live[..], &["--rerun=live.rrd"]].concat());
    assert!(error.contains("--features rerun") && error.contains("--serve"), "{error}");
}

#[cfg(feature = "rerun")]
#[test]
fn poses_go_to_a_file_of_rerun_or_it_says_that_no_viewer_answers() {
    let (sandbox, network) = recorded();
    let live = ["live", "--source", "held/0001.raw", "--checkpoint", &network];
    sandbox.ok(&[&live[..], &["--rerun=live.rrd"]].concat());
    // Events of a second, 30 times.
    assert!(bytes(&sandbox.path("live.rrd")).len() > 10_000);
    let error = sandbox.fails(&[&live[..], &["--rerun=127.0.0.1:1"]].concat());
    assert!(error.contains("the Rerun viewer at rerun+http://127.0.0.1:1/proxy"), "{error}");
}
