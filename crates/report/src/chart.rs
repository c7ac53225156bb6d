//! Charts of curves, dots and steps on linear or logarithmic axes, single or stacked, as SVG.

use std::ops::Range;

use plotters::coord::combinators::BindKeyPoints as _;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::colour::Colour;
use crate::drawing::{Area, DrawingError, FONT, document, rgb};
use crate::legend::{ChartHead, Entry};
use crate::ticks::log_ticks;

/// Charts of one stack begin at the same place.
const LABELS_PX: u32 = 62;
/// Size of a chart of curves, pixels.
const CURVES: (u32, u32) = (550, 350);
/// Font sizes of names of axes and of ticks; the SVG backend divides them by 1.24.
const NAME_SIZE: u32 = 14;
const TICK_SIZE: u32 = 13;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A polyline.
    Line,
    /// A polyline of dashes of the first length, with gaps of the second, in pixels.
    Dashes(u32, u32),
    /// The label beside the first point, in place of an entry in the legend.
    Name,
    /// From each point horizontally to the next, and then to its height.
    Steps,
    /// Unconnected markers, small enough for thousands.
    Dots,
    /// Unconnected markers of few points.
    Discs,
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
    pub colour: Colour,
    /// How the points are drawn.
    pub mark: Mark,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A curve, with a label in the legend.
    pub fn line(label: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), colour, mark: Mark::Line, points }
    }
}

/// One axis.
#[derive(Debug, Clone, Default)]
pub struct ChartAxis {
    /// Label, with its unit.
    pub name: String,
    /// Whether the scale is logarithmic.
    pub is_log: bool,
    /// From the data where absent.
    pub range: Option<(f64, f64)>,
    /// Of classes rather than of a quantity: whole numbers alone are labelled.
    pub is_whole: bool,
    /// Whether zero is on a linear axis whose range follows from the data.
    pub has_zero: bool,
    /// Names of values in the place of digits, if there are any: other ticks have no label.
    pub named: Vec<(f64, String)>,
}

/// One chart.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// Title above the chart.
    pub title: String,
    /// Horizontal axis.
    pub x: ChartAxis,
    /// Vertical axis.
    pub y: ChartAxis,
    /// Series, the last drawn on top.
    pub series: Vec<Series>,
}

impl ChartAxis {
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

    /// Includes zero where the range follows from the data.
    pub fn from_zero(mut self) -> Self {
        self.has_zero = true;
        self
    }

    /// Labels ticks with integers only.
    pub fn whole(mut self) -> Self {
        self.is_whole = true;
        self
    }

    /// Labels these values, and no others, with names.
    pub fn named(mut self, names: &[(f64, &str)]) -> Self {
        self.named = names.iter().map(|(value, name)| (*value, (*name).to_owned())).collect();
        self
    }

    fn label(&self, value: f64) -> String {
        if !self.named.is_empty() {
            let known = self.named.iter().find(|(named, _)| (named - value).abs() < 1e-9);
            return known.map(|(_, name)| name.clone()).unwrap_or_default();
        }
        if self.is_whole && value.fract() != 0.0 { String::new() } else { label(value) }
    }

    /// The range of what is drawn, with a margin.
    fn limits(&self, values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
        if let Some(range) = self.range {
            return range;
        }
        // A logarithmic axis has no zero.
        let zero = (self.has_zero && !self.is_log).then_some(0.0);
        let usable = values.chain(zero).filter(|v| v.is_finite() && (!self.is_log || *v > 0.0));
        let (low, high) =
            usable.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        match (low <= high, self.is_log) {
            (false, true) => (0.1, 10.0),
            (false, false) => (0.0, 1.0),
            // The margin of a logarithmic axis is a factor: it looks the same at both ends.
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
///
/// # Errors
/// If the SVG backend fails.
pub fn svg(chart: &Chart, size: (u32, u32)) -> Result<String, DrawingError> {
    stack(std::slice::from_ref(chart), size)
}

/// Draws charts one below the other, each of this size.
///
/// # Errors
/// If the SVG backend fails.
pub fn stack(charts: &[Chart], size: (u32, u32)) -> Result<String, DrawingError> {
    grid(charts, 1, size)
}

/// Draws charts in rows of `columns`, each of this size.
///
/// # Errors
/// If the SVG backend fails.
pub fn grid(
    charts: &[Chart],
    columns: usize,
    (width, height): (u32, u32),
) -> Result<String, DrawingError> {
    // A drawing without charts still has a height.
    let rows = charts.len().div_ceil(columns.max(1)).max(1);
    document((width * columns as u32, height * rows as u32), |root| {
        root.fill(&WHITE).map_err(DrawingError::new)?;
        for (chart, area) in charts.iter().zip(root.split_evenly((rows, columns))) {
            draw(chart, &area)?;
        }
        Ok(())
    })
}

/// Draws curves of one chart in the size of reports.
///
/// # Errors
/// If the SVG backend fails.
pub fn curves(chart: &Chart) -> Result<String, DrawingError> {
    svg(chart, CURVES)
}

/// Dashes of the second curve of a chart and of those behind it, in pixels: different enough to be distinguished where
/// curves lie on each other.
const DASHES: [(u32, u32); 4] = [(10, 5), (4, 4), (16, 4), (2, 5)];

/// Draws the fraction of correct points over a threshold (PCK); `threshold` names it with its unit. Curves have
/// dashes of their own and their names beside them, since they may lie on each other.
///
/// # Errors
/// If the SVG backend fails.
pub fn pck(title: &str, threshold: &str, mut series: Vec<Series>) -> Result<String, DrawingError> {
    let count = series.len();
    let name = |(index, series): (usize, &Series)| {
        // Each at a place of its own along the axis.
        let at = series.points.get(series.points.len() * (index + 1) / (count + 1))?;
        Some(Series { mark: Mark::Name, points: vec![*at], ..series.clone() })
    };
    let names: Vec<Series> = series.iter().enumerate().filter_map(name).collect();
    for (series, (dash, gap)) in series.iter_mut().skip(1).zip(DASHES.iter().cycle()) {
        series.mark = Mark::Dashes(*dash, *gap);
    }
    // Names are drawn last, so that no curve hides them.
    series.extend(names);
    curves(&Chart {
        title: title.to_owned(),
        x: ChartAxis::new(threshold),
        y: ChartAxis::new("PCK, fraction of points").over(0.0, 1.0),
        series,
    })
}

fn draw(chart: &Chart, area: &Area<'_>) -> Result<(), DrawingError> {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let x = chart.x.limits(points().map(|p| p.0), 0.0);
    let y = chart.y.limits(points().map(|p| p.1), 0.06);
    // Axes of zero length cannot be drawn.
    let (x, y) = (x.0..x.1.max(x.0 + 1e-12), y.0..y.1.max(y.0 + 1e-12));
    let entries: Vec<Entry<'_>> = chart
        .series
        .iter()
        .filter(|series| !series.label.is_empty() && series.mark != Mark::Name)
        .map(|series| Entry { label: &series.label, colour: series.colour })
        .collect();
    let head = ChartHead::new(&chart.title, &entries, f64::from(area.dim_in_pixel().0));
    head.draw(area)?;
    let (_, area) = area.split_vertically(head.height_px() as u32);
    let (x_ticks, y_ticks) = (log_ticks_of(&chart.x, &x), log_ticks_of(&chart.y, &y));
    // Linear and logarithmic axes are different types of `plotters`.
    match (x_ticks, y_ticks) {
        (None, None) => draw_on(chart, &area, x, y),
        (Some(x_ticks), None) => draw_on(chart, &area, x.log_scale().with_key_points(x_ticks), y),
        (None, Some(y_ticks)) => draw_on(chart, &area, x, y.log_scale().with_key_points(y_ticks)),
        (Some(x_ticks), Some(y_ticks)) => draw_on(
            chart,
            &area,
            x.log_scale().with_key_points(x_ticks),
            y.log_scale().with_key_points(y_ticks),
        ),
    }
}

fn log_ticks_of(axis: &ChartAxis, range: &Range<f64>) -> Option<Vec<f64>> {
    axis.is_log.then(|| log_ticks(range.start, range.end))
}

fn draw_on<X, Y>(chart: &Chart, area: &Area<'_>, x: X, y: Y) -> Result<(), DrawingError>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut builder = ChartBuilder::on(area);
    builder.margin(8).margin_top(4).margin_right(14).y_label_area_size(LABELS_PX);
    // Room for the ticks alone, or for a name as well.
    builder.x_label_area_size(if chart.x.name.is_empty() { 18 } else { 36 });
    let mut canvas = builder.build_cartesian_2d(x, y).map_err(DrawingError::new)?;
    canvas
        .configure_mesh()
        .x_desc(&chart.x.name)
        .y_desc(&chart.y.name)
        .x_labels(8)
        .y_labels(6)
        .x_label_formatter(&|v| chart.x.label(*v))
        .y_label_formatter(&|v| chart.y.label(*v))
        .axis_desc_style((FONT, NAME_SIZE))
        .label_style((FONT, TICK_SIZE))
        // Fine lines of the mesh are as white as the page: they would compete with the curves.
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(232, 232, 236))
        .draw()
        .map_err(DrawingError::new)?;
    for series in &chart.series {
        let colour = rgb(series.colour);
        let points = series.points.iter().copied().filter(|p| {
            // A logarithmic axis has no place for zero.
            let fits = |v: f64, axis: &ChartAxis| v.is_finite() && (!axis.is_log || v > 0.0);
            fits(p.0, &chart.x) && fits(p.1, &chart.y)
        });
        let drawn = match series.mark {
            Mark::Line => canvas.draw_series(LineSeries::new(points, colour.stroke_width(2))),
            Mark::Dashes(dash, gap) => {
                let points: Vec<(f64, f64)> = points.collect();
                let stroke = colour.stroke_width(2);
                canvas.draw_series(DashedLineSeries::new(points, dash, gap, stroke))
            }
            Mark::Name => canvas.draw_series(points.take(1).map(|p| {
                let style = (FONT, TICK_SIZE).into_font().color(&colour);
                EmptyElement::at(p) + Text::new(series.label.clone(), (4, -14), style)
            })),
            Mark::Steps => {
                canvas.draw_series(LineSeries::new(stairs(points), colour.stroke_width(2)))
            }
            Mark::Dots => {
                canvas.draw_series(points.map(|p| Circle::new(p, 1, colour.mix(0.7).filled())))
            }
            Mark::Discs => canvas.draw_series(points.map(|p| Circle::new(p, 3, colour.filled()))),
            Mark::Ticks => canvas.draw_series(points.map(|p| {
                EmptyElement::at(p) + PathElement::new([(0, -7), (0, 7)], colour.stroke_width(1))
            })),
            Mark::Band => {
                let around: Vec<(f64, f64)> = points.collect();
                canvas.draw_series([Polygon::new(around, colour.mix(0.4).filled())])
            }
        };
        drawn.map_err(DrawingError::new)?;
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

fn label(value: f64) -> String {
    let size = value.abs();
    if size < 1e-12 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        // Three significant digits, as far as four decimals hold them.
        let decimals = (2 - size.log10().floor() as i32).clamp(0, 4) as usize;
        let text = format!("{value:.decimals$}");
        // Zeros at the end of a whole number are no decimals.
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
    fn charts_of_any_scale_are_drawn() -> Result<(), DrawingError> {
        for (x, y) in [(false, false), (true, false), (false, true), (true, true)] {
            let marks = [Mark::Line, Mark::Steps, Mark::Dots, Mark::Discs, Mark::Ticks, Mark::Band];
            let marks = marks.into_iter().chain([Mark::Dashes(4, 2), Mark::Name]);
            let series = marks.map(|mark| Series {
                label: format!("{mark:?}"),
                colour: crate::colour::ON,
                mark,
                points: vec![(0.0, 1.0), (1.0, 10.0), (10.0, f64::NAN)],
            });
            let axis =
                |is_log| ChartAxis { name: "axis".to_owned(), is_log, ..ChartAxis::default() };
            let chart = Chart {
                title: "title".to_owned(),
                x: axis(x),
                y: axis(y),
                series: series.collect(),
            };
            let svg = stack(&[chart.clone(), chart], (300, 200))?;
            assert!(svg.contains("Ticks") && svg.matches("title").count() >= 2);
            assert!(!svg.contains("NaN"));
        }
        Ok(())
    }

    #[test]
    fn the_legend_is_above_the_plot_and_logarithmic_axes_have_ticks() -> Result<(), DrawingError> {
        let chart = Chart {
            title: "title".to_owned(),
            x: ChartAxis::new("x, s"),
            y: ChartAxis::log("y, mm"),
            series: vec![Series::line("a curve", (1, 2, 3), vec![(0.0, 41.0), (1.0, 97.0)])],
        };
        let svg = svg(&chart, (400, 300))?;
        let height_of = |text: &str| -> f64 {
            let element = svg[..svg.find(&format!("\n{text}\n")).unwrap_or(0)].rfind("<text");
            let element = &svg[element.unwrap_or(0)..];
            let y = element.split(" y=\"").nth(1).and_then(|rest| rest.split('"').next());
            y.and_then(|y| y.parse().ok()).unwrap_or(f64::NAN)
        };
        // Less than a decade, and still labelled.
        for tick in ["60", "80", "100"] {
            assert!(height_of(tick) > height_of("a curve"), "{tick}: {svg}");
        }
        assert!(height_of("title") < height_of("a curve"), "{svg}");
        Ok(())
    }

    #[test]
    fn curves_on_each_other_have_other_dashes_and_their_names_at_other_places()
    -> Result<(), DrawingError> {
        let points: Vec<(f64, f64)> =
            (0..50).map(|k| (f64::from(k), 0.02 * f64::from(k))).collect();
        let names = ["mean_pose", "untrained", "trained"];
        let series = |points: &[(f64, f64)]| {
            names.map(|name| Series::line(name, crate::colour::ON, points.to_vec())).to_vec()
        };
        let together = pck("3D", "mm", series(&points))?;
        for name in names {
            // In the legend, and beside the curve.
            assert_eq!(together.matches(&format!("\n{name}\n")).count(), 2, "{name}");
        }
        // One solid line, and the others in many pieces.
        let pieces = together.matches("<polyline").count() + together.matches("<line").count();
        let alone = pck("3D", "mm", series(&points)[..1].to_vec())?;
        let of_one = alone.matches("<polyline").count() + alone.matches("<line").count();
        assert!(pieces > of_one + 20, "{pieces} and {of_one}");
        Ok(())
    }

    #[test]
    fn named_values_have_no_digits() {
        let axis = ChartAxis::new("polarity").named(&[(1.0, "ON"), (-1.0, "OFF")]);
        assert_eq!([-1.0, 0.0, 1.0].map(|value| axis.label(value)), ["OFF", "", "ON"]);
    }

    #[test]
    fn an_empty_chart_is_empty_and_no_error() -> Result<(), DrawingError> {
        svg(&Chart::default(), (200, 100)).map(|_| ())
    }

    #[test]
    fn stairs_go_along_and_then_up() {
        let corners: Vec<_> = stairs([(0.0, 1.0), (1.0, 3.0)].into_iter()).collect();
        assert_eq!(corners, [(0.0, 1.0), (1.0, 1.0), (1.0, 3.0)]);
    }
}
