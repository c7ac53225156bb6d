//! RAW files in the registry of formats.

use super::content::SAMPLE;
use super::encoding::Encoding;
use super::header::Lines;
use super::writer::create;
use super::{
    Evt2Decoder, Evt2Encoder, Evt3Decoder, Evt3Encoder, Evt4Decoder, Evt21Decoder, Evt21Encoder,
};
use crate::open::{Format, no_labels};
use crate::source::Shifted;
use crate::{BlockSource, Decoder, EventSource, Header, Input, IoError, OpenOptions};

/// The registry's entry of EVT 2.0.
pub(crate) const EVT2: Format = Format {
    name: "evt2",
    summary: "Prophesee RAW, EVT 2.0: a word of 32 bits an event",
    endings: &[".evt2"],
    probe: |head| Encoding::detect_in_head(head) == Some(Encoding::Evt2),
    open: |input, options| open(input, options, EVT2.name),
    create: Some(create::<Evt2Encoder>),
    labels: no_labels,
};

/// The registry's entry of EVT 2.1.
pub(crate) const EVT21: Format = Format {
    name: "evt2.1",
    summary: "Prophesee RAW, EVT 2.1: words of 64 bits for 32 pixels",
    endings: &[".evt21"],
    probe: |head| matches!(Encoding::detect_in_head(head), Some(Encoding::Evt21 { .. })),
    open: |input, options| open(input, options, EVT21.name),
    create: Some(create::<Evt21Encoder>),
    labels: no_labels,
};

/// The registry's entry of EVT 3.0.
pub(crate) const EVT3: Format = Format {
    name: "evt3",
    summary: "Prophesee RAW, EVT 3.0: words of 16 bits that change time, row or column",
    endings: &[".raw", ".evt3"],
    probe: |head| Encoding::detect_in_head(head) == Some(Encoding::Evt3),
    open: |input, options| open(input, options, EVT3.name),
    create: Some(create::<Evt3Encoder>),
    labels: no_labels,
};

/// The registry's entry of EVT 4.0.
pub(crate) const EVT4: Format = Format {
    name: "evt4",
    summary: "Prophesee RAW, EVT 4.0: words of 32 bits, and vectors of 32 pixels",
    endings: &[".raw"],
    probe: |head| Encoding::detect_in_head(head) == Some(Encoding::Evt4),
    open: |input, options| open(input, options, EVT4.name),
    create: None,
    labels: no_labels,
};

/// Reads the header of a file; returns it with the encoding, the offset of the first word, and the time
/// that times count from.
fn begin(input: &mut Input) -> Result<(Header, Encoding, u64, i64), IoError> {
    let lines = Lines::read(input)?;
    lines.check_end(input)?;
    let mut data = input.head(lines.length + SAMPLE)?;
    // Headers of old files do not name the encoding: the first words do.
    let encoding = Encoding::detect(&lines, &data.split_off(lines.length.min(data.len())));
    let unknown = || {
        let reason = match lines.get("format").or(lines.get("evt")) {
            Some(format) => format!("words of the encoding `{format}` are not read"),
            None => "neither header nor words say whether this is EVT 2.0, 2.1, 3.0 or 4.0".into(),
        };
        IoError::damaged(&input.path, lines.length as u64, reason)
    };
    let encoding = encoding.ok_or_else(unknown)?;
    Ok((lines.header(), encoding, lines.length as u64, lines.t0()))
}

fn open(
    mut input: Input,
    options: &OpenOptions,
    name: &str,
) -> Result<Box<dyn EventSource>, IoError> {
    let (mut header, encoding, start, t0) = begin(&mut input)?;
    if encoding.name() != name {
        // The header says so, or ends, behind what a probe sees.
        header.facts.push(("encoding", encoding.name().to_owned()));
    }
    let file = (input, start, header, t0);
    Ok(match encoding {
        Encoding::Evt2 => source(file, Evt2Decoder::default()),
        Encoding::Evt21 { is_legacy } => source(file, Evt21Decoder::new(is_legacy)),
        Encoding::Evt3 => source(file, Evt3Decoder::new(options.camera)),
        Encoding::Evt4 => source(file, Evt4Decoder::default()),
    })
}

fn source<D: Decoder + 'static>(
    (input, start, header, t0): (Input, u64, Header, i64),
    decoder: D,
) -> Box<dyn EventSource> {
    Box::new(BlockSource::new(input, start, header, Shifted::new(decoder, t0)))
}
