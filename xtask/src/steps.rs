//! Steps of `cargo xtask ci` and `cargo xtask slow`.

use crate::needs::Need;

/// A call of cargo, with its reason.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) why: &'static str,
    /// Arguments, with spaces between them.
    pub(crate) cargo: &'static str,
    pub(crate) env: &'static [(&'static str, &'static str)],
    /// A tool or unit that not every machine has.
    pub(crate) need: Option<Need>,
}

const fn step(why: &'static str, cargo: &'static str) -> Step {
    Step { why, cargo, env: &[], need: None }
}

/// A call for the crates that have optional features, with all of these on: steps of one selection
/// share what they build.
macro_rules! with_features {
    ($command:literal, $rest:literal) => {
        concat!(
            $command,
            " --package=evpose --package=evpose-bench --package=evpose-body --package=evpose-cli",
            " --package=evpose-live --package=evpose-nn --package=evpose-studies --package=evpose-io",
            " --features=onnx,rerun,peers,ndarray,wgpu,live,gltf,zstd,parquet ",
            $rest
        )
    };
}

/// A call for the whole workspace with all optional features.
macro_rules! with_all_features {
    ($command:literal, $rest:literal) => {
        concat!(
            $command,
            " --workspace --features=onnx,rerun,peers,ndarray,wgpu,live,gltf,zstd,parquet ",
            $rest
        )
    };
}

impl Step {
    const fn with_env(self, env: &'static [(&'static str, &'static str)]) -> Self {
        Self { env, ..self }
    }

    const fn with_need(self, need: Need) -> Self {
        Self { need: Some(need), ..self }
    }

    /// Whether it runs tests that are ignored elsewhere.
    pub(crate) fn runs_ignored(&self) -> bool {
        self.cargo.split(" ").any(|word| word == "--ignored")
    }
}

/// Checks that every change must pass.
pub(crate) const CI: &[Step] = &[
    step("one style", "fmt --all --check"),
    step("files of a crate import each other in small circles only", "xtask circles"),
    step("names and prose in the words of the glossary", "xtask words"),
    step("figures of pages are those that are stored", "xtask figures --check"),
    step("links of pages lead somewhere", "xtask links"),
    step("the command line stays small", "xtask lines"),
    // With the features of the tests. What is optional is linted nightly, and by the CI of pull requests: to check
    // its dependencies takes as long as all else here. The documentation shares what is checked.
    step(
        "lints, tests included",
        "clippy --workspace --all-targets --features=gltf --quiet -- -D warnings",
    ),
    step(
        "documentation complete, its links alive",
        "doc --workspace --features=gltf --no-deps --quiet",
    )
    .with_env(&[("RUSTDOCFLAGS", "-D warnings")]),
    step("tests, with hands of glTF files", "test --workspace --features=gltf --no-fail-fast"),
    // With the features of the step above: nothing is compiled.
    step(
        "tiles of AMX",
        "test --workspace --features=gltf --lib tiles_of_the_processor -- --ignored",
    )
    .with_need(Need::Amx),
    // Its recordings evaluate the gap workflow: a shared formula would be compared with itself.
    step(
        "the benchmark's pixel shares no code with the simulator",
        "tree --package=gapbench-pixel --edges=all --prefix=none --quiet",
    ),
    // Without a network, so with the advisories of the last fetch; a job of its own fetches them for every change.
    step(
        "licences, sources and known faults of dependencies",
        "deny --offline check --hide-inclusion-graph",
    )
    .with_need(Need::Deny),
];

/// Steps of [`CI`] before the first that builds the workspace.
pub(crate) const UNBUILT: usize = 6;

/// A call for crates that build without Burn and whose unit tests take seconds.
macro_rules! of_small_crates {
    ($command:literal, $rest:literal) => {
        concat!(
            $command,
            " --package=evpose-core --package=evpose-pose --package=evpose-repr",
            " --package=evpose-clean --package=evpose-camera --package=evpose-sensor --package=evpose-io",
            " --package=evpose-sim ",
            $rest
        )
    };
}

/// Checks of a few minutes between two changes, behind those of [`CI`] that build nothing.
pub(crate) const QUICK: &[Step] = &[
    step(
        "lints of small crates",
        of_small_crates!("clippy", "--all-targets --quiet -- -D warnings"),
    ),
    step("unit tests of small crates", of_small_crates!("test", "--lib --no-fail-fast")),
];

/// Checks that take long, or need what not every machine has.
pub(crate) const SLOW: &[Step] = &[
    // Not of the workspace; to run them takes a nightly compiler, to check them does not.
    step("fuzz targets compile", "check --manifest-path fuzz/Cargo.toml --all-targets"),
    // Neither is seen by CI.
    step(
        "lints with all optional features",
        with_all_features!("clippy", "--all-targets --quiet -- -D warnings"),
    ),
    step(
        "documentation with all optional features",
        with_all_features!("doc", "--no-deps --quiet"),
    )
    .with_env(&[("RUSTDOCFLAGS", "-D warnings")]),
    step(
        "lints without optional features",
        "clippy --workspace --all-targets --quiet -- -D warnings",
    ),
    // A dependency fetches a compiler when it builds, except for documentation.
    step("cuda compiles", "check --features cuda").with_env(&[("DOCS_RS", "1")]),
    // Without a network: in the order of dependencies, each with all versions and metadata. What
    // they hold is not compiled, and whether names are free is not asked.
    step(
        "every crate makes a package",
        "package --workspace --exclude=xtask --exclude=evpose-plugin --exclude=evpose-blob --exclude=gapbench \
         --exclude=gapbench-pixel --no-verify --offline --allow-dirty --quiet",
    ),
    step("an engine beside a busy thread", "test --workspace --test=threads -- --ignored"),
    // On wgpu what there is: a GPU, or Mesa's software.
    step(
        "optional features: the program with all of them, and the tests of their crates",
        with_features!("test", "--no-fail-fast"),
    ),
    step(
        "convolutions and steps of Adam on wgpu's adapter agree with the CPU's",
        with_features!("test", "--lib on_a_gpu -- --ignored"),
    ),
    step(
        "networks have the same outputs in ONNX Runtime",
        with_features!("test", "--lib onnx_runtime -- --ignored"),
    )
    .with_need(Need::Variable("ORT_DYLIB_PATH")),
    step(
        "networks have the same outputs in OpenVINO",
        with_features!("test", "--lib openvino -- --ignored"),
    )
    .with_need(Need::Variable("OPENVINO_DYLIB_PATH")),
    // What runs is compiled for every level of instructions.
    step(
        "kernels read and write only what is theirs, under AddressSanitizer",
        "+nightly test --package=evpose-kernels --lib --tests --target=x86_64-unknown-linux-gnu",
    )
    .with_env(&[("RUSTFLAGS", "-Zsanitizer=address"), ("PROPTEST_CASES", "12")])
    .with_need(Need::Nightly),
    // Only builds with checks abort at a write.
    step(
        "studies killed at every write resume, and a thousand commands with values out of their ranges end",
        "test --workspace --features=gltf --test=integration -- --ignored kills:: no_number",
    ),
    step(
        "recordings in which an effect is hidden, or none, and propagated poses",
        "test --release --test=integration -- --ignored gap:: propagation::",
    ),
    step(
        "every command of README.md and the guides runs, in small",
        "test --release --test=integration all_pages_run -- --ignored",
    ),
];

/// Runs the commands of pages, and writes what they print into them.
pub(crate) const GUIDES: Step = step(
    "outputs of commands, written into README.md and the guides",
    "test --release --test=integration all_pages_run -- --ignored",
)
.with_env(&[("EVPOSE_WRITE_PAGES", "1")]);

#[cfg(test)]
mod tests {
    use super::*;

    /// Features of the program that no test of the workspace has on, but for devices of a maker.
    fn optional_features() -> Vec<String> {
        let manifest = include_str!("../../Cargo.toml");
        let (_, features) = manifest.split_once("\n[features]\n").expect("features");
        let (features, _) = features.split_once("\n[").expect("an end");
        let mut features: Vec<(&str, &str)> =
            features.lines().filter_map(|line| line.split_once(" = ")).collect();
        let (_, on) = features.remove(0);
        // Ways of one maker's GPUs, which `cargo xtask gpu` builds.
        let gpu = ["cuda", "cuda-cpp", "vulkan", "autotune"];
        let is_off = |name: &&str| !on.contains(&format!("\"{name}\"")) && !gpu.contains(name);
        features.into_iter().map(|(name, _)| name).filter(is_off).map(str::to_owned).collect()
    }

    #[test]
    fn every_feature_is_linted_and_tested_nightly() {
        let all = optional_features();
        assert!(all.contains(&"onnx".to_owned()) && !all.contains(&"hdf5".to_owned()));
        for command in ["clippy", "test"] {
            let has_all = SLOW.iter().any(|step| {
                let mut args = step.cargo.split_whitespace();
                let is_of_command = args.next() == Some(command);
                let on = args.find_map(|arg| arg.strip_prefix("--features="));
                let on: Vec<&str> = on.unwrap_or_default().split(',').collect();
                is_of_command && all.iter().all(|feature| on.contains(&feature.as_str()))
            });
            assert!(has_all, "{command} of {all:?}");
        }
    }

    #[test]
    fn actions_are_pinned_by_digest() {
        let workflows = [
            include_str!("../../.github/workflows/ci.yml"),
            include_str!("../../.github/workflows/release.yml"),
        ];
        let used = workflows.iter().flat_map(|text| text.lines());
        let used: Vec<&str> = used.filter_map(|line| Some(line.split_once("uses: ")?.1)).collect();
        assert!(used.len() > 8, "{used:?}");
        for action in used {
            let digest = action.split_once('@').and_then(|(_, rest)| rest.split_once(" # v"));
            let is_digest = |(digest, _): (&str, &str)| {
                digest.len() == 40 && digest.bytes().all(|b| b.is_ascii_hexdigit())
            };
            assert!(digest.is_some_and(is_digest), "{action}: a tag can be moved");
        }
    }

    #[test]
    fn quick_begins_with_the_checks_that_build_nothing() {
        let builds =
            |step: &Step| !step.cargo.starts_with("xtask") && !step.cargo.starts_with("fmt");
        assert_eq!(CI.iter().position(builds), Some(UNBUILT));
    }
}
