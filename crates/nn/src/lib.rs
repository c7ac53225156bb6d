//! Networks, losses and weight files.
pub mod resnet;
