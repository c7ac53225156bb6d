//! The sections of the page, in order.

use anyhow::Result;
use evpose_gap::report::{Change, Plot, ReportData, Scale};
use evpose_gap::verdict::FindingKind;

use super::bars::{self, Along, Bar};
use super::diff::{Line, diff};
use super::{CORRECTED, MEASURED, MODEL, css, maps, matrix};
use crate::commands::gap::words::{self, percent, short};
use crate::report::chart::{self, Axis, Chart, Mark, Series};
use crate::report::html::{Page, escape};

/// Size of a curve, pixels.
const PLOT: (u32, u32) = (366, 245);
/// Numbers and pixels that are listed.
const ROWS: usize = 400;
const PIXELS: usize = 12;
/// Candidates that are drawn.
const RANKED: usize = 16;

/// What was found, with its numbers.
pub(super) fn findings(page: &mut Page, data: &ReportData) {
    let verdict = &data.verdict;
    if verdict.effects.is_empty() {
        return;
    }
    page.section(
        "What is missing or set wrong",
        "Intervals hold the true value in nine of ten cases.",
    );
    let rows: Vec<Vec<String>> = verdict
        .effects
        .iter()
        .map(|finding| {
            let kind = match finding.kind {
                FindingKind::Effect => "effect",
                FindingKind::Parameter => "number of the model",
            };
            let numbers: Vec<String> = finding
                .parameters
                .iter()
                .map(|(name, value)| escape(&format!("{name} = {}", words::quantity(value))))
                .collect();
            let alike = match finding.confusable_with.is_empty() {
                true => "nothing".to_owned(),
                false => escape(&finding.confusable_with.join(", ")),
            };
            vec![
                format!("<b>{}</b><br><small>{kind}</small>", escape(&finding.name)),
                escape(words::summary(&finding.name).unwrap_or_default()),
                numbers.join("<br>"),
                short(finding.probability),
                alike,
            ]
        })
        .collect();
    let header = ["name", "what it does", "numbers", "probability", "here not to be told from"];
    wrapped_table(page, &header, &rows);
}

/// Where measured and simulated events disagree.
pub(super) fn place(page: &mut Page, data: &ReportData) -> Result<()> {
    let before = &data.before;
    if data.verdict.place.sentence.is_empty() && before.scan.sentence.is_empty() {
        return Ok(());
    }
    page.section(
        "Where they disagree",
        "Regions in which the model has too many or too few events, each beyond what those before it \
         explain, with the ratio of measured to simulated events.",
    );
    let sentences: Vec<String> = match before.scan.regions.is_empty() {
        true => vec![data.verdict.place.sentence.clone()],
        false => before.scan.regions.iter().map(|region| region.sentence.clone() + ".").collect(),
    };
    for sentence in sentences {
        page.markup(&format!("<p class=\"say\">{}</p>", escape(&sentence)));
    }
    let shares = |shares: Vec<(String, f64)>| {
        let bar = |(label, value): (String, f64)| Bar {
            label,
            value,
            interval: None,
            colour: MEASURED,
            note: percent(value),
        };
        bars::svg(&shares.into_iter().map(bar).collect::<Vec<_>>(), &Along::shares())
    };
    let mut columns = String::new();
    let mut axes: Vec<(String, f64)> = match before.attribution.is_significant() {
        true => {
            before.attribution.explained.iter().map(|e| (words::axis(&e.axis), e.share)).collect()
        }
        false => data.verdict.place.shares.iter().map(|(a, s)| (words::axis(a), *s)).collect(),
    };
    axes.sort_by(|a, b| b.1.total_cmp(&a.1));
    if !axes.is_empty() {
        columns += &format!("<div><h3>Told apart by</h3>{}</div>", shares(axes));
    }
    let mut stages: Vec<(String, f64)> = data.verdict.stage_shares.clone().into_iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    if !stages.is_empty() {
        columns +=
            &format!("<div><h3>Part of the camera that does so</h3>{}</div>", shares(stages));
    }
    let first = maps::figure(&before.maps, "Model as given")?;
    let after = match &data.after {
        Some(after) => maps::figure(&after.maps, "Corrected model")?,
        None => String::new(),
    };
    page.markup(&format!(
        "<div class=\"row\">{columns}</div><div class=\"row\">{first}{after}{}</div>",
        pixels(data)
    ));
    if !first.is_empty() {
        page.markup(
            "<p class=\"soft\">Orange: more events measured than simulated; blue: fewer; pale: chance \
             does the same. Of what is called significant, one in twenty may be chance.</p>",
        );
    }
    Ok(())
}

/// Pixels that stand out.
fn pixels(data: &ReportData) -> String {
    let pixels = &data.before.maps.pixels;
    if pixels.is_empty() {
        return String::new();
    }
    let row = |pixel: &evpose_gap::locate::OddPixel| {
        format!(
            "<tr><td>{}, {}</td><td>{:.0}</td><td>{}</td><td>{:+.1}</td></tr>",
            pixel.x,
            pixel.y,
            pixel.measured,
            short(pixel.expected),
            pixel.z
        )
    };
    let rows: String = pixels.iter().take(PIXELS).map(row).collect();
    let title = match pixels.len() > PIXELS {
        true => format!("The {PIXELS} oddest pixels"),
        false => "Odd pixels".to_owned(),
    };
    format!(
        "<div><h3>{title}</h3><table><tr><th>x, y</th><th>measured</th><th>model</th><th>sd</th></tr>\
         {rows}</table></div>"
    )
}

/// Gaps before and after, and what taking the answer back does.
pub(super) fn closing(page: &mut Page, data: &ReportData) {
    let interval = |gap: &evpose_gap::verdict::GapValue| Some((gap.lo, gap.hi));
    if !data.ablation.is_empty() {
        page.section(
            "Put in, taken out, exchanged",
            "If the answer is right, the gap closes with it, opens again without it, and stays open \
             with the nearest other effect in its place.",
        );
        let largest = data.ablation.iter().map(|row| row.gap.hi).fold(1.0, f64::max);
        let bar = |row: &evpose_gap::report::Ablation| Bar {
            label: words::change(row),
            value: row.gap.value,
            interval: interval(&row.gap),
            colour: match row.change {
                Change::Added => CORRECTED,
                Change::None | Change::TakenOut => MODEL,
                Change::Exchanged => (214, 140, 60),
            },
            note: words::gap(&row.gap),
        };
        let bars: Vec<Bar> = data.ablation.iter().map(bar).collect();
        page.markup(&bars::svg(&bars, &Along { labels: 260.0, ..Along::gap(largest) }));
    }
    if data.blocks.is_empty() {
        return;
    }
    page.section(
        "The gap by what is measured",
        "1 is the gap between two runs of one model. All on the part of the recording that was held \
         out.",
    );
    key(page, &[("model as given", MODEL), ("corrected", CORRECTED)]);
    let largest = data.blocks.iter().map(|row| row.before.hi.max(row.after.hi)).fold(1.0, f64::max);
    let has_after = !data.verdict.effects.is_empty();
    let mut bars = Vec::new();
    for row in &data.blocks {
        let bar = |label: &str, gap: &evpose_gap::verdict::GapValue, colour| Bar {
            label: label.to_owned(),
            value: gap.value,
            interval: interval(gap),
            colour,
            note: short(gap.value),
        };
        bars.push(bar(words::block(row.block), &row.before, MODEL));
        if has_after {
            bars.push(bar("", &row.after, CORRECTED));
        }
    }
    page.markup(&bars::svg(&bars, &Along::gap(largest)));
}

/// Colours and what they are.
fn key(page: &mut Page, names: &[(&str, (u8, u8, u8))]) {
    let one = |(name, colour): &(&str, (u8, u8, u8))| {
        format!("<span class=\"key\" style=\"background:{}\"></span>{}", css(*colour), escape(name))
    };
    page.markup(&format!("<p class=\"soft\">{}</p>", names.iter().map(one).collect::<String>()));
}

/// Curves in which effects are seen.
pub(super) fn curves(page: &mut Page, data: &ReportData) -> Result<()> {
    if data.plots.is_empty() {
        return Ok(());
    }
    page.section(
        "Curves",
        "Where the black curve leaves the grey band, the model as given is wrong; the corrected model \
         should follow the black curve.",
    );
    let mut names = vec![("measured", MEASURED), ("runs of the model as given", MODEL)];
    if data.plots.iter().any(|plot| !plot.corrected.is_empty()) {
        names.push(("corrected model", CORRECTED));
    }
    key(page, &names);
    let mut plots = Vec::new();
    for plot in &data.plots {
        plots.push(format!(
            "<figure>{}<figcaption>{}</figcaption></figure>",
            chart::svg(&curve(plot), PLOT)?,
            escape(&plot.caption)
        ));
    }
    page.plots(&plots);
    Ok(())
}

fn curve(plot: &Plot) -> Chart {
    let axis = |name: &str, scale: Scale| match scale {
        Scale::Linear => Axis::new(name),
        Scale::Log => Axis::log(name),
    };
    let along = |values: &[f64]| -> Vec<(f64, f64)> {
        plot.x.iter().copied().zip(values.iter().copied()).collect()
    };
    let series = |colour, mark, points| Series { label: String::new(), colour, mark, points };
    // Classes are numbered from one on.
    let is_whole = plot.x.first() == Some(&1.0) && plot.x.iter().all(|x| x.fract() == 0.0);
    let known = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().filter(|(_, y)| y.is_finite()).collect()
    };
    let mut band = known(along(&plot.low));
    band.extend(known(along(&plot.high)).into_iter().rev());
    let mut all = vec![series(MODEL, Mark::Band, band)];
    if !plot.corrected.is_empty() {
        all.push(series(CORRECTED, Mark::Line, known(along(&plot.corrected))));
    }
    all.push(series(MEASURED, Mark::Line, known(along(&plot.measured))));
    Chart {
        title: plot.title.clone(),
        x: if is_whole {
            axis(&plot.x_name, plot.x_scale).whole()
        } else {
            axis(&plot.x_name, plot.x_scale)
        },
        y: axis(&plot.y_name, plot.y_scale),
        series: all,
    }
}

/// Everything else that was tried, and what looks alike.
pub(super) fn alternatives(page: &mut Page, data: &ReportData) {
    let told: Vec<String> = data.verdict.effects.iter().map(|f| f.name.clone()).collect();
    if !data.candidates.is_empty() {
        page.section(
            "Everything that was tried",
            "Misfit of the model with each effect of the catalogue in turn, its strength and the numbers \
             of the model fitted to it: the smaller, the better it explains the recording. Pale: tried \
             at a few strengths only, because others did better.",
        );
        let largest = data.candidates.iter().map(|c| c.misfit).fold(0.0, f64::max);
        let largest = data.misfit_without.unwrap_or(0.0).max(largest);
        let bar = |candidate: &evpose_gap::report::Ranked| Bar {
            label: candidate.name.clone(),
            value: candidate.misfit,
            interval: candidate.error.map(|e| (candidate.misfit - e, candidate.misfit + e)),
            colour: match (told.contains(&candidate.name), candidate.is_fitted) {
                (true, _) => CORRECTED,
                (false, true) => MODEL,
                (false, false) => (214, 218, 226),
            },
            note: short(candidate.misfit),
        };
        let bars: Vec<Bar> = data.candidates.iter().take(RANKED).map(bar).collect();
        let along = Along {
            name: "misfit",
            range: (0.0, 1.08 * largest),
            is_log: false,
            mark: data.misfit_without.map(|misfit| (misfit, "with no effect")),
            ..Along::gap(largest)
        };
        page.markup(&bars::svg(&bars, &along));
        if data.candidates.len() > RANKED {
            let rest = data.candidates[RANKED..].iter();
            let rest: Vec<String> =
                rest.map(|c| format!("{}: misfit {}", c.name, short(c.misfit))).collect();
            page.details(&format!("{} more", rest.len()), &rest.join("\n"));
        }
    }
    if !data.confusability.names.is_empty() {
        let alike = matrix::alike(&data.confusability);
        let alike = match alike.is_empty() {
            true => "No two effects look the same in this recording.".to_owned(),
            false => format!("Not to be told apart here: {}.", alike.join("; ")),
        };
        page.section(
            "What looks alike in this recording",
            &format!(
                "Dark where two effects change the same numbers in the same proportion (cosine of the \
                 angle between what they do, in percent from 80 on). {alike}"
            ),
        );
        page.markup(&matrix::svg(&data.confusability, &told));
    }
}

/// What would not have been seen.
pub(super) fn limits(page: &mut Page, data: &ReportData) {
    let verdict = &data.verdict;
    if verdict.limits.is_empty() && verdict.untestable.is_empty() {
        return;
    }
    page.section(
        "What would have shown, and what would not",
        "The least strength at which each effect would have been seen in this recording, and effects \
         of which it says nothing.",
    );
    let rows: Vec<Vec<String>> = verdict
        .limits
        .iter()
        .map(|limit| {
            let value = format!("{} {}", short(limit.value), limit.unit);
            vec![escape(&limit.name), escape(&limit.parameter), escape(value.trim_end())]
        })
        .collect();
    let untestable: Vec<Vec<String>> = verdict
        .untestable
        .iter()
        .map(|(name, reason)| vec![escape(name), escape(reason)])
        .collect();
    page.markup("<div class=\"row\"><div>");
    if !rows.is_empty() {
        page.table(&["effect", "number", "shows from"], &rows);
    }
    page.markup("</div><div>");
    if !untestable.is_empty() {
        wrapped_table(page, &["untestable here", "why"], &untestable);
    }
    page.markup("</div></div>");
}

/// What would overturn the answer.
pub(super) fn doubts(page: &mut Page, data: &ReportData) {
    let verdict = &data.verdict;
    if !verdict.remaining.sentence.is_empty() {
        page.section("What is left", "");
        let state = match verdict.remaining.is_significant {
            true => {
                format!("Something is left, nearest to the {}: ", verdict.remaining.nearest_stage)
            }
            false => "Nothing significant is left. ".to_owned(),
        };
        page.markup(&format!(
            "<p class=\"say\">{}</p>",
            escape(&(state + &verdict.remaining.sentence))
        ));
    }
    if data.doubts.is_empty() && verdict.notes.is_empty() {
        return;
    }
    page.section(
        "How could this be wrong?",
        "What the answer rests on, and what would show that it does not hold.",
    );
    let rows: Vec<Vec<String>> = data
        .doubts
        .iter()
        .map(|doubt| vec![escape(&doubt.assumption), escape(&doubt.overturned_by)])
        .collect();
    if !rows.is_empty() {
        wrapped_table(page, &["it is assumed that", "what would overturn it"], &rows);
    }
    if !verdict.notes.is_empty() {
        let notes: String =
            verdict.notes.iter().map(|note| format!("<li>{}</li>", escape(note))).collect();
        page.markup(&format!("<h3>Noticed about the inputs</h3><ul>{notes}</ul>"));
    }
}

/// Every number that was compared.
pub(super) fn numbers(page: &mut Page, data: &ReportData) {
    if data.probes.is_empty() {
        return;
    }
    page.section(
        "Every number that was compared",
        "In standard deviations from what runs of the model give, and, for counts, relative to it. \
         Click on a heading to sort.",
    );
    let rows: String = data
        .probes
        .iter()
        .take(ROWS)
        .map(|row| {
            let relative =
                row.relative.map_or_else(|| "-".to_owned(), |r| format!("{:+.0}%", 100.0 * r));
            format!(
                "<tr><td>{}</td><td>{}</td><td>{:+.1}</td><td>{:+.1}</td><td>{relative}</td></tr>",
                words::block(row.block),
                escape(&row.name),
                row.before,
                row.after
            )
        })
        .collect();
    page.markup(&format!(
        "<div class=\"scroll\"><table class=\"sort\"><tr><th>block</th><th>number</th><th>sd before</th>\
         <th>sd after</th><th>measured over model</th></tr>{rows}</table></div>"
    ));
    if data.probes.len() > ROWS {
        page.markup(&format!(
            "<p class=\"soft\">The {ROWS} that differ most of {}.</p>",
            data.probes.len()
        ));
    }
}

/// The models, and where everything comes from.
pub(super) fn origin(page: &mut Page, data: &ReportData) {
    if !data.model_before.is_empty() {
        page.section("The model before and after", "");
        let lines: String = diff(&data.model_before, &data.model_after)
            .into_iter()
            .map(|line| match line {
                Line::Same(text) => format!("<span>  {}</span>", escape(text)),
                Line::Taken(text) => format!("<span class=\"del\">- {}</span>", escape(text)),
                Line::Added(text) => format!("<span class=\"add\">+ {}</span>", escape(text)),
            })
            .collect();
        page.markup(&format!("<pre class=\"diff\">{lines}</pre>"));
    }
    if !data.provenance.is_empty() {
        page.section("Provenance", "");
        let rows: Vec<Vec<String>> = data
            .provenance
            .iter()
            .map(|fact| vec![escape(&fact.name), escape(&fact.value)])
            .collect();
        wrapped_table(page, &["", ""], &rows);
    }
}

/// A table of text rather than of numbers.
fn wrapped_table(page: &mut Page, header: &[&str], rows: &[Vec<String>]) {
    page.markup("<div class=\"wrap\">");
    page.table(header, rows);
    page.markup("</div>");
}
