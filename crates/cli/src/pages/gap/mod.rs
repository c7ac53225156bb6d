//! The report of a gap: one page with the answer, what it rests on, and what would overturn it.

mod closing;
mod curves;
mod diff;
#[cfg(test)]
pub(crate) mod example;
mod explained;
mod explanation;
pub mod files;
mod maps;
mod matrix;
mod place;
mod responses;
mod sections;
mod side_by_side;
pub mod terminal;
#[cfg(test)]
mod tests;
mod unexplained;
pub mod words;
mod wrapped;

use std::path::{Path, PathBuf};

use anyhow::Result;
use evpose_gap::report::ReportData;
use evpose_gap::verdict::Answer;

use evpose_report::colour::{Colour, css};
use evpose_report::format::percent;
use evpose_report::html::{HtmlPage, escape};

use crate::outputs::write_file;

/// Colours of what was measured, of the model as given, and of the corrected model.
const MEASURED: Colour = (29, 36, 48);
const MODEL: Colour = (150, 157, 170);
const CORRECTED: Colour = (0, 138, 104);

const STYLE: &str = "<style>
.verdict{border-radius:10px;padding:18px 22px;margin:14px 0;color:#fff}
.verdict h2{margin:0 0 6px;font-size:23px}.verdict p{margin:0;max-width:86ch;font-size:16px}
.cards{display:flex;flex-wrap:wrap;gap:10px;margin:12px 0}
.card{border:1px solid var(--line);background:#fff;border-radius:8px;padding:8px 14px;min-width:150px}
.card b{display:block;font-size:20px}.card span{color:var(--soft);font-size:13px}
.row{display:flex;flex-wrap:wrap;gap:22px;align-items:flex-start}
.row>div{min-width:0}h3{font-size:15px;margin:16px 0 4px}
svg{max-width:100%;height:auto}svg text{font-family:system-ui,sans-serif}
.say{border-left:4px solid var(--line);padding:2px 0 2px 12px;margin:8px 0;max-width:92ch}
.wrap td{white-space:normal;text-align:left;vertical-align:top}.wrap th{white-space:normal;text-align:left;vertical-align:bottom}
.scroll{max-height:420px;overflow:auto;border:1px solid var(--line);background:#fff;padding:0 10px}
.sort th{cursor:pointer}figure{margin:6px 0}
pre.diff{max-width:92ch}pre.diff .add{color:#00704f;background:#e2f4ec;display:block}
pre.diff .del{color:#a3262e;background:#fbe8e8;display:block}pre.diff span{display:block}
.sequence{image-rendering:pixelated;background-repeat:no-repeat;border:1px solid var(--line)}
.sequence:hover{animation-play-state:paused}
@media (prefers-reduced-motion:reduce){.sequence{animation:none!important}}
.names{display:grid;font-size:13px;color:var(--soft)}
.plots figure{margin:0;width:366px}figure.map{width:330px}
.halo{paint-order:stroke;stroke:#fcfcfd;stroke-width:3px}
.sort td:nth-child(2),.sort th:nth-child(2){text-align:left}
</style>";

/// Clicking on a heading sorts the rows below it, the largest first.
const SORT: &str = "<script>document.querySelectorAll('.sort th').forEach(th=>th.onclick=()=>{\
const i=th.cellIndex,t=th.closest('table'),r=[...t.rows].slice(1),\
n=x=>parseFloat(x.cells[i].textContent),v=x=>isNaN(n(x))?-1:Math.abs(n(x));\
const words=r.every(x=>isNaN(n(x)));\
r.sort((a,b)=>words?a.cells[i].textContent.localeCompare(b.cells[i].textContent):v(b)-v(a))\
.forEach(x=>x.parentNode.appendChild(x))})</script>";

/// Draws `DIR/report.html`.
pub fn write(dir: &Path, data: &ReportData) -> Result<PathBuf> {
    let path = dir.join("report.html");
    write_file(&path, page(data)?)?;
    Ok(path)
}

fn page(data: &ReportData) -> Result<String> {
    let (title, about) = match data.verdict.is_scene_free() {
        true => (
            "A recording alone",
            "What its events say of the camera without a scene, and what they do not.",
        ),
        false => (
            "Simulated against measured events",
            "Where they disagree, what is missing in the model, and what is left when it is added.",
        ),
    };
    let mut page = HtmlPage::new(title, about);
    page.markup(STYLE);
    banner(&mut page, data);
    explanation::explanation(&mut page, data)?;
    closing::findings(&mut page, data);
    unexplained::unexplained(&mut page, data)?;
    place::place(&mut page, data)?;
    closing::closing(&mut page, data)?;
    curves::curves(&mut page, data)?;
    side_by_side::section(&mut page, data)?;
    sections::alternatives(&mut page, data)?;
    sections::limits(&mut page, data);
    sections::doubts(&mut page, data);
    sections::statistics(&mut page, data);
    sections::origin(&mut page, data);
    page.markup(SORT);
    Ok(page.finish())
}

/// The answer in a colour, and its figures.
fn banner(page: &mut HtmlPage, data: &ReportData) {
    let verdict = &data.verdict;
    let colour = match verdict.verdict {
        Answer::NoGap => "#0a7d56",
        Answer::Parameter => "#8a6100",
        Answer::Effects => "#1d5fae",
        Answer::Partial => "#6b4fa3",
        Answer::NoneOfCatalogue => "#a3262e",
        Answer::Undecided => "#59616f",
    };
    page.markup(&format!(
        "<div class=\"verdict\" style=\"background:{colour}\"><h2>{}</h2><p>{}</p></div>",
        escape(&words::headline(verdict)),
        escape(&words::meaning(verdict))
    ));
    if verdict.is_out_of_time {
        page.markup(&format!("<p class=\"say\"><b>{}</b></p>", escape(words::OUT_OF_TIME)));
    }
    for correction in &verdict.corrections {
        page.markup(&format!("<p class=\"say\">Input corrected: {}</p>", escape(correction)));
    }
    if !verdict.next.is_empty() {
        page.markup(&format!("<p class=\"say\">Next: {}</p>", escape(&verdict.next)));
    }
    // A comparison without a scene, or without its light, says so in its first note.
    if let Some(mode) = verdict.notes.first().filter(|note| note.starts_with("mode ")) {
        page.markup(&format!("<p class=\"say\">{}</p>", escape(mode)));
    }
    let mut cards = Vec::new();
    if verdict.is_scene_free() {
        cards.push((verdict.effects.len().to_string(), "effects found without a scene"));
        cards.push((verdict.untestable.len().to_string(), "effects not testable without one"));
    } else {
        cards.push((words::gap(&verdict.gap_before), "gap of the model as given"));
    }
    if !verdict.effects.is_empty() && !verdict.is_scene_free() {
        cards.push((words::gap(&verdict.gap_after), "gap of the corrected model"));
        cards.push((words::closed(verdict), "of the discrepancy closed"));
    }
    if explained::has_fractions(verdict) {
        let text = match verdict.unexplained.is_significant {
            true => "unexplained, significant",
            false => "unexplained, not significant",
        };
        cards.push((percent(verdict.unexplained.fraction), text));
    }
    cards.push((words::probability(verdict.p), "that runs of the model as given deviate as far"));
    if let Some(after) = verdict.c2st_after.or(verdict.c2st_before) {
        let before = verdict.c2st_before.filter(|_| verdict.c2st_after.is_some());
        let from = before.map_or_else(String::new, |before| format!("{:.2} to ", before.auc));
        let text = "AUC of a classifier; 0.5 is chance";
        cards.push((format!("{from}{:.2}", after.auc), text));
    }
    let card = |(number, text): &(String, &str)| {
        format!("<div class=\"card\"><b>{}</b><span>{text}</span></div>", escape(number))
    };
    let cards: String = cards.iter().map(card).collect();
    page.markup(&format!("<div class=\"cards\">{cards}</div>"));
    if let Some(separated) = words::separated(verdict).filter(|_| !verdict.effects.is_empty()) {
        page.markup(&format!("<p class=\"say\">{}.</p>", escape(&separated)));
    }
    if !verdict.is_scene_free() {
        let all = words::DEFINITIONS.join(" ");
        page.markup(&format!("<p class=\"soft\">{}</p>", escape(&all)));
    }
}

/// Colours and what they are.
fn key(page: &mut HtmlPage, names: &[(&str, Colour)]) {
    let one = |(name, colour): &(&str, Colour)| {
        format!("<span class=\"key\" style=\"background:{}\"></span>{}", css(*colour), escape(name))
    };
    page.markup(&format!("<p class=\"soft\">{}</p>", names.iter().map(one).collect::<String>()));
}
