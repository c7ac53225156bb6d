//! The part of the gap that the corrected model leaves unexplained, and its location.

use evpose_gap::report::ReportData;
use evpose_gap::verdict::Answer;

use super::{explained, responses};
use crate::pages::gap::words;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::colour::Colour;
use evpose_report::drawing::DrawingError;
use evpose_report::format::percent;
use evpose_report::html::{HtmlPage, escape};

const LEFT: Colour = (163, 38, 46);

/// Section on what is left.
pub(crate) fn unexplained(page: &mut HtmlPage, data: &ReportData) -> Result<(), DrawingError> {
    let left = &data.verdict.unexplained;
    if data.verdict.verdict == Answer::NoGap || left.sentence.is_empty() {
        return Ok(());
    }
    page.section("Unexplained", &explained::left_in_words(&data.verdict));
    if left.is_significant && !left.nearest_stage.is_empty() {
        page.markup(&format!(
            "<p>Of the parts of a camera, effects of the <b>{}</b> come closest to it.</p>",
            escape(&left.nearest_stage)
        ));
    }
    page.markup(&format!("<p class=\"say\">{}</p>", escape(&left.sentence)));
    let after = data.after.as_ref().filter(|_| left.is_significant);
    let responses = after.map_or(&[][..], |after| &after.responses);
    responses::responses(page, responses)?;
    let mut shares: Vec<(&String, f64)> =
        left.shares.iter().map(|(axis, share)| (axis, *share)).collect();
    if shares.is_empty() {
        return Ok(());
    }
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let bar = |(axis, share): (&String, f64)| Bar {
        label: words::axis(axis),
        value: share,
        interval: None,
        colour: LEFT,
        note: percent(share),
    };
    let bars: Vec<Bar> = shares.into_iter().map(bar).collect();
    page.markup(&format!(
        "<h3>What is left, distinguished by</h3>{}",
        bars::svg(&bars, &Along::shares())?
    ));
    Ok(())
}
