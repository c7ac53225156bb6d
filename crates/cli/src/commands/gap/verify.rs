//! `evpose gap verify`: independent evaluation of a run, from its files alone.

use anyhow::{Context, Result, anyhow, bail};
use evpose_core::{EventStream, Micros, TimeWindow, seed_for};
use evpose_gap_eval::{Frames, evaluate};
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::args::VerifyArgs;
use super::inputs;
use crate::bad_input::BadInput;
use crate::json::write_result;
use crate::pages::gap::files;
use crate::progress::say;
use crate::scene_source::SceneSource;

pub(super) fn run(args: &VerifyArgs) -> Result<()> {
    let info = files::run_info(&args.dir).context(BadInput)?;
    let read = |name: &str| -> Result<SensorConfig> {
        let path = args.dir.join(name);
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        Ok(SensorConfig::from_toml(&text)?)
    };
    let before = read(&info.model_before).context(BadInput)?;
    let after = read(&info.model_after).context(BadInput)?;
    // A second recording if there is one, since the first was used in the search.
    let (measured, scene, poses) = match (&info.validate, &info.validate_scene, &info.scene) {
        (Some(recording), Some(scene), _) => (recording, scene, &info.validate_poses),
        (_, _, Some(scene)) => (&info.measured, scene, &info.poses),
        _ => {
            return Err(anyhow!("a run without a scene has nothing that can be evaluated"))
                .context(BadInput);
        }
    };
    let source = SceneSource {
        path: scene.clone(),
        poses: poses.clone(),
        seconds: info.scene_seconds,
        response: info.response.as_deref().map(str::parse).transpose()?,
    };
    // With the model as given: the corrected one must not choose its own repairs.
    let case = inputs::load(measured, &info.reading, &source, &before, info.as_is)?.case;
    let Some([from, to]) = info.held_s else {
        bail!("run.json does not record the held-out window")
    };
    let window = TimeWindow { start: Micros::from_seconds(from), end: Micros::from_seconds(to) };
    let simulated = |model: &SensorConfig| -> Result<Vec<EventStream>> {
        let run = |run: u64| -> Result<EventStream> {
            // Seeds of its own: those of the search would favour what it chose.
            let seed = seed_for(args.seed, "judged run", run);
            Ok(case.scene.events(model, seed)?.slice(window))
        };
        (0..args.runs).into_par_iter().map(run).collect()
    };
    let frames = Frames { planes: case.scene.planes(), fps: case.scene.fps() };
    let held_out = case.measured.slice(window);
    say(format!(
        "evaluated on {} events of {} from {from:.3} s to {to:.3} s, {} runs of each model",
        held_out.len(),
        measured.display(),
        args.runs
    ));
    let evaluation = evaluate(&held_out, &simulated(&before)?, &simulated(&after)?, Some(frames))?;
    say(&evaluation);
    write_result(&args.dir.join("verify.json"), &evaluation)
}
