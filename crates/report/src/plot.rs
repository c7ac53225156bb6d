//! Line plots as SVG.

use anyhow::{Context, Result, anyhow};
use plotters::prelude::*;

/// One curve of a plot.
pub struct Curve {
    /// Label in the legend.
    pub label: String,
    /// Red, green, blue.
    pub colour: (u8, u8, u8),
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// Axes and title of a plot.
pub struct Axes<'a> {
    /// Title above the plot.
    pub title: &'a str,
    /// Label of the horizontal axis.
    pub x: &'a str,
    /// Label of the vertical axis.
    pub y: &'a str,
    /// Logarithmic vertical axis.
    pub log_y: bool,
    /// Vertical range; from the data where absent.
    pub y_range: Option<(f64, f64)>,
}

/// Colours that stay apart for the colour-blind (Okabe and Ito).
pub const PALETTE: [(u8, u8, u8); 6] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (120, 120, 120), (86, 180, 233)];

const SIZE: (u32, u32) = (550, 330);
const FONT: &str = "system-ui, sans-serif";

/// Mesh, curves and legend of a chart, whatever its axes.
macro_rules! draw {
    ($chart:ident, $axes:ident, $curves:ident) => {{
        $chart
            .configure_mesh()
            .x_desc($axes.x)
            .y_desc($axes.y)
            .x_labels(6)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .axis_desc_style((FONT, 13))
            .label_style((FONT, 12))
            .light_line_style(RGBColor(244, 244, 246))
            .bold_line_style(RGBColor(226, 226, 230))
            .draw()?;
        for curve in $curves {
            let (r, g, b) = curve.colour;
            let style = RGBColor(r, g, b).stroke_width(2);
            $chart
                .draw_series(LineSeries::new(curve.points.iter().copied(), style))?
                .label(curve.label.clone())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        $chart
            .configure_series_labels()
            .label_font((FONT, 12))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(226, 226, 230))
            .draw()?;
    }};
}

/// A number as short as it can be said.
fn tick(value: &f64) -> String {
    // Ticks are sums of steps: 0.30000000000000004 means 0.3.
    ((value * 1e6).round() / 1e6).to_string()
}

/// Draws `curves` and returns the SVG.
pub fn lines(axes: &Axes<'_>, curves: &[Curve]) -> Result<String> {
    let finite = || {
        curves
            .iter()
            .flat_map(|c| &c.points)
            .filter(|(x, y)| x.is_finite() && y.is_finite() && (!axes.log_y || *y > 0.0))
    };
    let (mut x, mut y) = ((f64::MAX, f64::MIN), (f64::MAX, f64::MIN));
    for &(px, py) in finite() {
        x = (x.0.min(px), x.1.max(px));
        y = (y.0.min(py), y.1.max(py));
    }
    if finite().next().is_none() {
        return Err(anyhow!("nothing to plot in {:?}", axes.title));
    }
    // A single point still needs a range.
    x.1 = x.1.max(x.0 + 1e-9);
    let y = axes.y_range.unwrap_or_else(|| {
        if axes.log_y { (y.0 / 1.2, y.1 * 1.2) } else { (y.0.min(0.0), y.1 * 1.05 + 1e-9) }
    });
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut builder = ChartBuilder::on(&root);
        builder
            .caption(axes.title, (FONT, 17))
            .margin(10)
            .x_label_area_size(38)
            .y_label_area_size(58);
        // The two kinds of axes are different types in plotters.
        if axes.log_y {
            let mut chart = builder.build_cartesian_2d(x.0..x.1, (y.0..y.1).log_scale())?;
            draw!(chart, axes, curves);
        } else {
            let mut chart = builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
            draw!(chart, axes, curves);
        }
        root.present().context("drawing a plot")?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_names_its_axes_and_curves() -> Result<()> {
        let axes = Axes { title: "Title", x: "threshold", y: "share", log_y: false, y_range: None };
        let curve = Curve {
            label: "trained".into(),
            colour: PALETTE[0],
            points: vec![(0.0, 0.0), (1.0, 0.5)],
        };
        let svg = lines(&axes, &[curve])?;
        for text in ["Title", "threshold", "share", "trained"] {
            assert!(svg.contains(text), "{text} is missing");
        }
        Ok(())
    }
}
