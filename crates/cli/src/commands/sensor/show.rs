//! `evpose sensor show`: the chain of a sensor.

use anyhow::{Result, bail};
use evpose_sensor::{ChainRow, PRESETS, STAGES, Setting};
use serde_json::{Map, Value, json};

use super::args::ShowArgs;
use super::list;
use crate::progress::say;
use crate::sensor_source::{self as source, NamedSensor};

pub(super) fn run(args: &ShowArgs) -> Result<()> {
    let is_file = std::path::Path::new(&args.name).exists();
    let is_preset = PRESETS.find(&args.name).is_some();
    // Sensors come first, as in other commands: an effect is shown if none has the name.
    if !is_file && !is_preset {
        let Some(spec) = STAGES.find(&args.name) else {
            let known = [PRESETS.names(), STAGES.names()].concat();
            bail!(source::unknown("preset, effect or file", &args.name, &known));
        };
        if args.json {
            say(serde_json::to_string_pretty(&list::effect(spec))?);
        } else {
            say(spec.to_string().trim_end());
        }
        return Ok(());
    }
    let sensor = source::sensor(&args.name)?;
    if args.json {
        say(serde_json::to_string_pretty(&json(&sensor)?)?);
        return Ok(());
    }
    say(list::column(&format!("{}: ", sensor.name), &sensor.origin));
    say("");
    say(sensor.model()?.describe().to_string().trim_end());
    Ok(())
}

fn json(sensor: &NamedSensor) -> Result<Value> {
    let model = sensor.model()?;
    let stages = model.describe().rows.iter().map(stage);
    Ok(json!({
        "name": sensor.name,
        "origin": sensor.origin,
        "stages": stages.collect::<Vec<_>>(),
    }))
}

fn stage(row: &ChainRow) -> Value {
    let mut stage = list::effect(row.spec);
    let (mut parameters, mut words, mut files) = (Vec::new(), Map::new(), Map::new());
    for (name, setting) in row.settings.iter() {
        match setting {
            Setting::Number(number, value) => {
                let mut parameter = list::parameter(number);
                parameter["value"] = list::number(*value);
                parameters.push(parameter);
            }
            Setting::Word(_, word) => _ = words.insert(name.to_owned(), json!(word)),
            Setting::File(_, path) => _ = files.insert(name.to_owned(), json!(path)),
            Setting::Text(_, text) => _ = files.insert(name.to_owned(), json!(text)),
        }
    }
    stage["parameters"] = parameters.into();
    stage["chosen"] = words.into();
    stage["given"] = files.into();
    stage["is_active"] = json!(row.is_active);
    stage
}
