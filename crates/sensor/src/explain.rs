//! One effect in full, as text of at most a hundred columns.

use std::fmt;

use crate::chain_table::{interval, short};
use crate::{Parameter, StageSpec};

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
            match param {
                Parameter::Number(number) => {
                    let unit = if number.unit.is_empty() { "a number" } else { number.unit };
                    writeln!(f, "\n{} ({unit})", number.name)?;
                    paragraph(f, "    ", number.doc)?;
                    let neutral = number.default.map_or_else(
                        || "must be given".to_owned(),
                        |neutral| format!("no effect at {}, the default", short(neutral)),
                    );
                    let typical = number.typical.map_or_else(
                        || "no property of a camera: not to be fitted".to_owned(),
                        |limits| format!("typical of cameras {}", interval(limits)),
                    );
                    let range = interval(number.range);
                    paragraph(f, "    ", &format!("range {range}; {typical}; {neutral}"))?;
                }
                Parameter::Word(word) => {
                    writeln!(f, "\n{} (one of: {})", word.name, word.allowed.join(", "))?;
                    paragraph(f, "    ", word.doc)?;
                    if let Some(default) = word.default {
                        paragraph(f, "    ", &format!("default {default}"))?;
                    }
                }
                Parameter::File(file) => {
                    writeln!(f, "\n{} (a file, values in {})", file.name, file.unit)?;
                    paragraph(f, "    ", file.doc)?;
                }
                Parameter::Text(text) => {
                    writeln!(f, "\n{} (text, such as {:?})", text.name, text.example)?;
                    paragraph(f, "    ", text.doc)?;
                }
            }
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
