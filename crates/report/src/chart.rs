//! Charts of curves, dots and steps on linear or logarithmic axes, single or stacked, as SVG.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

/// Colour of ON events.
pub const ON: (u8, u8, u8) = (30, 100, 200);
/// Colour of OFF events.
pub const OFF: (u8, u8, u8) = (200, 50, 60);

const FONT: &str = "system-ui, sans-serif";
/// Charts of one stack begin at the same place.
const LABELS_PX: u32 = 62;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A polyline.
    Line,
    /// From each point horizontally to the next, and then to its height.
    Steps,
    /// Unconnected markers.
    Dots,
    /// A short vertical stroke.
    Ticks,
    /// Filled between the points, which go around it.
    Band,
}

/// One series.
#[derive(Debug, Clone)]
pub struct Series {
    /// In the legend; none where empty.
    pub label: String,
    /// Red, green, blue.
    pub colour: (u8, u8, u8),
    /// How the points are drawn.
    pub mark: Mark,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// One axis.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    /// Label, with its unit.
    pub name: String,
    /// Whether the scale is logarithmic.
    pub is_log: bool,
    /// From the data where absent.
    pub range: Option<(f64, f64)>,
    /// Of classes rather than of a quantity: whole numbers alone are labelled.
    pub is_whole: bool,
}

/// One chart.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// Title above the chart.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Series, the last drawn on top.
    pub series: Vec<Series>,
}

impl Axis {
    /// A linear axis that covers the data.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// A logarithmic axis that covers the data.
    pub fn log(name: &str) -> Self {
        Self { name: name.to_owned(), is_log: true, ..Self::default() }
    }

    /// Covers `low` to `high`.
    pub fn over(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// Labels ticks with integers only.
    pub fn whole(mut self) -> Self {
        self.is_whole = true;
        self
    }

    fn label(&self, value: f64) -> String {
        if self.is_whole && value.fract() != 0.0 { String::new() } else { label(value) }
    }

    /// The range of what is drawn, with a margin.
    fn limits(&self, values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
        if let Some(range) = self.range {
            return range;
        }
        let usable = values.filter(|v| v.is_finite() && (!self.is_log || *v > 0.0));
        let (low, high) =
            usable.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        match (low <= high, self.is_log) {
            (false, true) => (0.1, 10.0),
            (false, false) => (0.0, 1.0),
            (true, true) => (low / 1.3, high * 1.3),
            (true, false) => {
                // What does not change is in the middle of the chart.
                let size = high.abs().max(low.abs());
                let least = if size > 0.0 { 0.02 * size } else { margin };
                let room = (margin * (high - low)).max(least);
                (low - room, high + room)
            }
        }
    }
}

/// Draws one chart of this size in pixels.
pub fn svg(chart: &Chart, size: (u32, u32)) -> Result<String> {
    stack(std::slice::from_ref(chart), size)
}

/// Draws charts one below the other, each of this size.
pub fn stack(charts: &[Chart], (width, height): (u32, u32)) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, height * charts.len() as u32))
            .into_drawing_area();
        root.fill(&WHITE).map_err(plain)?;
        for (chart, area) in charts.iter().zip(root.split_evenly((charts.len(), 1))) {
            draw(chart, &area)?;
        }
        root.present().map_err(plain)?;
    }
    Ok(svg)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn plain(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("drawing a chart: {error}")
}

fn draw(chart: &Chart, area: &Area<'_>) -> Result<()> {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let x = chart.x.limits(points().map(|p| p.0), 0.0);
    let y = chart.y.limits(points().map(|p| p.1), 0.06);
    let (x, y) = (x.0..x.1.max(x.0 + 1e-12), y.0..y.1.max(y.0 + 1e-12));
    match (chart.x.is_log, chart.y.is_log) {
        (false, false) => draw_on(chart, area, x, y),
        (true, false) => draw_on(chart, area, x.log_scale(), y),
        (false, true) => draw_on(chart, area, x, y.log_scale()),
        (true, true) => draw_on(chart, area, x.log_scale(), y.log_scale()),
    }
}

fn draw_on<X, Y>(chart: &Chart, area: &Area<'_>, x: X, y: Y) -> Result<()>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut builder = ChartBuilder::on(area);
    builder.margin(8).margin_right(14).y_label_area_size(LABELS_PX);
    builder.x_label_area_size(if chart.x.name.is_empty() { 18 } else { 36 });
    if !chart.title.is_empty() {
        builder.caption(&chart.title, (FONT, 14));
    }
    let mut canvas = builder.build_cartesian_2d(x, y).map_err(plain)?;
    canvas
        .configure_mesh()
        .x_desc(&chart.x.name)
        .y_desc(&chart.y.name)
        .x_labels(8)
        .y_labels(5)
        .x_label_formatter(&|v| chart.x.label(*v))
        .y_label_formatter(&|v| chart.y.label(*v))
        .axis_desc_style((FONT, 12))
        .label_style((FONT, 11))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(232, 232, 236))
        .draw()
        .map_err(plain)?;
    let mut has_labels = false;
    for series in &chart.series {
        let (r, g, b) = series.colour;
        let colour = RGBColor(r, g, b);
        let points = series.points.iter().copied().filter(|p| {
            let fits = |v: f64, axis: &Axis| v.is_finite() && (!axis.is_log || v > 0.0);
            fits(p.0, &chart.x) && fits(p.1, &chart.y)
        });
        let drawn = match series.mark {
            Mark::Line => canvas.draw_series(LineSeries::new(points, colour.stroke_width(2))),
            Mark::Steps => {
                canvas.draw_series(LineSeries::new(stairs(points), colour.stroke_width(2)))
            }
            Mark::Dots => {
                canvas.draw_series(points.map(|p| Circle::new(p, 1, colour.mix(0.7).filled())))
            }
            Mark::Ticks => canvas.draw_series(points.map(|p| {
                EmptyElement::at(p) + PathElement::new([(0, -7), (0, 7)], colour.stroke_width(1))
            })),
            Mark::Band => {
                let around: Vec<(f64, f64)> = points.collect();
                canvas.draw_series([Polygon::new(around, colour.mix(0.4).filled())])
            }
        };
        let drawn = drawn.map_err(plain)?;
        if !series.label.is_empty() {
            has_labels = true;
            drawn.label(&series.label).legend(move |(x, y)| {
                PathElement::new([(x, y), (x + 14, y)], colour.stroke_width(3))
            });
        }
    }
    if has_labels {
        canvas
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font((FONT, 11))
            .background_style(WHITE.mix(0.8))
            .border_style(RGBColor(226, 226, 230))
            .draw()
            .map_err(plain)?;
    }
    Ok(())
}

fn stairs(points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
    let mut height = None;
    points.flat_map(move |(x, y)| {
        let corner = height.replace(y).map(|before| (x, before));
        corner.into_iter().chain([(x, y)])
    })
}

/// A number on an axis.
fn label(value: f64) -> String {
    let size = value.abs();
    if size < 1e-12 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let decimals = (2 - size.log10().floor() as i32).clamp(0, 4) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_of_any_scale_are_drawn() -> Result<()> {
        for (x, y) in [(false, false), (true, false), (false, true), (true, true)] {
            let marks = [Mark::Line, Mark::Steps, Mark::Dots, Mark::Ticks, Mark::Band];
            let series = marks.map(|mark| Series {
                label: format!("{mark:?}"),
                colour: ON,
                mark,
                points: vec![(0.0, 1.0), (1.0, 10.0), (10.0, f64::NAN)],
            });
            let axis = |is_log| Axis { name: "axis".to_owned(), is_log, ..Axis::default() };
            let chart =
                Chart { title: "title".to_owned(), x: axis(x), y: axis(y), series: series.into() };
            let svg = stack(&[chart.clone(), chart], (300, 200))?;
            assert!(svg.contains("Ticks") && svg.matches("title").count() >= 2);
            assert!(!svg.contains("NaN"));
        }
        Ok(())
    }

    #[test]
    fn an_empty_chart_is_empty_and_no_error() -> Result<()> {
        svg(&Chart::default(), (200, 100)).map(|_| ())
    }

    #[test]
    fn stairs_go_along_and_then_up() {
        let corners: Vec<_> = stairs([(0.0, 1.0), (1.0, 3.0)].into_iter()).collect();
        assert_eq!(corners, [(0.0, 1.0), (1.0, 1.0), (1.0, 3.0)]);
    }
}
