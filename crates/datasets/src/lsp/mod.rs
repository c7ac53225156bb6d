//! Leeds Sports Pose and its extended set: photographs of one person each, fourteen points.
//!
//! * [`convert()`]: photographs and `joints.mat` into images of persons and one annotation file.
//!
//! # Source
//! Johnson, Everingham: *Clustered Pose and Nonlinear Appearance Models for Human Pose Estimation*,
//! BMVC 2010 (2,000 photographs), and *Learning Effective Human Pose Estimation from Inaccurate
//! Annotation*, CVPR 2011 (10,000 of them, annotated by crowd workers).

mod convert;
mod person;
mod table;

pub use convert::convert;
