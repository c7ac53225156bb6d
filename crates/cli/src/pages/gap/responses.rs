//! Laws of what is left: excess or deficit as a function of light, its change, time and place.

use evpose_gap::locate::{Response, ResponseForm};

use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::Colour;
use evpose_report::drawing::DrawingError;
use evpose_report::html::{HtmlPage, escape};

/// Size of a chart, pixels.
const PLOT: (u32, u32) = (366, 245);
const DIFFERENCE: Colour = (20, 20, 20);
const LAW: Colour = (163, 38, 46);

/// Charts of responses with their laws in words; nothing where there are none.
pub(super) fn responses(page: &mut HtmlPage, all: &[Response]) -> Result<(), DrawingError> {
    if all.is_empty() {
        return Ok(());
    }
    page.markup(
        "<h3>The response that would explain it</h3><p>Dots: measured minus expected events along one \
         property. Red: the law that describes them best. Properties go together in a scene, so that \
         several may describe the same difference; the first removes most of it.</p>",
    );
    let mut plots = Vec::new();
    for response in all {
        let caption = format!(
            "{}: {:.0} % of the squared differences along it.",
            response.sentence(),
            100.0 * response.explained
        );
        plots.push(format!(
            "<figure>{}<figcaption>{}</figcaption></figure>",
            chart::svg(&drawn(response), PLOT)?,
            escape(&caption)
        ));
    }
    page.plots(&plots);
    Ok(())
}

fn drawn(response: &Response) -> Chart {
    let property = response.property;
    let name = format!("{} ({})", property.name(), property.unit());
    // A point at 0 has no place on a logarithmic axis.
    let is_log = property.is_logarithmic() && response.points.iter().all(|point| point.x > 0.0);
    let differences = response.points.iter().filter_map(|p| Some((p.x, p.difference?))).collect();
    let fitted = response.points.iter().map(|point| (point.x, point.fitted)).collect();
    let series = |mark, colour, points| Series { label: String::new(), colour, mark, points };
    Chart {
        title: format!("{} events", if response.is_on { "ON" } else { "OFF" }),
        x: if is_log { ChartAxis::log(&name) } else { ChartAxis::new(&name) },
        y: ChartAxis::new(match response.fit.form {
            ResponseForm::Rate => "excess, events per pixel and second",
            ResponseForm::Fraction => "excess, fraction of the expected",
        })
        .from_zero(),
        // Points last, so that they lie over the law.
        series: vec![series(Mark::Line, LAW, fitted), series(Mark::Discs, DIFFERENCE, differences)],
    }
}
