//! A network on slow hands and in little light.

use crate::harness::{Sandbox, bytes, tiny};

/// A network that has seen 12 batches: it need not be good.
fn trained() -> Sandbox {
    let sandbox = Sandbox::with_hands();
    sandbox.ok(&tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]));
    sandbox
}

#[test]
fn a_checkpoint_is_evaluated_under_conditions_of_the_program_and_of_the_user() {
    let sandbox = trained();
    sandbox.write("dusk.toml", "# A tenth of the light.\n[simulation]\nlight_level = 0.1\n[slow_motion]\nbatch_inputs = 4\n",
    );
    let few = ["--sequences", "2", "--seconds", "0.4", "--stride-ms", "10"];
    let eval = ["eval", "--checkpoint", "run", "--conditions", "slow,dark,dusk.toml"];
    let said =
        sandbox.ok(&[&eval[..], &few, &["--out", "evaluated", "--json", "also.json"]].concat());
    assert!(said.contains("A tenth of the light.") && said.contains("inputs/s"), "{said}");

    let json = bytes(&sandbox.path("evaluated/conditions.json"));
    assert!(json == bytes(&sandbox.path("also.json")));
    let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
    for condition in ["slow", "dark", "dusk"] {
        let evaluated = &report["conditions"][condition];
        let methods = ["mean_pose", "trained", "trained_kalman", "slow_motion", "slow_motion_live"];
        for method in methods {
            let row = said.lines().find(|l| l.starts_with(condition) && l.contains(method));
            assert!(row.is_some(), "{condition} {method} is missing in\n{said}");
            for number in ["translation_mm", "rotation_deg", "mpjpe_mm", "auc_3d", "auc_2d"] {
                let interval = &evaluated["methods"][method][number];
                let part = |name: &str| interval[name].as_f64().unwrap_or(f64::NAN);
                let (low, estimate, high) = (part("low"), part("estimate"), part("high"));
                assert!(low <= estimate && estimate <= high, "{method}.{number}: {interval}");
            }
        }
        assert!(evaluated["usage"]["inputs"].as_u64().is_some());
        let png = bytes(&sandbox.path(&format!("evaluated/{condition}.png")));
        assert!(png.starts_with(b"\x89PNG"));
        assert!(sandbox.path(&format!("evaluated/{condition}/0001.evc")).exists());
    }
    let again = sandbox.fails(&[&eval[..], &few, &["--out", "evaluated"]].concat());
    assert!(again.contains("not empty"), "{again}");
    // The same metrics without any directory.
    let quiet = sandbox.ok(&[&eval[..], &few].concat());
    let table = |said: &str| {
        let lines = said.lines().skip_while(|line| !line.starts_with("condition"));
        lines.take_while(|line| !line.starts_with("written")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(table(&said), table(&quiet));
}

#[test]
fn a_recording_is_inferred_in_slow_motion() {
    let sandbox = trained();
    let record = ["simulate", "quick", "--condition", "slow", "--out", "slow"];
    sandbox.ok(&tiny(&record));
    let infer = ["infer", "--checkpoint", "run", "--events", "slow/0000.evc", "--out", "poses.csv"];
    let said = sandbox.ok(&[&infer[..], &["--mode", "slow-motion"]].concat());
    assert!(said.contains("slow motion"), "{said}");
    let poses = sandbox.text("poses.csv");
    let times: Vec<i64> = poses
        .lines()
        // The header has no time.
        .skip(1)
        .map(|line| line.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(
        !times.is_empty() && times.windows(2).all(|pair| pair[1] - pair[0] >= 1000),
        "{times:?}"
    );
    let wrong = sandbox.fails(&[&infer[..], &["--mode", "fast"]].concat());
    assert!(wrong.contains("slow-motion"), "{wrong}");
}

#[test]
fn a_condition_that_is_none_lists_those_there_are() {
    let sandbox = Sandbox::new();
    let message =
        sandbox.fails(&tiny(&["simulate", "quick", "--condition", "foggy", "--out", "x"]));
    for name in ["foggy", "slow", "dark-noisy"] {
        assert!(message.contains(name), "{message}");
    }
    assert!(!sandbox.path("x").exists());
}
