//! The binary as a user runs it.

#![allow(clippy::unwrap_used, reason = "tests")]

mod ablate;
mod accuracy;
mod arguments;
mod baselines;
mod bench;
mod body;
mod body_networks;
mod calibrate;
mod cameras;
mod checkpoints;
mod cli;
mod compare;
mod conditions;
mod config_ranges;
mod demo;
mod detections;
mod devices;
mod events;
mod examples;
mod export;
mod files;
mod force;
mod foreign_set;
mod gap;
mod gap_camera;
mod guides;
mod harness;
mod kills;
mod live;
mod models;
mod one_stream;
mod own_labels;
mod payoff;
mod people_in_the_world;
mod prepare;
mod propagation;
mod quantize;
mod reading;
mod represent;
mod resume;
mod sensor;
mod shards;
mod tune;
mod walk_away;
