//! Curves of the measured recording, of the model, and of the corrected model.

use anyhow::Result;
use evpose_gap::report::{AxisScale, Plot, ReportData};

use super::{CORRECTED, MEASURED, MODEL, key};
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::html::{HtmlPage, escape};

/// Size of a curve, pixels.
const PLOT: (u32, u32) = (366, 245);

/// Curves in which effects are seen.
pub(crate) fn curves(page: &mut HtmlPage, data: &ReportData) -> Result<()> {
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
    let axis = |name: &str, scale: AxisScale| match scale {
        AxisScale::Linear => ChartAxis::new(name),
        AxisScale::Log => ChartAxis::log(name),
    };
    let along = |values: &[f64]| -> Vec<(f64, f64)> {
        plot.x.iter().copied().zip(values.iter().copied()).collect()
    };
    let series = |colour, mark, points| Series { label: String::new(), colour, mark, points };
    // Classes are numbered from one on.
    let is_whole = plot.x.first() == Some(&1.0) && plot.x.iter().all(|x| x.fract() == 0.0);
    // Bins without events have no value: lines go on over them.
    let known = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().filter(|(_, y)| y.is_finite()).collect()
    };
    let mut band = known(along(&plot.low));
    band.extend(known(along(&plot.high)).into_iter().rev());
    // A narrow band is no more than a line.
    let middle: Vec<f64> = plot.low.iter().zip(&plot.high).map(|(a, b)| 0.5 * (a + b)).collect();
    let middle = known(along(&middle));
    let mut all = vec![series(MODEL, Mark::Band, band), series(MODEL, Mark::Line, middle)];
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
