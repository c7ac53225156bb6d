//! `rest`: twelve still patches; three slow discs and a fast one cross them.

use super::DARKEST_LN;
use super::disc::Disc;
use super::steps::Tiles;
use crate::draw::Sequence;

#[derive(Debug, Clone)]
pub(super) struct Rest {
    tiles: Tiles<3, 4>,
    discs: Vec<Disc>,
}

impl Rest {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let tiles = Tiles::new(draws, DARKEST_LN, -0.1);
        let discs = [15.0, 35.0, 70.0, 300.0].map(|v| Disc::new(draws, v)).to_vec();
        Self { tiles, discs }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        let ground = self.tiles.at(x_px, y_px);
        self.discs.iter().fold(ground, |under, disc| disc.over(under, x_px, y_px, t_s))
    }
}
