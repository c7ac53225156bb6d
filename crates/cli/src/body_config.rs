//! Configs of bodies, by file or by name.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_configs::text;
use evpose_task::body::BodyConfig;

use crate::args::ConfigArgs;

/// Configs embedded in the binary.
const EMBEDDED: &[(&str, &str)] = &[
    ("pretrain", text("body/pretrain.toml")),
    ("finetune", text("body/finetune.toml")),
    ("body-wide", text("body/wide.toml")),
    ("studio", text("body/studio.toml")),
    ("pretrain-full", text("body/pretrain-full.toml")),
    ("finetune-full", text("body/finetune-full.toml")),
];

/// Names of the embedded configs.
pub fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}

/// Loads a config by name or path. None if it is not of the body task.
pub fn config(args: &ConfigArgs) -> Result<Option<BodyConfig>> {
    if let Some((name, text)) = EMBEDDED.iter().find(|(name, _)| *name == args.config) {
        let config = BodyConfig::parse(text, &args.overrides);
        return config.map(Some).with_context(|| format!("the embedded config `{name}`"));
    }
    let path = Path::new(&args.config);
    let is_body = std::fs::read_to_string(path).is_ok_and(|text| BodyConfig::is_one(&text));
    if is_body { Ok(Some(BodyConfig::load(path, &args.overrides)?)) } else { Ok(None) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn embedded_configs_are_valid_and_say_what_they_are() -> Result<()> {
        for (name, text) in EMBEDDED {
            assert!(BodyConfig::is_one(text), "{name}");
            BodyConfig::parse(text, &[]).with_context(|| (*name).to_owned())?;
        }
        Ok(())
    }

    #[test]
    fn a_config_of_hands_is_none_of_bodies() -> Result<()> {
        let args = ConfigArgs { config: "quick".to_owned(), overrides: Vec::new() };
        assert!(config(&args)?.is_none());
        Ok(())
    }
}
