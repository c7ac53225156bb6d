//! Parametric body models: the procedural arm and hand, skinning, motion.
