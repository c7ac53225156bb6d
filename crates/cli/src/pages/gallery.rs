//! `evpose sensor gallery`: every preset and every effect on the same moving hand, and in the
//! measurement in which it stands out.

mod bench;
mod event_image;
mod probe;

use std::path::Path;

use anyhow::{Context, Result, bail};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evpose_core::{Micros, Plane};
use evpose_sensor::{PRESETS, Preset, STAGES, SensorConfig, SensorModel, StageSpec};
use rayon::prelude::*;

use self::bench::{Shown, Variant};
use crate::outputs::write_file;
use crate::pages::hand_scene;
use crate::progress::{bar, say};
use crate::sensor_source;
use evpose_report::chart::{self, Chart, Series};
use evpose_report::html::{HtmlPage, escape};
use evpose_report::png::png;

/// Planes of the hand, one a millisecond.
const PLANES: usize = 151;

const STYLE: &str = "<style>
.strip{display:flex;flex-wrap:wrap;gap:10px;margin:8px 0}
.strip figure{margin:0;width:272px}.strip img{display:block;width:270px}
.strip svg{border:1px solid var(--line);background:#fff}
.facts{display:grid;grid-template-columns:max-content 1fr;gap:1px 14px;margin:4px 0 8px;font-size:14px}
.facts b{font-weight:600;color:var(--soft)}code{font-size:13px}
.domain{color:var(--soft);font-size:14px;font-weight:400;margin-left:8px}
.keys{font-size:13px;max-width:none}nav{columns:4;font-size:13px}nav a{display:block;color:inherit}
</style>";

/// Content of a row.
enum Entry {
    Preset(&'static Preset),
    Effect(&'static StageSpec),
}

impl Entry {
    fn name(&self) -> &'static str {
        match self {
            Self::Preset(preset) => preset.name,
            Self::Effect(spec) => spec.name,
        }
    }
}

/// Options of the gallery.
#[derive(Debug)]
pub struct GalleryOptions<'a> {
    /// The page to write.
    pub out: &'a Path,
    /// Names of presets and effects; empty for all.
    pub only: &'a [String],
    /// Scale of the image of the hand.
    pub scale: f32,
    /// Seed of the hand and of all noise.
    pub seed: u64,
}

/// Writes the gallery.
///
/// # Errors
/// If a name is not known, a sensor cannot be built, or the page cannot be written.
pub fn write(args: &GalleryOptions<'_>) -> Result<()> {
    let entries = chosen(args.only)?;
    let started = std::time::Instant::now();
    // All sensors are shown the very same light, which is rendered once.
    let hand = hand(args.scale, args.seed)?;
    let progress = bar("drawing", entries.len() as u64, "rows");
    let rows = entries
        // Collected in the order of entries, whichever is done first.
        .par_iter()
        .map(|entry| {
            let row = match entry {
                Entry::Preset(preset) => preset_row(preset, &hand, args.seed),
                Entry::Effect(spec) => effect_row(spec, &hand, args.seed),
            };
            progress.inc(1);
            row.with_context(|| entry.name())
        })
        .collect::<Result<Vec<String>>>()?;
    progress.finish_and_clear();
    let html = page(&entries, &rows);
    write_file(args.out, &html)?;
    say(format!(
        "{} rows in {:.0} s, {:.1} MB; written to {}",
        entries.len(),
        started.elapsed().as_secs_f64(),
        html.len() as f64 / 1e6,
        args.out.display()
    ));
    Ok(())
}

/// Presets and effects of these names; all of them where there are no names.
fn chosen(only: &[String]) -> Result<Vec<Entry>> {
    let all = || {
        let presets = PRESETS.iter().map(|preset| Entry::Preset(preset));
        presets.chain(STAGES.iter().map(|spec| Entry::Effect(spec)))
    };
    let names: Vec<&str> = all().map(|entry| entry.name()).collect();
    if let Some(name) = only.iter().find(|name| !names.contains(&name.as_str())) {
        bail!(sensor_source::unknown("preset or effect", name, &names));
    }
    let is_chosen = |entry: &Entry| only.is_empty() || only.iter().any(|n| n == entry.name());
    Ok(all().filter(is_chosen).collect())
}

/// The light that every chain is shown.
fn hand(scale: f32, seed: u64) -> Result<Vec<Plane<f32>>> {
    let progress = bar("rendering", PLANES as u64, "ms of a hand");
    let mut planes = Vec::with_capacity(PLANES);
    hand_scene::for_each_plane(scale, seed, PLANES, |plane, _| {
        planes.push(plane.clone());
        progress.inc(1);
        Ok(())
    })?;
    progress.finish_and_clear();
    Ok(planes)
}

fn page(entries: &[Entry], rows: &[String]) -> String {
    let mut page = HtmlPage::new(
        "Event cameras: presets and effects",
        "The same moving hand before every sensor and every effect of the catalogue. Events of 30 ms: \
         ON blue, OFF red, both violet, stronger where a pixel had more.",
    );
    page.markup(STYLE);
    let links = entries.iter().map(|entry| format!("<a href=\"#{0}\">{0}</a>", entry.name()));
    page.markup(&format!("<nav>{}</nav>", links.collect::<String>()));
    let mut domain = "";
    for (entry, row) in entries.iter().zip(rows) {
        let (heading, text) = match entry {
            Entry::Preset(_) => {
                ("presets", "Whole cameras and simulators, as lists of the effects below.")
            }
            Entry::Effect(spec) => (
                spec.domain.name(),
                "Each effect alone on the ideal sensor: without it, and at a weak, a typical and a \
                 strong setting, which are the ends and the middle of what is typical of cameras \
                 (quarters of the range where an effect is no property of a camera).",
            ),
        };
        // Entries come by domain: another one begins a section.
        if heading != domain {
            domain = heading;
            page.section(&heading.to_uppercase(), text);
        }
        page.markup(row);
    }
    page.finish()
}

fn preset_row(preset: &Preset, hand: &[Plane<f32>], seed: u64) -> Result<String> {
    let model = SensorModel::from_config(&SensorConfig::preset(preset.name)?)?;
    let stages = model.describe().rows.iter().filter(|row| row.is_active);
    let chain: Vec<&str> = stages.map(|row| row.spec.name).collect();
    let head = facts(&[
        ("origin", escape(&preset.origin())),
        ("chain", format!("<code>{}</code>", escape(&chain.join(" > ")))),
    ]);
    let image = hand_figure(&model, hand, seed, "")?;
    let rate = probe::hand_rate(&model, hand, seed)?;
    Ok(format!(
        "<h3 id=\"{0}\">{0}</h3>\n{head}<div class=\"strip\">{image}{1}</div>\n",
        preset.name,
        chart::svg(&rate, (540, 215))?
    ))
}

fn effect_row(spec: &'static StageSpec, hand: &[Plane<f32>], seed: u64) -> Result<String> {
    let mut known = vec![
        ("what", escape(spec.summary)),
        ("formula", format!("<code>{}</code>", escape(spec.formula))),
        ("source", escape(spec.source.text)),
        ("look for", escape(spec.signature.look_for)),
    ];
    if !spec.signature.beside.is_empty() {
        let beside = spec.signature.beside.join(", ");
        known.push(("beside", format!("{} (at typical values, in all columns)", escape(&beside))));
    }
    let head = format!(
        "<h3 id=\"{0}\">{0}<span class=\"domain\">{1}</span></h3>\n{2}",
        spec.name,
        spec.domain,
        facts(&known)
    );
    let variants = Variant::all(spec)?;
    // The ideal sensor is the only variant: maps of pixels have no typical values.
    if variants.len() == 1 {
        return Ok(head + "<p>Nothing to show without files of the user.</p>\n");
    }
    let mut strip = String::new();
    for variant in &variants {
        strip += &hand_figure(&variant.model, hand, seed, &variant.caption())?;
    }
    let measured = shown(probe::measure(spec.signature.probe, &variants, seed)?, &variants)?;
    Ok(format!("{head}<div class=\"strip\">{strip}</div>\n{measured}"))
}

fn facts(known: &[(&str, String)]) -> String {
    let lines = known.iter().map(|(name, fact)| format!("<b>{name}</b><span>{fact}</span>"));
    format!("<div class=\"facts\">{}</div>\n", lines.collect::<String>())
}

/// The last events of the hand as an image, with their counts.
fn hand_figure(
    model: &SensorModel,
    hand: &[Plane<f32>],
    seed: u64,
    caption: &str,
) -> Result<String> {
    let events = bench::watch(model, hand, seed)?;
    // Planes are a millisecond apart, and the first is at 0: these are the last 30 ms.
    let from = Micros((hand.len() as i64 - 31) * 1_000);
    let image = event_image::events(&events, bench::size_of(hand), from);
    // A sensor that starts in the dark has a burst at time zero.
    let later = || events.iter().filter(|event| event.t > Micros(0));
    let on = later().filter(|event| event.polarity.is_on()).count();
    let counts = format!("150 ms: {on} ON, {} OFF", later().count() - on);
    Ok(figure(&png(&image)?, &format!("{caption}{counts}")))
}

fn figure(png: &[u8], caption: &str) -> String {
    format!(
        "<figure><img alt=\"\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption>\
         </figure>\n",
        STANDARD.encode(png)
    )
}

/// A measurement as markup.
fn shown(measured: Shown, variants: &[Variant]) -> Result<String> {
    match measured {
        Shown::Nothing => Ok(String::new()),
        Shown::Images(what, images) => {
            let mut strip = String::new();
            for (image, variant) in images.iter().zip(variants) {
                strip += &figure(&png(image)?, &variant.caption());
            }
            Ok(format!("<p>{}</p><div class=\"strip\">{strip}</div>\n", escape(&what)))
        }
        Shown::Together(mut charts) => {
            // One key below all charts, each of which would repeat it.
            let key = charts.first().map(|chart| key(&chart.series)).unwrap_or_default();
            let series = charts.iter_mut().flat_map(|chart| &mut chart.series);
            series.for_each(|series| series.label.clear());
            Ok(format!("{}{key}", strip(&charts, (555, 270))?))
        }
        Shown::Each(charts) => strip(&charts, (270, 225)),
    }
}

fn strip(charts: &[Chart], size: (u32, u32)) -> Result<String> {
    let drawn =
        charts.iter().map(|chart| chart::svg(chart, size)).collect::<Result<String, _>>()?;
    Ok(format!("<div class=\"strip\">{drawn}</div>\n"))
}

/// Legend of a chart's colours.
fn key(series: &[Series]) -> String {
    let entries = series.iter().map(|Series { label, colour: (r, g, b), .. }| {
        format!("<i class=\"key\" style=\"background:rgb({r},{g},{b})\"></i>{}", escape(label))
    });
    format!("<p class=\"keys\">{}</p>\n", entries.collect::<String>())
}
