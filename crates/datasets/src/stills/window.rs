//! The part of a photograph that is around a person.

use evpose_core::Plane;
use glam::DVec2;

use super::Person;
use super::SkipReason;

/// Sides of windows are no longer: as no photograph of the sets is, by far.
const LONGEST_SIDE: usize = 1 << 14;

/// A part of a photograph; it may stick out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    left: i64,
    top: i64,
    width: usize,
    height: usize,
}

impl Window {
    /// A square around the middle of all points of a person, with a side of their width and height
    /// together; on a photograph of this size.
    ///
    /// # Source
    /// `export_to_movenet.py` of hpe-core. Like there, edges are cut towards zero to whole pixels,
    /// so that one side may be a pixel longer than the other.
    pub(super) fn around(person: &Person, size: [usize; 2]) -> Result<Self, SkipReason> {
        let points = || person.points.iter().copied();
        if person.points.is_empty() {
            return Err(SkipReason::NoPoints);
        }
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        // Points on a photograph give a side of at most its width and height together.
        let limit = 2.0 * size.iter().sum::<usize>() as f64;
        let is_near = points().all(|point| point.is_finite() && point.abs().max_element() <= limit);
        if !is_near {
            return Err(SkipReason::PointsOutside);
        }
        // The side is width and height together: half of it to either side.
        let (center, half) = ((low + high) / 2.0, (high - low).element_sum() / 2.0);
        let [start, end] = [center - half, center + half].map(|corner| corner.as_i64vec2());
        let side = (end - start).as_usizevec2();
        if end.cmple(start).any() {
            return Err(SkipReason::NoExtent);
        }
        if side.max_element() > LONGEST_SIDE {
            return Err(SkipReason::PointsOutside);
        }
        Ok(Self { left: start.x, top: start.y, width: side.x, height: side.y })
    }

    /// Position of a point of the photograph relative to the window.
    pub(super) fn relative(&self, point: DVec2) -> DVec2 {
        (point - DVec2::new(self.left as f64, self.top as f64)) / self.size()
    }

    /// Width and height.
    pub(super) fn size(&self) -> DVec2 {
        DVec2::new(self.width as f64, self.height as f64)
    }

    /// Cuts it out of an image, with black where it sticks out.
    pub(super) fn cut(&self, image: &Plane<u8>) -> Plane<u8> {
        let mut out = Plane::filled(self.width, self.height, 0);
        // Columns of the window that are on the image.
        let inside = |start: i64, length: usize, limit: usize| {
            let first = (-start).clamp(0, length as i64) as usize;
            let last = (limit as i64 - start).clamp(first as i64, length as i64) as usize;
            first..last
        };
        let columns = inside(self.left, self.width, image.width());
        for y in inside(self.top, self.height, image.height()) {
            let row = image.row((self.top + y as i64) as usize);
            let from = (self.left + columns.start as i64).max(0) as usize;
            let part = row.get(from..from + columns.len()).unwrap_or_default();
            out.row_mut(y)[columns.start..columns.start + part.len()].copy_from_slice(part);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(points: &[[f64; 2]]) -> Person {
        Person { points: points.iter().map(|&at| at.into()).collect(), ..Person::default() }
    }

    #[test]
    fn what_sticks_out_is_black_and_the_rest_is_the_image() {
        let data = (0..12 * 10).map(|i| i as u8 + 1).collect();
        let image = Plane::from_vec(12, 10, data).unwrap();
        for (left, top) in [(-5, -6), (-3, 4), (7, 8), (2, 1), (-90, 0), (40, 40), (0, -8)] {
            let window = Window { left, top, width: 8, height: 8 };
            let cut = window.cut(&image);
            for y in 0..8_i64 {
                for x in 0..8_i64 {
                    let (from_x, from_y) = (left + x, top + y);
                    let is_inside = (0..12).contains(&from_x) && (0..10).contains(&from_y);
                    let want =
                        if is_inside { *image.at(from_x as usize, from_y as usize) } else { 0 };
                    assert_eq!(*cut.at(x as usize, y as usize), want, "{left} {top} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn points_that_no_window_can_contain_are_reported() {
        let around = |points: &[[f64; 2]]| Window::around(&person(points), [100, 80]).unwrap_err();
        assert_eq!(around(&[]), SkipReason::NoPoints);
        assert_eq!(around(&[[10.0, 10.0]]), SkipReason::NoExtent);
        assert_eq!(around(&[[10.0, f64::NAN], [1.0, 2.0]]), SkipReason::PointsOutside);
        assert_eq!(around(&[[1e300, 0.0], [1.0, 2.0]]), SkipReason::PointsOutside);
        assert_eq!(around(&[[-4000.0, 0.0], [1.0, 2.0]]), SkipReason::PointsOutside);
    }

    #[test]
    fn the_window_is_as_wide_as_the_points_are_wide_and_high() {
        let window = Window::around(&person(&[[10.0, 20.0], [30.0, 26.0]]), [100, 80]).unwrap();
        // Middle (20, 23), half a side (20 + 6) / 2.
        assert_eq!(window, Window { left: 7, top: 10, width: 26, height: 26 });
        assert_eq!(window.relative(DVec2::new(20.0, 23.0)), DVec2::splat(0.5));
    }
}
