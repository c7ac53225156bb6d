//! Interpolation of light between two frames, which frames do not determine.

/// Golden section of a turn: phases of successive frames are spread evenly.
const GOLDEN_TURN: f32 = 0.382;

/// Course of log light from one frame to the next.
#[derive(Debug, Clone, Copy)]
pub(super) enum Interpolation {
    /// Linear.
    Linear,
    /// Abrupt, each pixel at its own time, so that an edge passes over the image.
    Edge {
        /// Duration of the change, as a fraction of the time between the frames.
        share: f32,
        /// Phase of the time of change: turns per pixel along columns and rows, and at the first
        /// pixel.
        wave: [f32; 3],
    },
}

impl Interpolation {
    /// Fraction of the change after a fraction `share` of the time before frame `next`.
    pub(super) fn share(self, share: f32, next: usize, pixel: usize, width: usize) -> f32 {
        match self {
            Self::Linear => share,
            Self::Edge { share: lasts, wave: [along_x, along_y, start] } => {
                let (x, y) = ((pixel % width) as f32, (pixel / width) as f32);
                // Another phase for each frame, by the golden ratio: no two of a row are alike.
                let turns = along_x * x + along_y * y + start + GOLDEN_TURN * next as f32;
                let place = 0.5 + 0.5 * (std::f32::consts::TAU * turns).sin();
                let begins = (1.0 - lasts) * place;
                ((share - begins) / lasts).clamp(0.0, 1.0)
            }
        }
    }
}
