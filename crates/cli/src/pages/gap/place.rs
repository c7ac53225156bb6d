//! Location of the disagreement of measured and simulated events: sentences, shares and maps.

use anyhow::Result;
use evpose_gap::locate::OddPixel;
use evpose_gap::report::ReportData;

use super::{MEASURED, maps};
use crate::pages::gap::words;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::format::{percent, short};
use evpose_report::html::{HtmlPage, escape};

const PIXELS: usize = 12;

/// Section on the location of the disagreement.
pub(crate) fn place(page: &mut HtmlPage, data: &ReportData) -> Result<()> {
    let before = &data.before;
    if data.verdict.place.sentence.is_empty() && before.scan.sentence.is_empty() {
        return Ok(());
    }
    page.section(
        "Where they disagree",
        "Regions in which the model has too many or too few events, each beyond what those before it \
         explain, with the ratio of measured to simulated events.",
    );
    // Regions are the finer answer.
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
    // The largest share first: that is what a reader looks for.
    axes.sort_by(|a, b| b.1.total_cmp(&a.1));
    if !axes.is_empty() {
        columns += &format!("<div><h3>Distinguished by</h3>{}</div>", shares(axes)?);
    }
    let mut stages: Vec<(String, f64)> = data.verdict.stage_shares.clone().into_iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    if !stages.is_empty() {
        columns += &format!(
            "<div><h3>Part of the camera: of what is named, and nearest to what is left</h3>{}</div>",
            shares(stages)?
        );
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
        page.markup(&format!(
            "<p class=\"soft\">Orange: more events measured than simulated; blue: fewer; of full colour \
             from {} standard deviations on; pale: chance does the same. Of places that are called \
             significant, one in twenty may be chance; a region is named at one in a hundred.</p>",
            maps::FULL
        ));
    }
    Ok(())
}

/// Pixels that stand out.
fn pixels(data: &ReportData) -> String {
    let pixels = &data.before.maps.pixels;
    if pixels.is_empty() {
        return String::new();
    }
    let row = |pixel: &OddPixel| {
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
