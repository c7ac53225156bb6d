//! Rows of the ablation of the hand method: change and published statements.
//!
//! # Source
//! Rudnev et al.: *EventHands: Real-Time Neural 3D Hand Pose Estimation from an Event Stream*, ICCV
//! 2021, supplement: the curves of Fig. 1, and for the networks the text on alternative backbones.
//! Of Fig. 1 one statement is left out, that representations differ less at 33 ms than at 100 ms:
//! rows for it would change two things.

use anyhow::{Result, bail};
use evpose_core::{Registry, registry_entry};
use evpose_nn::backbone_by_name;
use evpose_repr::WindowAugmentation;
use evpose_task::hand::HandConfig;
use evpose_task::schedule::TrainingPrecision;
use serde::Serialize;

use crate::study::{Relation, StudyRow};

/// The full method, with which every row is compared.
pub(super) const FULL: &str = "lnes-100";
const UNFILTERED: &str = "no-filter";

#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) name: &'static str,
    /// Description in one line.
    pub(super) about: &'static str,
    #[serde(skip)]
    pub(super) group: Group,
    #[serde(skip)]
    pub(super) change: Change,
    #[serde(skip)]
    pub(super) published: &'static [Published],
}

registry_entry!(Row, "row");

/// A published statement: the order of a row and another one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Published {
    pub(super) relation: Relation,
    /// Name of the other row.
    pub(super) than: &'static str,
    /// The statement, in full.
    pub(super) words: &'static str,
}

/// Group of rows that one chart shows with the full method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Full,
    Input,
    /// Training and filtering around the network.
    Method,
    /// The network.
    Backbone,
    /// None: no network predicts it.
    MeanPose,
}

/// Change of a row relative to the full method.
#[derive(Debug, Clone, Copy)]
pub(super) enum Change {
    Nothing,
    /// A window of another length, in milliseconds.
    Window(u32),
    Representation(&'static str),
    /// Training windows of one length, with no channels swapped.
    NoAugmentation,
    /// Another network.
    Backbone(&'static str),
    /// The poses of the full method are evaluated without the filter.
    Unfiltered,
    /// Another number format of the training's convolutions.
    Precision(TrainingPrecision),
}

const WORSE: Published = Published { relation: Relation::Worse, than: FULL, words: "" };
const COMPARABLE: &[Published] = &[Published {
    relation: Relation::Comparable,
    than: FULL,
    words: "comparable to ResNet-18 in validation loss",
}];
const SLOWER: Published = Published {
    relation: Relation::Slower,
    than: FULL,
    words: "unlike ResNet-18 too slow for 1000 poses per second",
};
const COMPARABLE_AND_SLOWER: &[Published] = &[COMPARABLE[0], SLOWER];
const NOT_COMPARABLE: &[Published] =
    &[Published { words: "not comparable to ResNet-18 in validation loss", ..WORSE }];

const fn row(
    name: &'static str,
    about: &'static str,
    group: Group,
    change: Change,
    published: &'static [Published],
) -> Row {
    Row { name, about, group, change, published }
}

/// A row of another network.
const fn network(
    name: &'static str,
    about: &'static str,
    backbone: &'static str,
    published: &'static [Published],
) -> Row {
    row(name, about, Group::Backbone, Change::Backbone(backbone), published)
}

/// Every row. A new one is a line here.
pub(super) static ROWS: Registry<Row> = Registry::new(&[
    &row(
        FULL,
        "the full method: LNES of 100 ms, augmentation, ResNet-18, Kalman filter",
        Group::Full,
        Change::Nothing,
        &[],
    ),
    &row(
        "lnes-33",
        "windows of 33 ms instead of 100; in training a third of the length, too",
        Group::Input,
        Change::Window(33),
        &[Published { words: "LNES of 100 ms beats 33 ms", ..WORSE }],
    ),
    &row(
        "lnes-300",
        "windows of 300 ms instead of 100; in training three times the length, too",
        Group::Input,
        Change::Window(300),
        &[Published { words: "LNES of 100 ms beats 300 ms", ..WORSE }],
    ),
    &row(
        "eoi",
        "whether a pixel fired, instead of how recently",
        Group::Input,
        Change::Representation("eoi"),
        &[Published { words: "LNES beats EOI at 100 ms", ..WORSE }],
    ),
    &row(
        "eci",
        "how often a pixel fired, instead of how recently",
        Group::Input,
        Change::Representation("eci"),
        &[Published { words: "LNES beats ECI at 100 ms", ..WORSE }],
    ),
    &row(
        "eci-s",
        "how often a pixel fired, whatever the polarity",
        Group::Input,
        Change::Representation("eci-s"),
        &[Published { words: "LNES beats ECI-S at 100 ms", ..WORSE }],
    ),
    &row(
        "no-augmentation",
        "training windows of one length, no channels swapped",
        Group::Method,
        Change::NoAugmentation,
        &[
            Published { words: "removing augmentation costs much", ..WORSE },
            Published {
                words: "removing augmentation costs more than removing the filter",
                than: UNFILTERED,
                ..WORSE
            },
        ],
    ),
    &row(
        UNFILTERED,
        "the network's poses as they are, without the Kalman filter",
        Group::Method,
        Change::Unfiltered,
        &[Published { words: "removing the filter costs a little", ..WORSE }],
    ),
    &row(
        "f16",
        "convolutions of the training in 16 bits of IEEE, the loss scaled",
        Group::Method,
        Change::Precision(TrainingPrecision::F16),
        &[],
    ),
    &row(
        "bf16",
        "convolutions of the training in bf16",
        Group::Method,
        Change::Precision(TrainingPrecision::Bf16),
        &[],
    ),
    &network("resnet34", "ResNet-34 instead of ResNet-18", "resnet34", COMPARABLE_AND_SLOWER),
    &network("mobilenet-v2", "MobileNetV2 instead of ResNet-18", "mobilenet_v2", COMPARABLE),
    &network("vgg11-bn", VGG_11, "vgg11_bn", COMPARABLE_AND_SLOWER),
    &network("vgg13-bn", VGG_13, "vgg13_bn", COMPARABLE),
    &network("vgg16-bn", VGG_16, "vgg16_bn", COMPARABLE),
    &network("vgg19-bn", VGG_19, "vgg19_bn", COMPARABLE),
    &network("shufflenet-v2", "ShuffleNetV2 instead of ResNet-18", "shufflenet_v2", NOT_COMPARABLE),
    &network("mnasnet", "MnasNet instead of ResNet-18", "mnasnet", NOT_COMPARABLE),
    &network("inception-v3", INCEPTION, "inception_v3", NOT_COMPARABLE),
]);

const VGG_11: &str = "VGG-11 with batch normalisation instead of ResNet-18";
const VGG_13: &str = "VGG-13 with batch normalisation instead of ResNet-18";
const VGG_16: &str = "VGG-16 with batch normalisation instead of ResNet-18";
const VGG_19: &str = "VGG-19 with batch normalisation instead of ResNet-18";
const INCEPTION: &str = "Inception v3 instead of ResNet-18; images of at least 75 pixels a side";

/// A window of another length, at evaluation and in training. What is published says nothing of
/// the lengths that such networks were trained with; here they keep their ratio to the window, or
/// else the three networks would be one.
fn set_window(config: &mut HandConfig, window_ms: u32) {
    let before = config.representation.window_ms;
    let scaled = |frames: u32| {
        let exact = f64::from(frames) * f64::from(window_ms) / f64::from(before);
        // An augmented window without a frame would hold no events.
        (exact.round() as u32).max(1)
    };
    config.augmentation.shortest_frames = scaled(config.augmentation.shortest_frames);
    config.augmentation.longest_frames = scaled(config.augmentation.longest_frames);
    config.representation.window_ms = window_ms;
}

/// The average training pose, which stands below all rows.
pub(super) const MEAN_POSE: Row = row(
    "mean-pose",
    "the average training pose, which does not depend on events",
    Group::MeanPose,
    Change::Nothing,
    &[],
);

impl StudyRow for &'static Row {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }
}

impl Row {
    /// The experiment of this row, where `base` is that of the full method.
    pub(super) fn config(&self, base: &HandConfig) -> HandConfig {
        let mut config = base.clone();
        match self.change {
            Change::Nothing | Change::Unfiltered => {}
            Change::Window(window_ms) => set_window(&mut config, window_ms),
            Change::Representation(name) => config.representation.name = name.to_owned(),
            Change::NoAugmentation => {
                config.augmentation = WindowAugmentation::none(config.representation.window_ms);
            }
            Change::Precision(precision) => config.training.precision = precision,
            Change::Backbone(name) => config.network.backbone = name.to_owned(),
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

/// Name that selects every row of another network.
pub(super) const BACKBONES: &str = "backbones";

/// The rows of these names, or all where there are none, in the order of the registry; the full
/// method is always among them. Rows that are not named by themselves are left out if their network
/// takes larger images than those of `base`; the second list has them.
pub(super) fn selected(
    names: &[String],
    base: &HandConfig,
) -> (Vec<&'static Row>, Vec<&'static Row>) {
    let is_named = |row: &Row| row.name == FULL || names.iter().any(|name| name == row.name);
    let is_in_group = |row: &Row| {
        let of_backbones = row.group == Group::Backbone && names.iter().any(|n| n == BACKBONES);
        names.is_empty() || of_backbones
    };
    let asked = ROWS.iter().copied().filter(|row| is_named(row) || is_in_group(row));
    // What is named by itself stays, so that its validation says what is wrong with it.
    asked.partition(|row| is_named(row) || fits(row, base))
}

/// Whether the network of a row takes images as small as those of `base`.
fn fits(row: &Row, base: &HandConfig) -> bool {
    let size = base.network_size();
    backbone_by_name(&row.config(base).network.backbone)
        .is_ok_and(|backbone| usize::from(size.width.min(size.height)) >= backbone.smallest_px)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use evpose_cli::configs;
    use evpose_task::Experiment as _;

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
                let differ = after.keys().filter(|key| before.get(*key) != after.get(*key));
                let wanted: &[&str] = match row.change {
                    Change::Nothing | Change::Unfiltered => &[],
                    Change::Window(_) => &[
                        "augmentation.longest_frames",
                        "augmentation.shortest_frames",
                        "representation.window_ms",
                    ],
                    Change::Representation(_) => &["representation.name"],
                    Change::NoAugmentation => &[
                        "augmentation.longest_frames",
                        "augmentation.shortest_frames",
                        "augmentation.swap_image",
                        "augmentation.swap_pixels",
                    ],
                    Change::Backbone(_) => &["network.backbone"],
                    Change::Precision(_) => &["training.precision"],
                };
                assert_eq!(differ.collect::<Vec<_>>(), wanted, "{} of {config}", row.name);
                // A field at its default may be left out; none may vanish.
                assert!(before.keys().all(|key| after.contains_key(key)));
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
        for row in &ROWS {
            let config = row.config(&base);
            assert_eq!((config.seed, &config.simulation), (base.seed, &base.simulation));
            assert_eq!(config.evaluation, base.evaluation, "{}", row.name);
        }
        Ok(())
    }

    #[test]
    fn findings_speak_of_rows_there_are_in_words() {
        for finding in ROWS.iter().flat_map(|row| row.published) {
            assert!(ROWS.find(finding.than).is_some(), "{}", finding.than);
            assert!(!finding.words.is_empty());
        }
        let silent: Vec<_> = ROWS.iter().filter(|row| row.published.is_empty()).collect();
        let names: Vec<&str> = silent.iter().map(|row| row.name).collect();
        // Number formats are ours to study.
        assert_eq!(names, [FULL, "f16", "bf16"]);
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

    #[test]
    fn the_full_method_is_always_chosen() {
        let names = |chosen: Vec<&Row>| chosen.into_iter().map(|row| row.name).collect::<Vec<_>>();
        let base = HandConfig::default();
        let asked = ["no-filter".to_owned(), "eoi".to_owned()];
        assert_eq!(names(selected(&asked, &base).0), [FULL, "eoi", "no-filter"]);
        assert_eq!(selected(&[], &base).0.len(), ROWS.len());
    }

    #[test]
    fn networks_of_larger_images_are_left_out_unless_they_are_named() -> Result<()> {
        let names = |rows: Vec<&Row>| rows.into_iter().map(|row| row.name).collect::<Vec<_>>();
        let small = configs::load("ablation", &[])?;
        for asked in [vec![], vec![BACKBONES.to_owned()]] {
            let (rows, too_small) = selected(&asked, &small);
            assert_eq!(names(too_small), ["inception-v3"]);
            assert!(rows.iter().any(|row| row.name == "vgg19-bn"));
            assert_eq!(rows.iter().any(|row| row.name == "eoi"), asked.is_empty());
        }
        let (rows, _) = selected(&["inception-v3".to_owned()], &small);
        let message =
            rows[1].config(&small).validate().map_or_else(|e| e.to_string(), |()| "".into());
        assert!(message.contains("75 pixels") && message.contains("image_scale"), "{message}");
        let larger = configs::load("ablation", &["simulation.image_scale=0.42".to_owned()])?;
        let (rows, too_small) = selected(&[BACKBONES.to_owned()], &larger);
        assert_eq!((rows.len(), too_small.len()), (11 - 1, 0));
        Ok(())
    }
}
