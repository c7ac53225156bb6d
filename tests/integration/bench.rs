//! Benchmarks beside the programs of others, on work that is small.

use crate::harness::{Sandbox, bytes};

fn json(sandbox: &Sandbox, name: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(&sandbox.path(name))).unwrap()
}

/// A peer that finds the file it is to read, and says what it took.
#[cfg(unix)]
#[test]
fn readers_are_timed_beside_a_peer_that_finds_their_files() {
    let sandbox = Sandbox::new();
    std::fs::write(
        sandbox.path("peer.sh"),
        "test -s $EVPOSE_BENCH/edges.dat && echo 'edges.dat: 0.5' && echo 'mine.dat: 1'\n",
    )
    .unwrap();
    let small = ["bench", "io", "--events", "3000", "--passes", "2", "--only", "DAT"];
    let with = ["--only", "edges", "--peer", "other=sh peer.sh", "--json", "io.json"];
    let said = sandbox.ok(&[small.as_slice(), &with].concat());
    assert!(said.contains("other: no case is called `mine.dat`"), "{said}");
    let cases = json(&sandbox, "io.json")["cases"].clone();
    let named = |name: &str| {
        let cases = cases.as_array().unwrap();
        cases.iter().find(|case| case["case"] == name).unwrap().clone()
    };
    let dat = named("edges.dat");
    assert_eq!(
        (&dat["peers"][0]["name"], &dat["peers"][0]["value"]),
        (&"other".into(), &0.5.into())
    );
    assert_eq!(dat["peers"][0]["ratio"].as_f64(), dat["value"].as_f64().map(|value| value / 0.5));
    assert_eq!(named("edges.aedat4-lz4")["passes"], 2);
    let failing = ["--peer", "other=exit 3"];
    let message = sandbox.fails(&[small.as_slice(), &failing].concat());
    assert!(message.contains("the peer other failed"), "{message}");
}

#[test]
fn representations_are_timed_by_their_names() {
    let sandbox = Sandbox::new();
    let small = ["bench", "repr", "--events", "3000", "--passes", "1"];
    let with = ["--only", "lnes", "--only", "240x180", "--json", "repr.json"];
    sandbox.ok(&[small.as_slice(), &with].concat());
    let report = json(&sandbox, "repr.json");
    let names: Vec<&str> = report["cases"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|case| case["case"].as_str())
        .collect();
    let want =
        ["lnes update 240x180 wandering", "lnes update 240x180 uniform", "lnes image 240x180"];
    assert_eq!(names, want);
    let message = sandbox.fails(&[small.as_slice(), &["--only", "lness"]].concat());
    assert!(message.contains("no case has `lness` in its name") && message.contains("lnes image"));
}
