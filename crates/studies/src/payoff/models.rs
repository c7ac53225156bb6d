//! The sensor models that are compared, and what a gap run says of them.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use evpose_cli::bad_input::BadInput;
use evpose_cli::pages::gap::files::{CORRECTED, MODEL, VERDICT};
use evpose_cli::sensor_source::sensor;
use evpose_sensor::SensorConfig;
use serde::Serialize;

use crate::payoff::args::PayoffArgs;

/// Name of the model as given.
pub(crate) const GIVEN: &str = "given";
pub(crate) const CORRECTED_MODEL: &str = "corrected";
/// Name of the measured camera's own model.
pub(crate) const CAMERA: &str = "camera";

/// A sensor model that training data are simulated with.
#[derive(Debug, Clone)]
pub(crate) struct NamedModel {
    pub(crate) name: &'static str,
    pub(crate) sensor: SensorConfig,
}

pub(crate) struct Models {
    /// Those that networks are trained on: as given, corrected, and, for an upper bound, the
    /// camera.
    pub(crate) trained: Vec<NamedModel>,
    /// The measured camera, where its effects are known.
    pub(crate) camera: Option<SensorConfig>,
    pub(crate) findings: Findings,
}

/// The answer of a gap run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Findings {
    pub(crate) run: String,
    pub(crate) verdict: String,
    /// Effects and parameters that the correction holds.
    pub(crate) effects: Vec<String>,
}

impl Models {
    pub(crate) fn load(args: &PayoffArgs) -> Result<Self> {
        let findings = Findings::read(&args.gap).context(BadInput)?;
        let of_run = |name, file: &str| -> Result<NamedModel> {
            Ok(NamedModel { name, sensor: load(&args.gap.join(file))? })
        };
        let mut trained = vec![of_run(GIVEN, MODEL)?, of_run(CORRECTED_MODEL, CORRECTED)?];
        if trained[0].sensor == trained[1].sensor {
            let problem = anyhow!(
                "{}: the corrected model is the model as given, so there is nothing to compare",
                args.gap.display()
            );
            return Err(problem.context(BadInput));
        }
        let camera = args.camera.as_deref().map(load).transpose()?;
        // Training on the camera's own model is the most that a correction can reach.
        if let Some(sensor) = camera.clone().filter(|_| args.upper_bound) {
            trained.push(NamedModel { name: CAMERA, sensor });
        }
        Ok(Self { trained, camera, findings })
    }

    /// The models as files of a study: name and text.
    pub(crate) fn files(&self) -> Vec<(String, String)> {
        let file =
            |name: &str, sensor: &SensorConfig| (format!("models/{name}.toml"), sensor.to_toml());
        let mut files: Vec<_> =
            self.trained.iter().map(|model| file(model.name, &model.sensor)).collect();
        let is_trained = self.trained.iter().any(|model| model.name == CAMERA);
        files.extend(self.camera.iter().filter(|_| !is_trained).map(|camera| file(CAMERA, camera)));
        files
    }
}

fn load(path: &Path) -> Result<SensorConfig> {
    let named = sensor(&path.to_string_lossy()).context(BadInput)?;
    named.model().context(BadInput)?;
    Ok(named.config)
}

impl Findings {
    /// Reads the fields of `verdict.json` that every version of it has.
    fn read(dir: &Path) -> Result<Self> {
        let path = dir.join(VERDICT);
        let text = std::fs::read(&path).with_context(|| {
            format!("{}: is this a directory of `evpose gap run`?", path.display())
        })?;
        let verdict: serde_json::Value =
            serde_json::from_slice(&text).with_context(|| path.display().to_string())?;
        let answer = verdict["verdict"]
            .as_str()
            .with_context(|| format!("{}: no field `verdict`", path.display()))?;
        let effects = verdict["effects"].as_array().into_iter().flatten();
        let names = effects.filter_map(|effect| effect["name"].as_str().map(str::to_owned));
        Ok(Self {
            run: dir.display().to_string(),
            verdict: answer.to_owned(),
            effects: names.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_is_read_by_the_fields_that_do_not_change() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let write = |text: &str| std::fs::write(dir.path().join(VERDICT), text);
        write(
            r#"{"schema": 9, "verdict": "effects", "effects": [{"name": "leak_on"}], "new": 1}"#,
        )?;
        let findings = Findings::read(dir.path())?;
        assert_eq!(
            (findings.verdict.as_str(), &findings.effects[..]),
            ("effects", &["leak_on".to_owned()][..])
        );
        write(r#"{"answer": "effects"}"#)?;
        let error =
            Findings::read(dir.path()).map_or_else(|error| error.to_string(), |_| String::new());
        assert!(error.contains("`verdict`"), "{error}");
        Ok(())
    }
}
