//! The variables of formulas, and the patterns over pixels among them.

use evpose_core::{SensorSize, StageNoise};

/// A variable of a formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variable {
    Light,
    LightChange,
    Age,
    NeighbourAge,
    Polarity,
    LastPolarity,
    Time,
    Column,
    Row,
    Pixel,
    Patch,
    ColumnNoise,
    RowNoise,
    Ghost,
}

/// Number of variables.
pub(crate) const VARIABLES: usize = Variable::ALL.len();

/// A value of every variable, by its index.
pub(crate) type Point = [f32; VARIABLES];

/// Age of a pixel without an event so far, and the largest one, ms.
pub(crate) const MAX_AGE_MS: f32 = 1e4;

/// Distance of the independent values that `patch` lies between, pixels.
const PATCH_PX: usize = 8;

impl Variable {
    pub(crate) const ALL: [Self; 14] = [
        Self::Light,
        Self::LightChange,
        Self::Age,
        Self::NeighbourAge,
        Self::Polarity,
        Self::LastPolarity,
        Self::Time,
        Self::Column,
        Self::Row,
        Self::Pixel,
        Self::Patch,
        Self::ColumnNoise,
        Self::RowNoise,
        Self::Ghost,
    ];

    /// Those that differ from pixel to pixel, for good.
    pub(crate) const PATTERNS: [Self; 6] =
        [Self::Column, Self::Row, Self::Pixel, Self::Patch, Self::ColumnNoise, Self::RowNoise];

    /// The name in formulas.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::LightChange => "d_light",
            Self::Age => "age_ms",
            Self::NeighbourAge => "neighbour_age_ms",
            Self::Polarity => "polarity",
            Self::LastPolarity => "last_polarity",
            Self::Time => "time_s",
            Self::Column => "column",
            Self::Row => "row",
            Self::Pixel => "pixel",
            Self::Patch => "patch",
            Self::ColumnNoise => "column_noise",
            Self::RowNoise => "row_noise",
            Self::Ghost => "ghost",
        }
    }

    /// Values at which a formula has to be finite: ends and middles of what is met.
    pub(crate) const fn samples(self) -> &'static [f32] {
        match self {
            Self::Light | Self::Ghost => &[0.0, 1e-3, 0.1, 1.0, 4.0],
            Self::LightChange => &[-10.0, -0.01, 0.0, 0.01, 10.0],
            Self::Age | Self::NeighbourAge => &[0.0, 0.1, 30.0, MAX_AGE_MS],
            Self::Polarity => &[-1.0, 1.0],
            Self::LastPolarity => &[-1.0, 0.0, 1.0],
            Self::Time => &[0.0, 1.0, 3600.0],
            Self::Column | Self::Row => &[0.001, 0.5, 1.0],
            Self::Pixel | Self::Patch | Self::ColumnNoise | Self::RowNoise => &[-5.0, 0.0, 5.0],
        }
    }

    /// Fills in a pattern, row by row from the top left.
    ///
    /// # Panics
    /// If the variable is no pattern.
    pub(crate) fn fill(self, size: SensorSize, noise: StageNoise, values: &mut [f32]) {
        let (width, height) = (usize::from(size.width), usize::from(size.height));
        for (pixel, value) in values.iter_mut().enumerate() {
            let (x, y) = (pixel % width, pixel / width);
            *value = match self {
                Self::Column => (x as f32 + 0.5) / width as f32,
                Self::Row => (y as f32 + 0.5) / height as f32,
                Self::Pixel => noise.normal(pixel, 0),
                Self::Patch => patch(x, y, width, noise),
                Self::ColumnNoise => noise.normal(x, 2),
                Self::RowNoise => noise.normal(y, 3),
                _ => panic!("{} is no pattern", self.name()),
            };
        }
    }
}

/// Bilinear interpolation between normal values on a grid, at a variance of one everywhere.
fn patch(x: usize, y: usize, width: usize, noise: StageNoise) -> f32 {
    let across = width / PATCH_PX + 2;
    let at = |column: usize, row: usize| noise.normal(row * across + column, 1);
    let part = |i: usize| (i % PATCH_PX) as f32 / PATCH_PX as f32;
    let (u, v, column, row) = (part(x), part(y), x / PATCH_PX, y / PATCH_PX);
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let normals =
        [at(column, row), at(column + 1, row), at(column, row + 1), at(column + 1, row + 1)];
    let sum: f32 = weights.iter().zip(normals).map(|(weight, normal)| weight * normal).sum();
    sum / weights.iter().map(|weight| weight * weight).sum::<f32>().sqrt()
}

/// Planes of the patterns that a formula uses, by the index of the variable; empty for all else.
#[derive(Debug, Default)]
pub(crate) struct Patterns {
    planes: Vec<Vec<f32>>,
}

impl Patterns {
    pub(crate) fn new(
        uses: impl Fn(Variable) -> bool,
        size: SensorSize,
        noise: StageNoise,
    ) -> Self {
        let mut planes = vec![Vec::new(); VARIABLES];
        for variable in Variable::PATTERNS.into_iter().filter(|variable| uses(*variable)) {
            let plane = &mut planes[variable as usize];
            plane.resize(size.pixels(), 0.0);
            variable.fill(size, noise, plane);
        }
        Self { planes }
    }

    /// Sets the patterns of one pixel.
    pub(crate) fn set(&self, pixel: usize, point: &mut Point) {
        for (value, plane) in point.iter_mut().zip(&self.planes) {
            if let Some(of_pixel) = plane.get(pixel) {
                *value = *of_pixel;
            }
        }
    }

    /// Planes of the patterns that are used, with their variables.
    pub(crate) fn used(&self) -> impl Iterator<Item = (Variable, &[f32])> {
        let all = Variable::ALL.into_iter().zip(&self.planes);
        all.filter(|(_, plane)| !plane.is_empty()).map(|(variable, plane)| (variable, &**plane))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_normal_and_alike_in_neighbours_alone() {
        let size = SensorSize { width: 512, height: 512 };
        let mut plane = vec![0.0; size.pixels()];
        Variable::Patch.fill(size, StageNoise::new(1, "formula", 0), &mut plane);
        let mean = |lag: usize| {
            let pairs = plane.iter().zip(&plane[lag..]).map(|(a, b)| f64::from(a * b));
            pairs.sum::<f64>() / plane.len() as f64
        };
        // 4,096 independent values: a variance is known to 2 %.
        assert!((mean(0) - 1.0).abs() < 0.1, "{}", mean(0));
        assert!(mean(1) > 0.9 && mean(4 * PATCH_PX).abs() < 0.1, "{} {}", mean(1), mean(32));
    }

    #[test]
    fn columns_and_rows_are_those_of_a_pixel() {
        let size = SensorSize { width: 4, height: 2 };
        let uses = |variable| matches!(variable, Variable::Column | Variable::Row);
        let patterns = Patterns::new(uses, size, StageNoise::new(1, "formula", 0));
        let mut point = [0.0; VARIABLES];
        patterns.set(6, &mut point);
        let (column, row) = (point[Variable::Column as usize], point[Variable::Row as usize]);
        assert_eq!((column, row), (0.625, 0.75));
    }
}
