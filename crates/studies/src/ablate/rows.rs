//! Rows of the ablation of the hand method: change and published statements.
//!
//! # Source
//! Rudnev et al.: *EventHands: Real-Time Neural 3D Hand Pose Estimation from an Event Stream*, ICCV
//! 2021, supplement: the curves of Fig. 1, and for the networks the text on alternative backbones.
//! Of Fig. 1 one statement is left out, that representations differ less at 33 ms than at 100 ms:
//! rows for it would change two things.

use anyhow::{Result, bail};
use evpose_repr::WindowAugmentation;
use evpose_task::hand::HandConfig;

use super::finding::{Finding, Relation};

/// The full method, with which every row is compared.
pub(super) const FULL: &str = "lnes-100";
const UNFILTERED: &str = "no-filter";

/// A row of the study.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) name: &'static str,
    /// Description in one line.
    pub(super) about: &'static str,
    pub(super) group: Group,
    pub(super) change: Change,
    /// Fields of the config that the change sets.
    pub(super) fields: &'static [&'static str],
    pub(super) published: &'static [Finding],
}

/// Group of rows that one chart shows with the full method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// The full method.
    Full,
    /// Input of the network.
    Input,
    /// Training and filtering around the network.
    Method,
    /// The network.
    Backbone,
}

/// Change of a row relative to the full method.
#[derive(Debug, Clone, Copy)]
pub(super) enum Change {
    Nothing,
    /// A change of the training config.
    Training(fn(&mut HandConfig)),
    /// The poses of the full method are evaluated without the filter.
    Unfiltered,
}

const WORSE: Finding = Finding { relation: Relation::Worse, than: FULL, words: "" };
const COMPARABLE: Finding = Finding {
    relation: Relation::Comparable,
    than: FULL,
    words: "comparable to ResNet-18 in validation loss",
};
const SLOWER: Finding = Finding {
    relation: Relation::Slower,
    than: FULL,
    words: "unlike ResNet-18 too slow for 1000 poses per second",
};

/// Every row. A new one is a line here.
pub(super) const ROWS: &[Row] = &[
    Row {
        name: FULL,
        about: "the full method: LNES of 100 ms, augmentation, ResNet-18, Kalman filter",
        group: Group::Full,
        change: Change::Nothing,
        fields: &[],
        published: &[],
    },
    Row {
        name: "lnes-33",
        about: "windows of 33 ms instead of 100; in training a third of the length, too",
        group: Group::Input,
        change: Change::Training(|config| set_window(config, 33)),
        fields: WINDOW,
        published: &[Finding { words: "LNES of 100 ms beats 33 ms", ..WORSE }],
    },
    Row {
        name: "lnes-300",
        about: "windows of 300 ms instead of 100; in training three times the length, too",
        group: Group::Input,
        change: Change::Training(|config| set_window(config, 300)),
        fields: WINDOW,
        published: &[Finding { words: "LNES of 100 ms beats 300 ms", ..WORSE }],
    },
    Row {
        name: "eoi",
        about: "whether a pixel fired, instead of how recently",
        group: Group::Input,
        change: Change::Training(|config| config.representation.name = "eoi".to_owned()),
        fields: &["representation.name"],
        published: &[Finding { words: "LNES beats EOI at 100 ms", ..WORSE }],
    },
    Row {
        name: "eci",
        about: "how often a pixel fired, instead of how recently",
        group: Group::Input,
        change: Change::Training(|config| config.representation.name = "eci".to_owned()),
        fields: &["representation.name"],
        published: &[Finding { words: "LNES beats ECI at 100 ms", ..WORSE }],
    },
    Row {
        name: "eci-s",
        about: "how often a pixel fired, whatever the polarity",
        group: Group::Input,
        change: Change::Training(|config| config.representation.name = "eci-s".to_owned()),
        fields: &["representation.name"],
        published: &[Finding { words: "LNES beats ECI-S at 100 ms", ..WORSE }],
    },
    Row {
        name: "no-augmentation",
        about: "training windows of one length, no channels swapped",
        group: Group::Method,
        change: Change::Training(|config| {
            config.augmentation = WindowAugmentation::none(config.representation.window_ms);
        }),
        fields: &[
            "augmentation.shortest_frames",
            "augmentation.longest_frames",
            "augmentation.swap_image",
            "augmentation.swap_pixels",
        ],
        published: &[
            Finding { words: "removing augmentation costs much", ..WORSE },
            Finding {
                words: "removing augmentation costs more than removing the filter",
                than: UNFILTERED,
                ..WORSE
            },
        ],
    },
    Row {
        name: UNFILTERED,
        about: "the network's poses as they are, without the Kalman filter",
        group: Group::Method,
        change: Change::Unfiltered,
        fields: &[],
        published: &[Finding { words: "removing the filter costs a little", ..WORSE }],
    },
    Row {
        name: "resnet34",
        about: "ResNet-34 instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "resnet34".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE, SLOWER],
    },
    Row {
        name: "mobilenet-v2",
        about: "MobileNetV2 instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "mobilenet_v2".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE],
    },
    Row {
        name: "vgg11-bn",
        about: "VGG-11 with batch normalisation instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "vgg11_bn".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE, SLOWER],
    },
    Row {
        name: "vgg13-bn",
        about: "VGG-13 with batch normalisation instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "vgg13_bn".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE],
    },
    Row {
        name: "vgg16-bn",
        about: "VGG-16 with batch normalisation instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "vgg16_bn".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE],
    },
    Row {
        name: "vgg19-bn",
        about: "VGG-19 with batch normalisation instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "vgg19_bn".to_owned()),
        fields: BACKBONE,
        published: &[COMPARABLE],
    },
    Row {
        name: "shufflenet-v2",
        about: "ShuffleNetV2 instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "shufflenet_v2".to_owned()),
        fields: BACKBONE,
        published: &[Finding { words: NOT_COMPARABLE, ..WORSE }],
    },
    Row {
        name: "mnasnet",
        about: "MnasNet instead of ResNet-18",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "mnasnet".to_owned()),
        fields: BACKBONE,
        published: &[Finding { words: NOT_COMPARABLE, ..WORSE }],
    },
    Row {
        name: "inception-v3",
        about: "Inception v3 instead of ResNet-18; images of at least 75 pixels a side",
        group: Group::Backbone,
        change: Change::Training(|config| config.network.backbone = "inception_v3".to_owned()),
        fields: BACKBONE,
        published: &[Finding { words: NOT_COMPARABLE, ..WORSE }],
    },
];

const NOT_COMPARABLE: &str = "not comparable to ResNet-18 in validation loss";
const BACKBONE: &[&str] = &["network.backbone"];
const WINDOW: &[&str] =
    &["representation.window_ms", "augmentation.shortest_frames", "augmentation.longest_frames"];

/// A window of another length, at evaluation and in training. What is published says nothing of
/// the lengths that such networks were trained with; here they keep their ratio to the window, or
/// else the three networks would be one.
fn set_window(config: &mut HandConfig, window_ms: u32) {
    let before = config.representation.window_ms;
    let scaled = |frames: u32| {
        let exact = f64::from(frames) * f64::from(window_ms) / f64::from(before);
        (exact.round() as u32).max(1)
    };
    config.augmentation.shortest_frames = scaled(config.augmentation.shortest_frames);
    config.augmentation.longest_frames = scaled(config.augmentation.longest_frames);
    config.representation.window_ms = window_ms;
}

impl Row {
    /// The experiment of this row, where `base` is that of the full method.
    pub(super) fn config(&self, base: &HandConfig) -> HandConfig {
        let mut config = base.clone();
        if let Change::Training(change) = self.change {
            change(&mut config);
        }
        config
    }

    /// Whether its poses are evaluated after the filter.
    pub(super) fn is_filtered(&self) -> bool {
        !matches!(self.change, Change::Unfiltered)
    }

    /// The row whose network it is evaluated with: its own, unless nothing is trained for it.
    pub(super) fn trained_as(&self) -> &'static str {
        if self.is_filtered() { self.name } else { FULL }
    }
}

/// The longest window that any row is evaluated with, in milliseconds.
pub(super) fn longest_window_ms(base: &HandConfig) -> u32 {
    ROWS.iter().map(|row| row.config(base).representation.window_ms).max().unwrap_or(0)
}

/// Refuses a config that is not that of the full method: names of rows would not say what they are.
pub(super) fn check(base: &HandConfig) -> Result<()> {
    let default = HandConfig::default();
    if base.representation != default.representation {
        bail!(
            "config section `representation`: rows change it from LNES of 100 ms with OFF first; \
             leave it as it is in `ablation`"
        );
    }
    if base.augmentation != default.augmentation {
        bail!(
            "config section `augmentation`: rows change it from the published one; leave it as it \
             is in `ablation`"
        );
    }
    if base.network.backbone != default.network.backbone {
        bail!(
            "config field `network.backbone`: rows change it from resnet18; got {}",
            base.network.backbone
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use evpose_cli::configs;
    use evpose_task::Experiment as _;

    use super::super::selection::selected;

    fn fields(config: &HandConfig) -> Result<BTreeMap<String, toml::Value>> {
        fn walk(prefix: &str, table: &toml::Table, out: &mut BTreeMap<String, toml::Value>) {
            for (key, value) in table {
                let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                match value {
                    toml::Value::Table(inner) => walk(&path, inner, out),
                    other => {
                        out.insert(path, other.clone());
                    }
                }
            }
        }
        let mut out = BTreeMap::new();
        walk("", &toml::from_str(&config.to_toml()?)?, &mut out);
        Ok(out)
    }

    #[test]
    fn every_row_changes_its_one_thing_and_nothing_else() -> Result<()> {
        for config in ["ablation", "quick", "eventhands"] {
            let base: HandConfig = configs::load(config, &[])?;
            check(&base)?;
            let before = fields(&base)?;
            let (rows, too_small) = selected(&[], &base);
            assert_eq!(too_small.len(), usize::from(config != "eventhands"), "{config}");
            for row in rows {
                let changed = row.config(&base);
                changed.validate()?;
                let after = fields(&changed)?;
                let differ = before.keys().filter(|key| before.get(*key) != after.get(*key));
                let mut wanted = row.fields.to_vec();
                wanted.sort_unstable();
                assert_eq!(differ.collect::<Vec<_>>(), wanted, "{} of {config}", row.name);
                assert_eq!(before.len(), after.len());
            }
        }
        Ok(())
    }

    #[test]
    fn no_two_rows_are_the_same() -> Result<()> {
        let base: HandConfig = configs::load("ablation", &[])?;
        for (i, one) in ROWS.iter().enumerate() {
            for other in &ROWS[..i] {
                assert_ne!(one.name, other.name);
                let same = one.config(&base) == other.config(&base);
                let trained_once = one.trained_as() == other.trained_as();
                assert_eq!(same, trained_once, "{} and {}", one.name, other.name);
                assert!(!same || one.is_filtered() != other.is_filtered());
            }
        }
        Ok(())
    }

    #[test]
    fn all_rows_are_evaluated_on_the_same_sequences_from_the_first_full_window_on() -> Result<()> {
        let base: HandConfig = configs::load("ablation", &[])?;
        assert_eq!(longest_window_ms(&base), base.evaluation.first_ms);
        for row in ROWS {
            let config = row.config(&base);
            assert_eq!((config.seed, &config.simulation), (base.seed, &base.simulation));
            assert_eq!(config.evaluation, base.evaluation, "{}", row.name);
        }
        Ok(())
    }

    #[test]
    fn findings_speak_of_rows_there_are_in_words() {
        for finding in ROWS.iter().flat_map(|row| row.published) {
            assert!(ROWS.iter().any(|row| row.name == finding.than), "{}", finding.than);
            assert!(!finding.words.is_empty());
        }
        let silent: Vec<_> = ROWS.iter().filter(|row| row.published.is_empty()).collect();
        assert!(matches!(silent[..], [full] if full.name == FULL));
    }

    #[test]
    fn a_base_that_is_not_the_full_method_is_refused() -> Result<()> {
        for (field, change) in [
            ("representation", "representation.window_ms=50"),
            ("augmentation", "augmentation.swap_image=false"),
            ("network.backbone", "network.backbone=resnet34"),
        ] {
            let base: HandConfig = configs::load("ablation", &[change.to_owned()])?;
            let message = check(&base).map_or_else(|error| error.to_string(), |()| String::new());
            assert!(message.contains(field), "{change}: {message}");
        }
        Ok(())
    }
}
