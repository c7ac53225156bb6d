//! Reports of evpose: charts, heatmaps and tables in HTML pages, and images of events with
//! skeletons.
//!
//! * [`chart`], [`bars`], [`waterfall`], [`heatmap`]: the one plotting layer, SVG by `plotters`, in
//!   the colours of [`colour`].
//! * [`html`]: a page that needs no other file.
//! * [`canvas`]: event images with skeletons over them; [`png`](mod@png) encodes them.
//!
//! # Example
//! A chart in a page:
//!
//! ```
//! use evpose_report::chart::{self, ChartAxis, Chart, Series};
//! use evpose_report::colour::palette;
//! use evpose_report::html::HtmlPage;
//!
//! let rate = Series::line("ON events", palette(0), vec![(0.0, 1.2), (0.5, 3.4), (1.0, 2.1)]);
//! let svg = chart::curves(&Chart {
//!     title: "Event rate".to_owned(),
//!     x: ChartAxis::new("time in s"),
//!     y: ChartAxis::new("M events / s").from_zero(),
//!     series: vec![rate],
//! })?;
//! let mut page = HtmlPage::new("A recording", "Rates of its events.");
//! page.plots(&[svg]);
//! assert!(page.finish().contains("Event rate"));
//! # Ok::<(), evpose_report::drawing::DrawingError>(())
//! ```

pub mod bars;
pub mod canvas;
pub mod chart;
pub mod colour;
pub mod dot_letters;
pub mod drawing;
pub mod format;
pub mod heatmap;
pub mod html;
mod legend;
pub mod png;
mod ticks;
pub mod waterfall;
