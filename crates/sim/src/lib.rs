//! Scenes, tile rasteriser, randomisation and labelled recordings.
