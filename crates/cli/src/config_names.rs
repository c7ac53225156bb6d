//! Names of the embedded configs of all tasks, and errors of names that are none.

use evpose_sensor::nearest;

use crate::{body_config, hand_config};

/// Names of the embedded configs, those of hands first.
pub fn config_names() -> impl Iterator<Item = &'static str> {
    hand_config::names().chain(body_config::names())
}

/// Message for `source`, which is neither a file nor an embedded config of the task: the most similar
/// names, and all there are, or those of each task.
pub fn unknown_config(source: &str) -> String {
    if config_names().any(|name| name == source) {
        let [hands, bodies] = [hand_config::names().collect(), body_config::names().collect()];
        let [hands, bodies] = [hands, bodies].map(|names: Vec<&str>| names.join(", "));
        return format!(
            "{source}: an embedded config, but of another task (of hands: {hands}; of bodies: {bodies})"
        );
    }
    let near = nearest(source, config_names());
    let hint = match near.as_slice() {
        [] => String::new(),
        near => format!(": did you mean {}?", near.join(" or ")),
    };
    let all: Vec<&str> = config_names().collect();
    format!(
        "{source}: no such file, and no embedded config of that name{hint} (there are {})",
        all.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_and_configs_of_all_tasks_are_listed() {
        let message = unknown_config("fintune");
        assert!(message.contains("did you mean finetune"), "{message}");
        assert!(message.contains("quick") && message.contains("pretrain-full"), "{message}");
        let message = unknown_config("pretrain-full");
        assert!(message.starts_with("pretrain-full: an embedded config, but of"), "{message}");
        let message = unknown_config("runs/config.toml");
        assert!(!message.contains("did you mean") && message.contains("body-wide"), "{message}");
    }
}
