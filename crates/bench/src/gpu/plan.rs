//! The steps of a run, and its rows.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::step::Finished;

#[derive(Debug, Default)]
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) device: String,
    /// The way of convolutions on GPUs.
    pub(super) way: &'static str,
    pub(super) limit_s: f64,
    pub(super) arguments: Vec<String>,
    pub(super) environment: Vec<(&'static str, &'static str)>,
    pub(super) files: Vec<String>,
    /// Lines of its output to keep, if more than usual.
    pub(super) lines: usize,
}

/// Devices and sizes of the measurements.
pub(super) struct Plan<'a> {
    pub(super) devices: &'a [String],
    pub(super) small: bool,
}

/// Names of the steps whose results become rows.
const INFERENCE: &str = "inference";
const TRAINING_STEP: &str = "training-step";
const BODY: &str = "move_enet";
/// Our way, and the others it is compared with.
const OURS: &str = "columns-f32";
const OTHERS: [&str; 3] = ["columns", "burn", "implicit"];

impl Step {
    /// A training that is continued in the time that is left.
    pub(super) fn training(run: &Path, data: &Path, device: &str, way: &'static str) -> Self {
        let path = |path: &Path| path.display().to_string();
        let words =
            ["train", &path(&run.join("config.toml")), "--data", &path(data), "--out", &path(run)];
        let more = ["--resume", "--plain", "--device", device];
        Self {
            name: "training",
            device: device.to_owned(),
            way,
            limit_s: f64::INFINITY,
            arguments: words.into_iter().chain(more).map(str::to_owned).collect(),
            ..Self::default()
        }
    }

    /// A step that runs benchmarks one after the other.
    fn series(
        name: &'static str,
        device: &str,
        way: &'static str,
        limit_s: f64,
        lines: &[String],
    ) -> Self {
        // Names of files hold no colons on Windows.
        let file = |k: usize| format!("{name}-{}-{way}-{k}.json", device.replace(':', "-"));
        let files: Vec<String> = (0..lines.len()).map(file).collect();
        let mut arguments = vec!["bench".to_owned(), "gpu".to_owned()];
        for (line, file) in lines.iter().zip(&files) {
            arguments.extend(["--series".to_owned(), format!("{line} --json {file}")]);
        }
        Self { name, device: device.to_owned(), way, limit_s, arguments, files, ..Self::default() }
    }
}

impl Plan<'_> {
    /// The steps, the worthiest first.
    pub(super) fn steps(&self) -> Vec<Step> {
        // Agreement first: times of wrong results would say nothing.
        let mut steps: Vec<Step> =
            self.devices.iter().map(|device| self.agreement(device, OURS)).collect();
        for device in self.devices {
            steps.push(self.training_step(device, OURS, 60.0));
            steps.push(self.inference(device, OURS, 75.0));
            steps.push(self.profile(device));
            steps.push(self.layers(device));
            steps.push(self.inference(device, OTHERS[0], 30.0));
            steps.push(self.training_step(device, OTHERS[0], 30.0));
        }
        steps.push(self.engine());
        steps.extend(self.cpu_training());
        for device in self.devices {
            steps.push(self.inference(device, OTHERS[1], 45.0));
            steps.push(self.training_step(device, OTHERS[1], 45.0));
            steps.push(self.inference(device, OTHERS[2], 30.0));
        }
        // Agreement of the other way comes last, since it is not the way that is used.
        steps.extend(self.devices.iter().map(|device| self.agreement(device, OTHERS[0])));
        steps
    }

    fn config(&self) -> &'static str {
        if self.small { "quick" } else { "eventhands" }
    }

    fn agreement(&self, device: &str, way: &'static str) -> Step {
        let file = format!("agreement-{}-{way}.json", device.replace(':', "-"));
        let arguments = ["bench", "gpu", "--agreement", device, "--json", &file].map(str::to_owned);
        Step {
            name: "agreement",
            device: device.to_owned(),
            way,
            limit_s: 75.0,
            arguments: arguments.into(),
            files: vec![file],
            ..Step::default()
        }
    }

    fn inference(&self, device: &str, way: &'static str, limit_s: f64) -> Step {
        let (config, runs) = (self.config(), if self.small { 2 } else { 30 });
        let batches: &[usize] = if self.small { &[1, 4] } else { &[16, 1, 64, 256] };
        let lines = self.of_networks(batches, |network, batch| {
            format!(
                "infer --config {config} {network}--device {device} --batch {batch} --runs {runs}"
            )
        });
        Step::series(INFERENCE, device, way, limit_s, &lines)
    }

    /// Lines of the hand's network and of the body's, which is large: none of it in a small plan.
    fn of_networks(&self, batches: &[usize], line: impl Fn(&str, usize) -> String) -> Vec<String> {
        let networks: &[&str] = if self.small { &[""] } else { &["", "--network move_enet "] };
        networks.iter().flat_map(|network| batches.iter().map(|b| line(network, *b))).collect()
    }

    fn training_step(&self, device: &str, way: &'static str, limit_s: f64) -> Step {
        let (config, steps) = (self.config(), if self.small { 1 } else { 15 });
        let batches: &[usize] = if self.small { &[4] } else { &[16, 64] };
        // A format that a device lacks ends a series: 16 bits come last.
        let lines = ["f32", "f16"].map(|precision| {
            self.of_networks(batches, |network, batch| {
                format!(
                    "train --config {config} {network}--device {device} --batch {batch} --steps {steps} \
                     --precision {precision}"
                )
            })
        });
        Step::series(TRAINING_STEP, device, way, limit_s, &lines.concat())
    }

    /// Counts of threads of this machine: 1, 2, 4, … and all.
    fn threads(&self) -> Vec<usize> {
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        let mut counts: Vec<usize> =
            std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < all).collect();
        counts.push(all);
        counts
    }

    /// Our engine on the CPU.
    fn engine(&self) -> Step {
        // Enough for a median, and a run takes milliseconds.
        let (config, runs) = (self.config(), if self.small { 2 } else { 25 });
        let threads: Vec<String> = self.threads().iter().map(usize::to_string).collect();
        let line = |network: &str, precision: &str| {
            let threads = threads.join(",");
            format!(
                "infer --config {config} {network}--threads {threads} --precision {precision} --runs {runs}"
            )
        };
        let networks: &[&str] = if self.small { &[""] } else { &["", "--network move_enet "] };
        let lines: Vec<String> = networks
            .iter()
            .flat_map(|network| ["f32", "bf16", "int8"].map(|precision| line(network, precision)))
            .collect();
        Step::series(INFERENCE, "flex", "engine", 60.0, &lines)
    }

    /// Training steps on the CPU; a process each, since threads are set once.
    fn cpu_training(&self) -> Vec<Step> {
        let (config, steps) = (self.config(), if self.small { 1 } else { 4 });
        let mut counts = self.threads();
        // The most threads come first: time may run out, and one thread takes the longest.
        counts.reverse();
        let of = |(k, threads): (usize, &usize)| {
            // The largest batch with all threads alone.
            let batches: &[usize] = if k == 0 && !self.small { &[16, 64] } else { &[16] };
            let line = |batch: &usize| {
                format!(
                    "train --config {config} --threads {threads} --batch {batch} --steps {steps}"
                )
            };
            let lines: Vec<String> = batches.iter().map(line).collect();
            let mut step = Step::series(TRAINING_STEP, "flex", "kernels", 25.0, &lines);
            // Steps differ by threads alone: their files would overwrite each other without these.
            // Lines stand at index 3 and at every second one, behind `bench gpu --series`.
            for (file, argument) in
                step.files.iter_mut().zip(step.arguments.iter_mut().skip(3).step_by(2))
            {
                let named = file.replace(".json", &format!("-{threads}.json"));
                *argument = argument.replace(file.as_str(), &named);
                *file = named;
            }
            step
        };
        counts.iter().enumerate().map(of).collect()
    }

    /// Times of all layers of an inference.
    fn layers(&self, device: &str) -> Step {
        let config = self.config();
        let line =
            format!("infer --config {config} --device {device} --batch 16 --runs 5 --layers");
        Step { lines: 120, ..Step::series("layers", device, OURS, 30.0, &[line]) }
    }

    /// Times of all kernels of an inference, by CubeCL's own profiling.
    fn profile(&self, device: &str) -> Step {
        let config = self.config();
        let line = format!("infer --config {config} --device {device} --batch 16 --runs 5");
        let mut step = Step::series("profile", device, OURS, 30.0, &[line]);
        step.environment =
            vec![("CUBECL_DEBUG_LOG", "stdout"), ("CUBECL_DEBUG_OPTION", "profile-medium")];
        step.lines = 120;
        step
    }
}

/// Rows: each work once, with milliseconds of every way that it was measured by.
pub(super) fn cases(steps: &[Finished]) -> Vec<Map<String, Value>> {
    let mut rows: Vec<Map<String, Value>> = Vec::new();
    for step in steps {
        for result in &step.results {
            for (name, field, ms) in measured(step, result) {
                // Few rows, so that a search beats a map; rows stay in the order of steps.
                let row = match rows.iter_mut().find(|row| row["name"] == name) {
                    Some(row) => row,
                    None => {
                        rows.push(Map::from_iter([("name".to_owned(), json!(name))]));
                        let last = rows.len() - 1;
                        &mut rows[last]
                    }
                };
                row.insert(field, json!(ms));
            }
        }
    }
    rows
}

/// Name of the row, field and milliseconds of every measurement of a result.
fn measured(step: &Finished, result: &Value) -> Vec<(String, String, f64)> {
    let by = format!("{}_{}", step.device.replace(':', ""), step.way.replace('-', "_"));
    if step.name == TRAINING_STEP {
        let (network, batch) = (&result["network"], &result["input"][0]);
        let name = format!("training step of {batch}, {}", network.as_str().unwrap_or_default());
        let threads = &result["machine"]["threads"];
        // The CPU is measured with several numbers of threads, each in a column of its own.
        let field = match (step.device.as_str(), result["precision"].as_str()) {
            ("flex", _) => format!("{by}_{threads}_ms"),
            (_, Some(precision)) if precision != "f32" => format!("{by}_{precision}_ms"),
            _ => format!("{by}_ms"),
        };
        return result["step"]["median_ms"]
            .as_f64()
            .map(|ms| (name, field, ms))
            .into_iter()
            .collect();
    }
    if step.name != INFERENCE {
        return Vec::new();
    }
    let cases = result["cases"].as_array().into_iter().flatten();
    let row = |case: &Value| {
        let name = format!("{} of {}", case["input"][0], case["network"].as_str()?);
        let field = if step.device == "flex" {
            format!("{by}_{}_{}_ms", case["precision"].as_str()?, case["threads"])
        } else {
            format!("{by}_ms")
        };
        Some((name, field, case["p50_ms"].as_f64()?))
    };
    cases.filter_map(row).collect()
}

/// The device and the way of the shortest training step of the hand's network; the CPU if none was
/// measured.
pub(super) fn fastest(steps: &[Finished]) -> (String, &'static str) {
    let of = |step: &Finished| {
        let hand = step.results.iter().find(|result| result["network"] != BODY)?;
        Some((hand["step"]["median_ms"].as_f64()?, step.device.clone(), step.way))
    };
    let timed = steps.iter().filter(|step| step.name == TRAINING_STEP).filter_map(of);
    timed
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or_else(|| ("flex".to_owned(), "kernels"), |(_, device, way)| (device, way))
}
