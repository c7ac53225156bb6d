//! Macro targets, and how much of each a person has.
//!
//! # Model
//! The name of a target is a list of words, such as `female-young-maxmuscle-minweight-maxheight`. A
//! word counts as much as its parameter is near to where the word has its peak, linearly, and a
//! target counts as the product of its words: MakeHuman's own rule (`macrodetails/macro.json`).
//! Parameters are from 0 to 1; those of ethnicity have sum one.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use glam::Vec3;

use crate::folder_error::{FolderError, sorted_paths};

use super::obj::vector;

/// Macro parameters: sex, age, muscle, weight, height, proportions, and three of ethnicity.
pub(crate) const MACROS: usize = 9;

/// A word in names of targets, the parameter it belongs to, and where it begins to count, counts
/// fully and no longer counts. Words with one end beyond 0 to 1 count fully at an end.
const WORDS: [(&str, usize, [f32; 3]); 19] = [
    ("female", 0, [-1.0, 0.0, 1.0]),
    ("male", 0, [0.0, 1.0, 2.0]),
    ("child", 1, [0.0, 0.1875, 0.5]),
    ("young", 1, [0.1875, 0.5, 1.0]),
    ("old", 1, [0.5, 1.0, 2.0]),
    ("minmuscle", 2, [-1.0, 0.0, 0.5]),
    ("averagemuscle", 2, [0.0, 0.5, 1.0]),
    ("maxmuscle", 2, [0.5, 1.0, 2.0]),
    ("minweight", 3, [-1.0, 0.0, 0.5]),
    ("averageweight", 3, [0.0, 0.5, 1.0]),
    ("maxweight", 3, [0.5, 1.0, 2.0]),
    ("minheight", 4, [-1.0, 0.0, 0.5]),
    ("maxheight", 4, [0.5, 1.0, 2.0]),
    ("uncommonproportions", 5, [-1.0, 0.0, 0.5]),
    ("idealproportions", 5, [0.5, 1.0, 2.0]),
    ("african", 6, [0.0, 1.0, 2.0]),
    ("asian", 7, [0.0, 1.0, 2.0]),
    ("caucasian", 8, [0.0, 1.0, 2.0]),
    // Of every ethnicity: always one.
    ("universal", MACROS, [0.0, 1.0, 2.0]),
];

/// A macro target, by the words of its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MacroTarget {
    words: Vec<usize>,
}

/// Macro parameters of shape coefficients; ±2 is the whole range of a parameter, and missing ones are
/// zero. Sexes are seldom mixed; nobody is younger than about 13 years, nor as small or tall as
/// the outermost targets of height.
pub(crate) fn macros_of(betas: &[f32]) -> [f32; MACROS] {
    let beta = |k: usize| betas.get(k).copied().unwrap_or(0.0);
    let from_middle = |k: usize, per_unit: f32| (0.5 + per_unit * beta(k)).clamp(0.0, 1.0);
    let ethnicities = [6, 7, 8].map(|k| beta(k).exp());
    let sum: f32 = ethnicities.iter().sum();
    std::array::from_fn(|k| match k {
        0 => from_middle(0, 1.0),
        1 => (0.625 + 0.1875 * beta(1)).clamp(0.25, 1.0),
        2 | 3 | 5 => from_middle(k, 0.25),
        4 => from_middle(4, 0.125),
        _ => ethnicities[k - 6] / sum,
    })
}

impl MacroTarget {
    /// The target of a name; none if it has a word that is not known.
    fn parse(name: &str) -> Option<Self> {
        let word = |word: &str| WORDS.iter().position(|(known, ..)| *known == word);
        Some(Self { words: name.split('-').map(word).collect::<Option<_>>()? })
    }

    /// Weight of the target for macro parameters.
    pub(crate) fn weight(&self, macros: &[f32; MACROS]) -> f32 {
        let word = |&word: &usize| {
            let (_, parameter, [begin, peak, end]) = WORDS[word];
            let x = macros.get(parameter).copied().unwrap_or(1.0);
            let share =
                if x < peak { (x - begin) / (peak - begin) } else { (end - x) / (end - peak) };
            share.clamp(0.0, 1.0)
        };
        self.words.iter().map(word).product()
    }
}

/// Reads the targets of a folder and of those in it, with their displacements of all `vertices`, in
/// a fixed order. Those of other words, such as babies, are passed over.
pub(super) fn read(
    folder: &Path,
    vertices: usize,
) -> Result<Vec<(MacroTarget, Vec<Vec3>)>, FolderError> {
    let mut targets = Vec::new();
    let mut paths = sorted_paths(folder)?;
    for folder in paths.clone().iter().filter(|path| path.is_dir()) {
        paths.extend(sorted_paths(folder)?);
    }
    for path in paths.into_iter().filter(|path| path.is_file()) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let is_packed = name.ends_with(".gz");
        let Some(stem) = name.trim_end_matches(".gz").strip_suffix(".target") else { continue };
        if let Some(target) = MacroTarget::parse(stem) {
            let text = text(&path, is_packed)?;
            targets.push((target, displacements(&path, &text, vertices)?));
        }
    }
    if targets.is_empty() {
        return Err(FolderError::content(folder, "no targets of MakeHuman's macro parameters"));
    }
    Ok(targets)
}

fn text(path: &PathBuf, is_packed: bool) -> Result<String, FolderError> {
    let fault = |source| FolderError::File { path: path.clone(), source };
    let mut file = File::open(path).map_err(fault)?;
    let mut text = String::new();
    let read = if is_packed {
        GzDecoder::new(file).read_to_string(&mut text)
    } else {
        file.read_to_string(&mut text)
    };
    read.map_err(fault)?;
    Ok(text)
}

/// Lines of a vertex and its displacement; vertices without a line stay.
fn displacements(path: &Path, text: &str, vertices: usize) -> Result<Vec<Vec3>, FolderError> {
    let mut displacements = vec![Vec3::ZERO; vertices];
    for (line, row) in text.lines().enumerate() {
        if row.starts_with('#') || row.trim().is_empty() {
            continue;
        }
        let mut words = row.split_whitespace();
        let vertex = words.next().and_then(|word| word.parse::<usize>().ok());
        let place = vertex.and_then(|vertex| displacements.get_mut(vertex));
        match (place, vector(words)) {
            (Some(place), Some(moved)) => *place = moved,
            _ => {
                let reason = format!("`vertex dx dy dz` of {vertices} vertices expected");
                return Err(FolderError::line(path, line, reason));
            }
        }
    }
    Ok(displacements)
}
