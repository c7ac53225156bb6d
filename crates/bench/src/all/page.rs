//! The page: a table of all figures, speed beside peers, and the roofline of the networks' layers.

use anyhow::Result;
use evpose_report::bars::{self, Along, Bar};
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{Colour, palette};
use evpose_report::html::{HtmlPage, escape};

use super::figure::{Figure, threads};
use super::limits::MachineLimits;
use super::stored::StoredRun;
use crate::infer::MeasuredLayers;

const SLOWER: Colour = (190, 194, 203);
/// Size of a roofline, pixels.
const ROOFLINE: (u32, u32) = (550, 380);
/// Operations per byte over which a roof is drawn.
const INTENSITIES: (f64, f64) = (0.25, 256.0);

/// The page as one HTML document.
pub(crate) fn html(
    run: &StoredRun,
    layers: &[MeasuredLayers],
    before: Option<&StoredRun>,
) -> Result<String> {
    let machine = &run.provenance.machine;
    let mut page = HtmlPage::new(
        "Speed",
        &format!(
            "evpose bench all, {}, {} threads, {}, commit {}",
            machine.cpu, machine.threads, machine.system, run.provenance.commit
        ),
    );
    let limits: Vec<String> = run.limits.iter().map(limit_text).collect();
    page.section("Limits of the machine", &limits.join(" "));

    page.section(
        "Beside peers",
        "Speed of ours relative to programs that did the same work in the same run, interleaved. Right of the \
         line ours is the faster.",
    );
    match beside_peers(&run.figures)? {
        Some(chart) => page.plots(&[chart]),
        None => page.markup(
            "<p>No peer was found. A program built with <code>--features peers</code> times other runtimes: \
             <code>evpose bench infer --help</code>.</p>",
        ),
    }

    if !layers.is_empty() {
        rooflines(&mut page, run, layers)?;
    }

    page.section(
        "All figures",
        "The limit of a network is its arithmetic as defined at the peak of the machine.",
    );
    let mut header =
        vec!["benchmark", "work", "ours", "unit", "limit", "peers (ours: times as fast)"];
    if before.is_some() {
        header.push("since before");
    }
    let rows: Vec<_> = run.figures.iter().map(|figure| row(figure, before)).collect();
    page.table(&header, &rows);
    Ok(page.finish())
}

/// The section with a roofline for each network and number of threads.
fn rooflines(page: &mut HtmlPage, run: &StoredRun, layers: &[MeasuredLayers]) -> Result<()> {
    page.section(
        "Roofline of the networks",
        "Each point is a layer: the arithmetic of the layer as defined, over its bytes of weights, inputs and \
         output, each moved once. The roof is memory bandwidth on the left and multiply-adds on the right, both \
         measured. Winograd's algorithm needs fewer multiplications, so its layers may be above the roof; \
         layers whose values are in a cache may be above its slope.",
    );
    let rooflines = layers.iter().filter_map(|layers| {
        let limits = run.limits.iter().find(|limits| limits.threads == layers.threads)?;
        Some(roofline(layers, limits))
    });
    page.plots(&rooflines.collect::<Result<Vec<_>>>()?);
    Ok(())
}

fn limit_text(limits: &MachineLimits) -> String {
    format!(
        "{}: {:.0} GFLOP/s of fused multiply-adds in f32, {:.1} GB/s copied in memory; arithmetic is the \
         limit from {:.1} operations per byte on.",
        threads(limits.threads),
        limits.peak_gflop_per_s,
        limits.bandwidth_gb_per_s,
        limits.ridge()
    )
}

fn row(figure: &Figure, before: Option<&StoredRun>) -> Vec<String> {
    let peers = figure
        .peers
        .iter()
        .map(|peer| format!("{}: {} ({:.2})", peer.name, short(peer.value), peer.ratio));
    let mut cells = vec![
        escape(&figure.benchmark),
        escape(&figure.work),
        short(figure.value),
        escape(&figure.unit),
        figure.limit.map(short).unwrap_or_default(),
        format!("<span class=\"words\">{}</span>", escape(&peers.collect::<Vec<_>>().join(", "))),
    ];
    if let Some(before) = before {
        let speed = StoredRun::speed_over(before, figure);
        cells.push(speed.map(|speed| format!("{speed:.2} times as fast")).unwrap_or_default());
    }
    cells
}

/// Three significant digits.
fn short(value: f64) -> String {
    let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// A bar for each peer of each figure.
fn beside_peers(figures: &[Figure]) -> Result<Option<String>> {
    let mut rows = Vec::new();
    for figure in figures {
        for (index, peer) in figure.peers.iter().enumerate() {
            // Only the first bar of a work has its label, so that the bars below read as its group.
            let label = if index == 0 { figure.work.clone() } else { String::new() };
            let colour = if peer.ratio >= 1.0 { palette(0) } else { SLOWER };
            let note = format!("{} {:.2}", peer.name, peer.ratio);
            rows.push(Bar { label, value: peer.ratio, interval: None, colour, note });
        }
    }
    if rows.is_empty() {
        return Ok(None);
    }
    // The axis always shows half and twice, so that small differences look small.
    let most = rows.iter().map(|bar| bar.value).fold(2.0, f64::max);
    let least = rows.iter().map(|bar| bar.value).fold(0.5, f64::min);
    let along = Along {
        name: "speed of ours over the peer's",
        range: (0.9 * least, 1.1 * most),
        is_log: true,
        mark: Some((1.0, "equal")),
        labels: 225.0,
        notes: 240.0,
        length: 440.0,
    };
    Ok(Some(bars::svg(&rows, &along)?))
}

/// The layers of a network below the roof of the machine.
fn roofline(measured: &MeasuredLayers, limits: &MachineLimits) -> Result<String> {
    let (low, high) = INTENSITIES;
    // The ridge may lie outside the axis, and the line must not leave it.
    let corners = [low, limits.ridge().clamp(low, high), high];
    let roof = corners.map(|intensity| (intensity, limits.roof_gflop_per_s(intensity))).to_vec();
    let points: Vec<(f64, f64)> = measured
        .layers
        .iter()
        // Layers without arithmetic have no place on a logarithmic axis.
        .filter(|layer| layer.gflop_per_s > 0.0)
        .map(|layer| (layer.flop_per_byte, layer.gflop_per_s))
        .collect();
    let chart = Chart {
        title: format!("{}, {}", measured.network, threads(measured.threads)),
        x: ChartAxis::log("operations per byte"),
        y: ChartAxis::log("GFLOP/s"),
        series: vec![
            Series::line("roof", palette(1), roof),
            Series { label: "layers".to_owned(), colour: palette(0), mark: Mark::Discs, points },
        ],
    };
    Ok(chart::svg(&chart, ROOFLINE)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_three_digits() {
        assert_eq!([short(0.012_345), short(8.765), short(12_345.6)], ["0.0123", "8.77", "12346"]);
    }
}
