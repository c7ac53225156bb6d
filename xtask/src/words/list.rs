//! The refused words, and the field's words for them: `docs/glossary.md` as patterns.

/// A refused word.
pub(super) struct Word {
    /// Key of the exceptions.
    pub(super) name: &'static str,
    /// A regular expression over lines in lower case whose identifiers are split into words.
    pub(super) pattern: &'static str,
    /// The standard word.
    pub(super) instead: &'static str,
}

const fn word(name: &'static str, pattern: &'static str, instead: &'static str) -> Word {
    Word { name, pattern, instead }
}

/// In alphabetical order.
#[rustfmt::skip]
pub(super) const WORDS: &[Word] = &[
    word("as fine as", r"\bas fine as the image\b", "mipmap level, anti-aliased"),
    word("beside other work", r"\bbeside other work\b|\bquiet machine\b", "under load; idle"),
    word("between hz", r"\b(poses? between|between hz|between (poses|rows|config))\b", "extrapolated or propagated poses"),
    word("by turns", r"\bby turns\b", "interleaved"),
    word("called", r"[a-z] called\(", "*_by_name"),
    word("contest", r"\bcontests?\b", "peer benchmark"),
    word("deaf", r"\bdeaf\b", "refractory period"),
    word("dose", r"\bdoses?\b", "strength level"),
    word("ends of 8 bits", r"\bends of (8|eight) bits\b", "calibration range"),
    word("eye", r"\beyes?\b", "stream front end"),
    word("fewer bits", r"\bfewer bits\b", "quantisation, reduced precision"),
    word("fewest", r"\bfewest\b", "minimum; MIN_*"),
    word("film", r"\bfilms?\b", "sequence"),
    word("four nearest", r"\bbetween the four nearest\b", "bilinear interpolation"),
    word("house", r"\b(house|rooms? of|masonry)\b", "no metaphors"),
    word("how far", r"\bhow far\b", "progress"),
    word("judge", r"\bjudg(e|es|ed|ing|ement|ements)\b", "evaluate, evaluation, score"),
    word("kept type", r"\b(enum|struct|trait|type) (kept|held|whole|told|passed|found|thing|what|of|law|take)\b", "a noun phrase"),
    word("knob", r"\bknobs?\b", "free parameter"),
    word("lab", r"\blabs?\b", "objective"),
    word("lack", r"\blacks?\b", "missing field"),
    word("least", r"\bleast [a-z]+: (usize|f64|f32|u32|u64|i64|micros|u8|u16)", "MIN_*"),
    word("looker", r"\b(looker|lookers|one look|a look of)\b", "inference; inference worker"),
    word("meeting", r"\bmeetings?\b", "barrier"),
    word("misfit", r"\bmisfits?\b", "discrepancy statistic"),
    word("moment", r"\bmoments? (when|of|that|in time)\b", "time stamp, instant"),
    word("most", r"\bmost [a-z]+: (usize|f64|f32|u32|u64|i64|micros|u8|u16)", "MAX_*"),
    word("numbers", r"\bnumbers\b", "parameters, values, weights, counts"),
    word("pause", r"\bpauses?\b", "refractory period"),
    word("picture", r"\bpictures?\b", "image, frame, rendering, heatmap, figure"),
    word("products", r"\bproducts of (a|the) (layer|network)|\bm prod\.", "MACs"),
    word("put right", r"\b(put|puts|putting) (them |it )?right\b|\bstraighten(s|ed)?\b", "preprocess: undistort, denoise, mask, deflicker"),
    word("surface of events", r"\bsurfaces?\b", "representation, event image"),
    word("team", r"\bteams?\b", "thread pool"),
    word("told", r"\b(told|tells?|telling)\b", "report, notify, progress callback, detect"),
    word("what", r"^\s*//[/!] (what|which|who|whose|how|where|whether)\b", "a noun phrase: what the thing is"),
    word("witness", r"\bwitness(es)?\b", "observer"),
];
