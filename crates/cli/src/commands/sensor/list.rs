//! `evpose sensor list`: presets and effects.

use anyhow::Result;
use evpose_sensor::{NumberSpec, PRESETS, Parameter, STAGES, StageSpec};
use serde_json::{Value, json};

use super::args::ListArgs;
use crate::progress::say;

const WIDTH: usize = 100;

pub(super) fn run(args: &ListArgs) -> Result<()> {
    if args.json {
        say(serde_json::to_string_pretty(&catalogue())?);
        return Ok(());
    }
    say("PRESETS    evpose sensor show NAME for the chain with all parameters\n");
    for preset in &PRESETS {
        let sentence = first_sentence(&preset.origin());
        say(column(&format!("  {:<15}", preset.name), &sentence));
    }
    say("\nEFFECTS    evpose sensor show NAME for formula, source, ranges and what is typical");
    // Effects of other crates come last in the registry.
    let mut stages = STAGES.to_vec();
    stages.sort_by_key(|spec| spec.domain);
    for stages in stages.chunk_by(|a, b| a.domain == b.domain) {
        say(format!("\n{}", stages[0].domain.name().to_uppercase()));
        for spec in stages {
            say(column(&format!("  {:<26}", spec.name), spec.summary));
            if !spec.keys().is_empty() {
                say(column(&" ".repeat(30), &settings(spec)));
            }
        }
    }
    Ok(())
}

/// Parameters with their units, choices with their values, files and texts.
fn settings(spec: &StageSpec) -> String {
    let setting = |param: &Parameter| match param {
        Parameter::Number(number) if number.unit.is_empty() => number.name.to_owned(),
        Parameter::Number(number) => format!("{} [{}]", number.name, number.unit),
        Parameter::Word(choice) => format!("{} ({})", choice.name, choice.allowed.join("|")),
        Parameter::File(file) => format!("{} [file, {}]", file.name, file.unit),
        Parameter::Text(text) => format!("{} [text]", text.name),
    };
    spec.params.iter().map(setting).collect::<Vec<_>>().join(", ")
}

/// The registry as JSON.
fn catalogue() -> Value {
    let presets = PRESETS.iter().map(
        |preset| json!({ "name": preset.name, "origin": preset.origin(), "toml": preset.toml }),
    );
    json!({
        "presets": presets.collect::<Vec<_>>(),
        "effects": STAGES.iter().map(|spec| effect(spec)).collect::<Vec<_>>(),
    })
}

pub(super) fn effect(spec: &StageSpec) -> Value {
    let choices =
        spec.params.iter().filter_map(Parameter::as_word).map(
            |choice| json!({ "name": choice.name, "allowed": choice.allowed, "doc": choice.doc }),
        );
    let files = spec
        .params
        .iter()
        .filter_map(Parameter::as_file)
        .map(|file| json!({ "name": file.name, "unit": file.unit, "doc": file.doc }));
    let texts = spec
        .params
        .iter()
        .filter_map(Parameter::as_text)
        .map(|text| json!({ "name": text.name, "example": text.example, "doc": text.doc }));
    json!({
        "name": spec.name,
        "domain": spec.domain.name(),
        "summary": spec.summary,
        "formula": spec.formula,
        "source": { "key": spec.source.key, "text": spec.source.text },
        "look_for": spec.signature.look_for,
        "parameters": spec.number_params().map(parameter).collect::<Vec<_>>(),
        "choices": choices.collect::<Vec<_>>(),
        "files": files.collect::<Vec<_>>(),
        "texts": texts.collect::<Vec<_>>(),
    })
}

/// A parameter as JSON; infinity, which JSON lacks, is a string.
pub(super) fn parameter(param: &NumberSpec) -> Value {
    json!({
        "name": param.name,
        "unit": param.unit,
        "doc": param.doc,
        "range": [param.range.0, param.range.1],
        "scale": format!("{:?}", param.scale).to_lowercase(),
        "typical": param.typical.map(|(low, high)| json!([low, high])),
        "neutral": param.default.map(number),
    })
}

/// A value as JSON, which lacks infinity.
pub(super) fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}

/// The first sentence of a text: a full stop of `et al.` or in parentheses does not end it.
pub(super) fn first_sentence(text: &str) -> String {
    let mut depth = 0;
    let mut before = ' ';
    let end = text.char_indices().find(|&(i, c)| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        let ends = c == '.' && depth == 0 && text[i + 1..].starts_with([' ', '\n']);
        // A full stop behind a capital ends an initial of a name, not a sentence.
        let is_end = ends && before.is_lowercase() | before.is_ascii_digit() | (before == ')');
        before = c;
        is_end && !text[..i].ends_with("et al")
    });
    end.map_or(text, |(i, _)| &text[..=i]).to_owned()
}

/// Text after a label, wrapped at the line width.
pub(super) fn column(label: &str, text: &str) -> String {
    let indent = label.chars().count();
    let (mut lines, mut line) = (Vec::new(), label.to_owned());
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() > WIDTH {
            lines.push(line.trim_end().to_owned());
            line = " ".repeat(indent);
        }
        line += word;
        line.push(' ');
    }
    lines.push(line.trim_end().to_owned());
    lines.join("\n")
}
