//! Networks of the body method: input and stages of training.

use evpose_task::body::{BodyConfig, BodySourceKind, LabelTime};

use super::Stages;

/// Events of a frame of fixed count.
const FIXED_COUNT: usize = 7_500;

/// A network of MoveEnet and how it is trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Network {
    /// EROS-like stills alone.
    Pretrained,
    /// Stills, then recordings as EROS.
    Full,
    /// Recordings as EROS alone.
    Scratch,
    /// Recordings as frames of a fixed number of events, labelled at their mean time.
    FixedCount,
    /// Recordings as integrated polarities.
    Pim,
    /// Grey stills alone.
    GreyPretrained,
    /// Grey stills, then grey frames at the same times as the recordings.
    Grey,
}

impl Network {
    /// Name of its directory.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pretrained => "pretrained",
            Self::Full => "full",
            Self::Scratch => "scratch",
            Self::FixedCount => "fixed-count",
            Self::Pim => "pim",
            Self::GreyPretrained => "grey-pretrained",
            Self::Grey => "grey",
        }
    }

    /// The network that it starts from.
    #[must_use]
    pub fn starts_from(self) -> Option<Self> {
        match self {
            Self::Full => Some(Self::Pretrained),
            Self::Grey => Some(Self::GreyPretrained),
            _ => None,
        }
    }

    /// The config of its training.
    #[must_use]
    pub fn config(self, stages: &Stages) -> BodyConfig {
        let mut config = match self {
            Self::Pretrained | Self::GreyPretrained => stages.pretrain.clone(),
            _ => stages.finetune.clone(),
        };
        // The directory of the study decides it: see `train`.
        config.start_from = None;
        match self {
            Self::Pretrained | Self::Full | Self::Scratch => {}
            Self::FixedCount => {
                config.image.representation = format!("fixed-count:n={FIXED_COUNT}");
                config.data.label_at = LabelTime::MeanOf(FIXED_COUNT);
            }
            Self::Pim => config.image.representation = "pim".to_owned(),
            Self::GreyPretrained => config.data.source = BodySourceKind::GreyStills,
            Self::Grey => config.data.source = BodySourceKind::GreyRecordings,
        }
        // The blur is for images of events, which single events make rough.
        if matches!(self, Self::GreyPretrained | Self::Grey) {
            config.image.blur = None;
        }
        config
    }
}
