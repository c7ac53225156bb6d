//! Reports of evpose: HTML pages, charts, canvases, tables, and the pages made of them.
//!
//! * [`html`]: a page that needs no other file; [`chart`] and [`plot`] draw into it as SVG.
//! * [`canvas`]: event images with skeletons over them; [`png`] encodes them.
//! * [`hand`], [`people`]: reports of hand experiments, images of people; [`held_out`]: the table of an
//!   evaluation.
//! * [`gap`]: the page of the gap workflow; [`gallery`]: sensors and effects in one page.

pub mod camera_views;
pub mod canvas;
pub mod chart;
pub mod gallery;
pub mod gap;
pub mod hand;
pub mod hand_scene;
pub mod held_out;
pub mod html;
pub mod people;
pub mod plot;
pub mod png;
