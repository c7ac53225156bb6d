//! Events to dense planes: LNES and its relatives.
