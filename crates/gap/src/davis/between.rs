//! How light goes from one frame to the next, which no frame tells.

/// How light goes from one shot to the next.
#[derive(Debug, Clone, Copy)]
pub(super) enum Between {
    /// Evenly.
    Evenly,
    /// In this part of the time, each pixel at its time, so that an edge passes over the image.
    Abruptly {
        share: f32,
        /// Turns per pixel along columns and rows, and at the first pixel.
        wave: [f32; 3],
    },
}

impl Between {
    /// How far light has gone after `share` of the time before shot `next`.
    pub(super) fn share(self, share: f32, next: usize, pixel: usize, width: usize) -> f32 {
        match self {
            Self::Evenly => share,
            Self::Abruptly { share: lasts, wave: [along_x, along_y, start] } => {
                let (x, y) = ((pixel % width) as f32, (pixel / width) as f32);
                let turns = along_x * x + along_y * y + start + 0.382 * next as f32;
                let place = 0.5 + 0.5 * (std::f32::consts::TAU * turns).sin();
                let begins = (1.0 - lasts) * place;
                ((share - begins) / lasts).clamp(0.0, 1.0)
            }
        }
    }
}
