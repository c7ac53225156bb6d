//! Benchmarks beside the programs of others, on work that is small.

use crate::harness::{Sandbox, stderr};

/// A peer that finds the file it is to read, and says what it took.
#[cfg(unix)]
#[test]
fn readers_are_timed_beside_a_peer_that_finds_their_files() {
    let sandbox = Sandbox::new();
    // A peer that fails if it cannot find the file: its answer shows that it could.
    sandbox.write(
        "peer.sh",
        "test -s $EVPOSE_BENCH/edges.dat && echo 'edges.dat: 0.5' && echo 'mine.dat: 1'\n",
    );
    let small = ["bench", "io", "--events", "3000", "--passes", "2", "--only", "DAT"];
    let with = ["--only", "edges", "--peer", "other=sh peer.sh", "--json", "io.json"];
    let said = sandbox.ok(&[small.as_slice(), &with].concat());
    // A case that only the peer has is skipped with a warning.
    assert!(said.contains("other: there is no case `mine.dat`"), "{said}");
    let cases = sandbox.json("io.json")["cases"].clone();
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
    let report = sandbox.json("repr.json");
    let names: Vec<&str> = report["cases"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|case| case["case"].as_str())
        .collect();
    let want =
        ["lnes update 240x180 wandering", "lnes update 240x180 uniform", "lnes image 240x180"];
    assert_eq!(names, want);
    // A misspelt name must not time nothing.
    let message = sandbox.fails(&[small.as_slice(), &["--only", "lness"]].concat());
    assert!(message.contains("no case has `lness` in its name") && message.contains("lnes image"));
}

#[test]
fn all_benchmarks_make_a_page_and_figures_that_a_later_run_is_compared_with() {
    let sandbox = Sandbox::new();
    let sensor = ["bench", "all", "--quick", "--only", "sensor", "--html", "bench.html"];
    sandbox.ok(&[sensor.as_slice(), &["--json", "before.json"]].concat());
    let mut before = sandbox.json("before.json");
    let figures = before["figures"].as_array().unwrap();
    let works = figures.iter().map(|figure| figure["work"].as_str().unwrap());
    // Machines of several cores have further ones.
    let works: Vec<_> = works.filter(|work| !work.ends_with("threads")).collect();
    assert_eq!(works, ["thresholds", "all"]);
    assert!(before["limits"][0]["peak_gflop_per_s"].as_f64().unwrap() > 0.0);
    let page = sandbox.text("bench.html");
    assert!(page.contains("Limits of the machine") && page.contains("ns/pixel/step"));

    // A machine that was a hundred times as fast.
    let slower = before["figures"][1]["value"].as_f64().unwrap() / 100.0;
    before["figures"][1]["value"] = slower.into();
    sandbox.write("before.json", before.to_string());
    let said = sandbox.ok(&[sensor.as_slice(), &["--before", "before.json"]].concat());
    assert!(said.contains("slower"), "{said}");
    sandbox.write("before.json", "{}");
    let message = sandbox.fails(&[sensor.as_slice(), &["--before", "before.json"]].concat());
    assert!(message.contains("before.json: not the figures"), "{message}");
}

const SMALL: &str = "task = \"hand\"\n[simulation]\nimage_scale = 0.3\n[network]\nwidth = 0.0625\n";

#[test]
fn every_network_is_timed_on_every_number_of_threads() {
    let sandbox = Sandbox::new();
    sandbox.write("small.toml", SMALL);
    let small = ["bench", "infer", "--config", "small.toml", "--runs", "3"];
    let with = ["--network", "all", "--threads", "1,2", "--layers", "--json", "infer.json"];
    let output = sandbox.evpose(&[small.as_slice(), &with].concat()).output().unwrap();
    let noted = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{noted}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("GFLOP/s") && said.contains("winograd"), "{said}");
    let report = sandbox.json("infer.json");
    let peaks = report["peaks"].as_array().unwrap();
    assert_eq!(peaks.iter().map(|peak| &peak["threads"]).collect::<Vec<_>>(), [1, 2]);
    let cases = report["cases"].as_array().unwrap();
    let setting = |case: &serde_json::Value| {
        (case["network"].as_str().unwrap().to_owned(), case["threads"].as_u64().unwrap())
    };
    let settings: Vec<_> = cases.iter().map(setting).collect();
    let mut want = Vec::new();
    // Inception v3 needs larger images, which a note says.
    assert!(noted.contains("note: inception_v3 needs 75 pixels"), "{noted}");
    for name in evpose_nn::Network::names().filter(|name| *name != "inception_v3") {
        want.extend([1, 2].map(|threads| (name.to_owned(), threads)));
    }
    assert_eq!(settings, want);
    for case in cases {
        let ms = |name: &str| case[name].as_f64().unwrap();
        assert!(0.0 < ms("min_ms") && ms("min_ms") <= ms("p50_ms") && ms("p50_ms") <= ms("p99_ms"));
        // By the figures themselves: MACs of all layers in the median time.
        let layers = case["layers"].as_array().unwrap();
        let macs_m: f64 = layers.iter().map(|l| l["macs_m"].as_f64().unwrap()).sum();
        let gflop_per_s = 2.0 * macs_m / 1e3 / (ms("p50_ms") / 1e3);
        assert!((ms("gflop_per_s") / gflop_per_s - 1.0).abs() < 1e-9, "{case}");
    }
}

#[test]
fn what_cannot_be_measured_says_what_to_do() {
    let sandbox = Sandbox::new();
    sandbox.write("small.toml", SMALL);
    let fails = |with: &[&str]| {
        let small = ["bench", "infer", "--config", "small.toml", "--runs", "1"];
        sandbox.fails(&[small.as_slice(), with].concat())
    };
    assert!(fails(&["--network", "vgg"]).contains("no network is called `vgg`"));
    assert!(fails(&["--level", "sse9"]).contains("this processor has"));
    assert!(fails(&["--threads", "0"]).contains("'0' for '--threads"));
    assert!(fails(&["--burn", "--threads", "1,2"]).contains("several thread counts"));
    assert!(fails(&["--against", "tract", "--batch", "2"]).contains("leave --batch out"));
    assert!(fails(&["--against", "tract", "--pairs", "5"]).contains("from 20 to 1000000"));
    let mut peer = sandbox.evpose(&["bench", "infer", "--config", "small.toml"]);
    peer.args(["--runs", "1", "--against", "onnxruntime"]);
    // Where the library is there, nothing is missing.
    let missing = stderr(&peer.env_remove("ORT_DYLIB_PATH").output().unwrap());
    if cfg!(feature = "peers") {
        assert!(missing.contains("$ORT_DYLIB_PATH"), "{missing}");
    } else {
        assert!(missing.contains("--features peers"), "{missing}");
    }
}

/// The only other runtime that needs no library of the user's.
#[cfg(feature = "peers")]
#[test]
fn another_runtime_is_timed_interleaved_with_ours() {
    let sandbox = Sandbox::new();
    sandbox.write("small.toml", SMALL);
    let small = ["bench", "infer", "--config", "small.toml", "--runs", "3", "--threads", "1"];
    let with = ["--against", "tract", "--pairs", "20", "--json", "infer.json"];
    let said = sandbox.ok(&[small.as_slice(), &with].concat());
    assert!(said.contains("against tract") && said.contains("times ours ["), "{said}");
    let tract = sandbox.json("infer.json")["cases"][0]["against"][0].clone();
    assert_eq!((&tract["pairs"], &tract["peer"]), (&20.into(), &"tract".into()));
    let ratio = &tract["ratio"];
    let [low, estimate, high] =
        ["low", "estimate", "high"].map(|name| ratio[name].as_f64().unwrap());
    assert!(0.0 < low && low <= estimate && estimate <= high, "{ratio}");
    // Close, so that both ran the same network.
    assert!(tract["difference"].as_f64().unwrap() < 1e-4, "{tract}");
}
