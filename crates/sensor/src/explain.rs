//! One effect in full, as text of at most a hundred columns.

use std::fmt;

use crate::chain_table::short;
use crate::{Prior, StageSpec};

const WIDTH: usize = 100;

impl fmt::Display for StageSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({})", self.name, self.domain)?;
        paragraph(f, "", self.summary)?;
        writeln!(f)?;
        paragraph(f, "formula   ", self.formula)?;
        paragraph(f, "look for  ", self.signature.look_for)?;
        paragraph(f, "source    ", self.source.text)?;
        for param in self.params {
            let unit = if param.unit.is_empty() { "a number" } else { param.unit };
            writeln!(f, "\n{} ({unit})", param.name)?;
            paragraph(f, "    ", param.doc)?;
            let neutral = param.neutral.map_or_else(
                || "must be given".to_owned(),
                |neutral| format!("no effect at {}, the default", short(neutral)),
            );
            let typical = match param.prior {
                Prior::Typical(low, high) => {
                    format!("typical of cameras {} to {}", short(low), short(high))
                }
                Prior::Fixed => "no property of a camera: not to be fitted".to_owned(),
            };
            paragraph(f, "    ", &format!("range {}; {typical}; {neutral}", param.range_words()))?;
        }
        for choice in self.choices {
            writeln!(f, "\n{} (one of: {})", choice.name, choice.allowed.join(", "))?;
            paragraph(f, "    ", choice.doc)?;
            paragraph(f, "    ", &format!("default {}", choice.allowed[0]))?;
        }
        for file in self.files {
            writeln!(f, "\n{} (a file, values in {})", file.name, file.unit)?;
            paragraph(f, "    ", file.doc)?;
        }
        Ok(())
    }
}

/// Text behind a label, broken where the line is full.
fn paragraph(f: &mut fmt::Formatter<'_>, label: &str, text: &str) -> fmt::Result {
    let indent = label.chars().count();
    let mut line = label.to_owned();
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() > WIDTH {
            writeln!(f, "{}", line.trim_end())?;
            line = " ".repeat(indent);
        }
        line += word;
        line.push(' ');
    }
    writeln!(f, "{}", line.trim_end())
}
