//! Recordings by the names of their files.

use super::{FORMATS, Format};

/// The names among `names` of recordings whose stem is `stem`: the stem, a dot and the ending of a format.
///
/// ```
/// let names = ["0000.meta", "0000.raw", "0000.poses.csv", "00001.raw"].map(str::to_owned);
/// assert!(evpose_io::recordings_by_stem(&names, "0000").eq(["0000.raw"]));
/// ```
pub fn recordings_by_stem<'a, 's>(
    names: &'a [String],
    stem: &'s str,
) -> impl Iterator<Item = &'a str> + use<'a, 's> {
    names.iter().map(String::as_str).filter(move |name| {
        let ending = name.strip_prefix(stem).filter(|ending| ending.starts_with('.'));
        ending.is_some_and(|ending| FORMATS.iter().any(|format| format.endings.contains(&ending)))
    })
}

/// The format that `name` means, and the ending of its files with the dot: the name of a format or
/// an ending, such as `evt2`, `raw` or `h5`. None if there is no such format that can be written.
pub fn writable_format(name: &str) -> Option<(&'static Format, &'static str)> {
    let mut writable = FORMATS.iter().copied().filter(|format| format.create.is_some());
    // Names come before endings: several formats may share one.
    if let Some(format) = writable.clone().find(|format| format.name == name) {
        return Some((format, format.endings.first()?));
    }
    writable.find_map(|format| {
        let ending = format.endings.iter().find(|ending| ending.strip_prefix('.') == Some(name))?;
        Some((format, *ending))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_meant_by_its_name_or_by_an_ending() {
        let named =
            |name: &str| writable_format(name).map(|(format, ending)| (format.name, ending));
        assert_eq!(named("raw"), Some(("evt3", ".raw")));
        assert_eq!(named("evt2"), Some(("evt2", ".evt2")));
        assert_eq!(named("evc"), Some(("evc", ".evc")));
        assert_eq!(named("csv"), Some(("csv", ".csv")));
        assert_eq!(named("text"), Some(("text", ".txt")));
        assert_eq!(named("aedat"), None, "only read");
        assert_eq!(named("meta"), None);
    }
}
