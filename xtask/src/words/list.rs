//! The refused words, and the field's words for them: `docs/glossary.md` as patterns.

pub(super) struct Word {
    /// Key of the exceptions.
    pub(super) name: &'static str,
    /// Form of the line that the pattern is matched against.
    pub(super) form: Form,
    /// Regular expression of the wrong use.
    pub(super) pattern: &'static str,
    /// Regular expression of right uses; a match inside one is not counted. Empty for none.
    pub(super) except: &'static str,
    /// Beginnings of the paths that it is refused in; empty for all.
    pub(super) paths: &'static [&'static str],
    pub(super) instead: &'static str,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// In lower case, with identifiers split into words: names and prose alike.
    Split,
    /// As written: names only.
    Source,
    /// The first line of a doc comment, in lower case and without its slashes.
    DocOpening,
}

const fn new(name: &'static str, form: Form, pattern: &'static str, instead: &'static str) -> Word {
    Word { name, form, pattern, except: "", paths: &[], instead }
}

/// A word wherever it stands.
const fn word(name: &'static str, pattern: &'static str, instead: &'static str) -> Word {
    new(name, Form::Split, pattern, instead)
}

/// A word that is refused as a name in code, not in prose.
const fn code(name: &'static str, pattern: &'static str, instead: &'static str) -> Word {
    new(name, Form::Source, pattern, instead)
}

impl Word {
    const fn except(self, except: &'static str) -> Self {
        Self { except, ..self }
    }

    const fn within(self, paths: &'static [&'static str]) -> Self {
        Self { paths, ..self }
    }
}

/// Folders of the search for sensor models and of the programs about it.
const GAP: &[&str] = &[
    "crates/gap",
    "crates/cli",
    "crates/studies",
    "crates/bench",
    "crates/report",
    "benchmarks/gap",
];
/// Folders in which an eye is no part of a face.
const STREAMS: &[&str] = &["crates/live", "crates/cli", "crates/task", "crates/bench"];

/// In alphabetical order.
#[rustfmt::skip]
pub(super) const WORDS: &[Word] = &[
    word("as fine as", r"\bas fine as the image\b", "mipmap level, anti-aliased"),
    word("beside other work", r"\bbeside other work\b|\bquiet machine\b", "under load; idle"),
    word("between", r"\bposes? between\b|\bbetween (hz|rows|config)\b", "extrapolated or propagated poses"),
    word("blocks of sixteen", r"\bblocks of (sixteen|16) channels\b", "nChw16c")
        .except(r"nchw16c.*"),
    word("by turns", r"\bby turns\b", "interleaved"),
    code("called", r"\b[a-z_]+_called\b", "*_by_name"),
    word("contest", r"\bcontests?\b", "peer benchmark"),
    word("deaf", r"\bdeaf\b", "refractory period"),
    word("describes a time", r"\bdescribes? (a|the|its) time\b|\b(time|moment) (that )?(it|they|a pose) describes?\b", "pose with its event time stamp"),
    word("dose", r"\bdoses?\b", "strength level"),
    word("ends of 8 bits", r"\bends of (8|eight) bits\b", "calibration range, scale and zero point"),
    word("exchange", r"\b(put in|taken out|exchanged)\b", "ablation: add-one, drop-one, swap").within(GAP),
    word("eye", r"\beyes?\b", "stream front end").within(STREAMS),
    word("fewer bits", r"\bfewer bits\b", "quantisation, reduced precision"),
    word("film", r"\bfilms?\b", "sequence"),
    code("found", r"\bfn found\b|\.found\b|\bfound: (&|\[?[A-Z]|Vec|u\d|f\d|usize)|\b(struct|enum|type) Found\b|<[^>]*\bFound\b", "detection, prediction"),
    word("found (noun)", r"\b(a|one|each|every) found (pose|hand|body|human|person)\b", "detection, prediction"),
    word("four nearest", r"\bbetween the four nearest\b", "bilinear interpolation"),
    word("house", r"\bhouses?\b|\bmasonry\b", "no metaphors"),
    code("how far", r"\bHowFar\b|\bhow_far\b", "Progress"),
    word("judge", r"\b(prejudge|judg(e|es|ed|ing|ement|ements|ment|ments))\b", "evaluate, evaluation, score"),
    code("kept", r"^\s*(pub(\([a-z]+\))? )?(kept|held|told|seen|said|passed|looked): |\bfn (kept|held|told|said|looked)\b", "a noun phrase or a verb phrase"),
    word("knob", r"\bknobs?\b", "free parameter"),
    word("lab", r"\blabs?\b", "objective"),
    code("lack", r"\bLack\b|\blacks?\(|\blet lacks?\b", "missing field, missing_*"),
    word("look", r"\blookers?\b|\b(one|a|each|every|per|first|last) look\b|\blooks of\b|\bnothing looks\b", "inference; inference worker")
        .except(r"\b(a|one) look (up|at)\b"),
    code("look (name)", r"\b(fn|let|struct|enum|mod) (mut )?looks?\b|\.looks?\b|\blooks?: (&|[A-Zuf])|\bLook\b", "inference, sample, appearance"),
    code("most", r"\b(MOST|LEAST|FEWEST|MANY)_[A-Z]|\b(most|least|fewest)_[a-z]+", "MAX_*, MIN_*")
        .except(r"\bleast_(squares|significant|frequent|likely)\b|\bmost_(recent|likely|significant|frequent|common)\b"),
    word("meeting", r"\bmeetings?\b", "barrier"),
    word("misfit", r"\bmisfits?\b", "discrepancy statistic"),
    word("moment", r"\bmoments? (when|of|that|in time)\b|\bmoment\b", "time stamp, instant")
        .except(r"\b(a moment later|at the moment|first moment|second moment|moment of inertia|(first|second|third|central|raw) moments? of)\b")
        .within(&["crates/live", "crates/cli", "crates/train", "crates/io", "crates/core", "crates/task"]),
    word("number of a model", r"\bnumbers? of (a|an|the|its|this|every|each) (model|layer|effect|network|hand|body|arm|human|pose)s?\b", "parameter, weight, value"),
    word("numbers", r"\bnumbers\b", "parameters, values, weights, counts")
        .except(r"\b(random|floating point|line|page|port|version|magic|serial|sequence|whole|natural|odd|even|prime|real|complex|sequential|frame|house|joint|hash|atomic|big endian|equal|different|large|small|several|unequal|other|any|all) numbers( of [a-z]+s)?\b|\bnumbers of (events|threads|frames|pixels|devices|samples|steps|runs|sequences|windows|images|rows|batches|people|joints|records|files|bytes|bits|channels|values|workers|processes|recordings|cores)\b"),
    word("pause", r"\bpauses?\b", "refractory period").within(&["crates/sensor", "crates/gap", "configs/sensor", "benchmarks/gap"]),
    word("picture", r"\bpictures?\b", "image, frame, rendering, heatmap, figure"),
    word("products", r"\bproducts of (a|the) (layer|network)\b|\bm prod\.|\bmillion products\b|\bproducts (a|per) second\b", "MACs, GMAC/s"),
    word("put right", r"\b(put|puts|putting|be put) (them |it |events |a recording )?right\b|\bstraighten(s|ed|ing)?\b", "preprocess: undistort, denoise, mask, deflicker"),
    code("riddle", r"\b(enum|struct|trait|type) (BlockLine|Desk|Dose|End|Eye|Film|Firing|Flow|From|Held|Hit|Kept|Knob|Lab|Lack|Law|Look|Meeting|Of|Passed|Pause|Sight|Start|Subject|Swing|Take|Taps|Team|Then|Thing|To|Told|Unknown|What|Whole|Witnesses)\b", "a noun phrase of the field"),
    code("see", r"\bfn see\b|\.see\(", "observe"),
    word("surface of events", r"\bsurfaces?\b", "representation, event image")
        .except(r"\b(time|ordinal|active)[ -]surfaces?\b|\bsurfaces? of active events\b"),
    word("team", r"\bteams?\b", "thread pool"),
    word("told", r"\b(told|tells?|telling)\b", "report, notify, progress callback, detect, distinguish"),
    word("turns of a clock", r"\bturns? of (a|the|its) (clock|counter)\b", "wraparound"),
    code("wall", r"\bWall\b|\bmod wall\b|\bwall::|\bself\.wall\b|\bwall: ", "background plane"),
    new("what", Form::DocOpening, r"^(what|which|who|whose|where)\b", "a noun phrase: what the thing is")
        .except(r"^where to (write|keep|put|store|save)\b"),
    word("witness", r"\bwitness(es)?\b", "observer"),
];

/// Names that may have one public definition in the workspace.
pub(super) const SINGLE_NAMES: &[&str] = &[
    "Stage", "Clock", "Step", "Line", "Job", "Plane", "LANES", "Axis", "Camera", "Chain", "Change",
    "Depth", "Fault", "Finding", "Fit", "Frame", "Input", "Kind", "Mask", "Node", "Origin",
    "Packet", "Page", "Part", "Probe", "Settings", "Skeleton", "Source", "Table", "Track",
];
