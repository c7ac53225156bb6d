//! Times of labelled images in the clock of the events.

use std::path::Path;

use evpose_core::Micros;

use crate::import::ImportError;

/// Time of an image as its label file states it.
#[derive(Debug, Clone, PartialEq)]
pub enum ImageTime {
    /// A time stamp.
    Stamp(Micros),
    /// The name of the image's file, which may hold the index of the frame.
    Name(String),
}

/// Order by which images without a time stamp are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameCount {
    /// The last digits of each name if every name has some, else the order of the file.
    #[default]
    Automatic,
    /// The last digits of each name.
    Name,
    /// The order of the file.
    Order,
}

/// The relation between the times of labels and those of events.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LabelClock {
    /// Time of the labels' 0 in the clock of the events.
    pub start: Micros,
    /// Images per second, for images without time stamps: image `n` is at `start + n / fps`.
    pub fps: Option<f64>,
    /// Order by which images are counted.
    pub count: FrameCount,
}

impl LabelClock {
    /// The times of images in the clock of the events; `path` is the label file.
    ///
    /// # Errors
    /// If an image has neither a time stamp nor a frame rate, or its name no digits.
    pub fn times(&self, images: &[ImageTime], path: &Path) -> Result<Vec<Micros>, ImportError> {
        let has_digits = |image: &ImageTime| match image {
            ImageTime::Stamp(_) => true,
            ImageTime::Name(name) => last_digits(name).is_some(),
        };
        // Names count if all of them have digits: one without would have no index.
        let by_name = match self.count {
            FrameCount::Automatic => images.iter().all(has_digits),
            FrameCount::Name => true,
            FrameCount::Order => false,
        };
        let time = |(order, image): (usize, &ImageTime)| {
            let name = match image {
                ImageTime::Stamp(t) => return Ok(self.start + *t),
                ImageTime::Name(name) => name,
            };
            let place = || format!("image {order} (`{name}`)");
            let Some(fps) = self.fps else {
                return Err(ImportError::NoTime { path: path.to_owned(), place: place() });
            };
            let index = if by_name {
                let digits = last_digits(name).and_then(|digits| digits.parse::<u64>().ok());
                digits.ok_or_else(|| {
                    ImportError::malformed(path, place(), "no index of a frame in its name")
                })?
            } else {
                order as u64
            };
            Ok(self.start + Micros::from_seconds(index as f64 / fps))
        };
        images.iter().enumerate().map(time).collect()
    }
}

/// The last digits of a file's name, without its ending.
fn last_digits(name: &str) -> Option<&str> {
    let name = name.rsplit(['/', '\\']).next()?;
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit());
    // A character before the digits may be of several bytes.
    let start = start.map_or(0, |at| at + stem[at..].chars().next().map_or(0, char::len_utf8));
    Some(&stem[start..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<ImageTime> {
        names.iter().map(|name| ImageTime::Name((*name).to_owned())).collect()
    }

    #[test]
    fn images_are_counted_by_their_names_or_in_order() {
        let path = Path::new("l.json");
        let clock = LabelClock { start: Micros(1_000), fps: Some(50.0), ..LabelClock::default() };
        let times = clock.times(&names(&["f_0003.png", "a1/f_0010.png"]), path).unwrap();
        assert_eq!(times, [Micros(61_000), Micros(201_000)]);
        // One name has no digits, so all are counted in order.
        let times = clock.times(&names(&["f_0003.png", "last.png"]), path).unwrap();
        assert_eq!(times, [Micros(1_000), Micros(21_000)]);
        let in_order = LabelClock { count: FrameCount::Order, ..clock };
        assert_eq!(in_order.times(&names(&["f_0003.png"]), path).unwrap(), [Micros(1_000)]);
        let stamped = [ImageTime::Stamp(Micros(7))];
        assert_eq!(
            LabelClock { fps: None, ..clock }.times(&stamped, path).unwrap(),
            [Micros(1_007)]
        );
    }

    #[test]
    fn an_image_without_a_time_is_reported_with_its_name() {
        let path = Path::new("l.json");
        let message = LabelClock::default().times(&names(&["f_3.png"]), path).unwrap_err();
        assert!(message.to_string().contains("f_3.png") && message.to_string().contains("--fps"));
        let by_name =
            LabelClock { fps: Some(10.0), count: FrameCount::Name, ..LabelClock::default() };
        let message = by_name.times(&names(&["first.png"]), path).unwrap_err().to_string();
        assert!(message.contains("first.png") && message.contains("no index"), "{message}");
    }

    #[test]
    fn digits_are_the_last_of_the_name() {
        for (name, want) in [
            ("0012.jpg", Some("0012")),
            ("cam2_frame7b.png", Some("7")),
            ("a/12/last.png", None),
            ("é5.png", Some("5")),
            ("x", None),
        ] {
            assert_eq!(last_digits(name), want, "{name}");
        }
    }
}
