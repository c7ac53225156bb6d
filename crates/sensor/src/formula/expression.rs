//! Formulas as text: a small grammar, read into a program.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = signed { ("*" | "/") signed }
//! signed  = "-" signed | power
//! power   = atom [ "^" signed ]
//! atom    = number | variable | constant | function "(" sum { "," sum } ")" | "(" sum ")"
//! ```

use std::fmt;

use super::program::{Function, Operation, Program};
use super::variable::Variable;

/// Brackets inside of each other, signs and powers included, beyond which a formula is refused.
const MAX_DEPTH: usize = 64;

/// Reason why a text is no formula.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaFault {
    /// Column of the fault, from 1.
    pub column: usize,
    /// Description of the fault.
    pub problem: String,
}

impl fmt::Display for FormulaFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}: {}", self.column, self.problem)
    }
}

/// Names that a formula may have in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Names<'a> {
    pub(crate) variables: &'a [Variable],
    pub(crate) constants: &'a [(&'static str, f64)],
}

/// Reads a formula.
///
/// # Errors
/// The first fault of the text, with its column.
pub(crate) fn parse(text: &str, names: Names<'_>) -> Result<Program, FormulaFault> {
    let mut parser = Parser { text, at: 0, depth: 0, names, operations: Vec::new() };
    parser.sum()?;
    match parser.peek() {
        None => Ok(Program::new(parser.operations)),
        Some(found) => Err(parser.fault(format!("`{found}` is not expected here"))),
    }
}

struct Parser<'a> {
    text: &'a str,
    /// Bytes that are read.
    at: usize,
    depth: usize,
    names: Names<'a>,
    operations: Vec<Operation>,
}

impl Parser<'_> {
    fn sum(&mut self) -> Result<(), FormulaFault> {
        self.product()?;
        while let Some(sign) = self.take_one_of("+-") {
            self.product()?;
            self.operations.push(if sign == '+' { Operation::Add } else { Operation::Subtract });
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), FormulaFault> {
        self.signed()?;
        while let Some(sign) = self.take_one_of("*/") {
            self.signed()?;
            self.operations.push(if sign == '*' { Operation::Multiply } else { Operation::Divide });
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), FormulaFault> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.fault(format!("more than {MAX_DEPTH} brackets inside of each other")));
        }
        if self.take_one_of("-").is_some() {
            self.signed()?;
            self.operations.push(Operation::Negate);
        } else {
            self.atom()?;
            if self.take_one_of("^").is_some() {
                self.signed()?;
                self.operations.push(Operation::Power);
            }
        }
        self.depth -= 1;
        Ok(())
    }

    fn atom(&mut self) -> Result<(), FormulaFault> {
        match self.peek() {
            Some('(') => {
                self.take_one_of("(");
                self.sum()?;
                self.expect(')')
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            Some(found) => Err(self.fault(format!("`{found}` is not expected here"))),
            None => Err(self.fault("a number, a name or a bracket is missing".to_owned())),
        }
    }

    fn number(&mut self) -> Result<(), FormulaFault> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let digits = |mut at: usize| {
            while bytes.get(at).is_some_and(|c| c.is_ascii_digit() || *c == b'.') {
                at += 1;
            }
            at
        };
        let mut end = digits(start);
        if bytes.get(end).is_some_and(|c| c.eq_ignore_ascii_case(&b'e')) {
            let sign = usize::from(bytes.get(end + 1).is_some_and(|c| b"+-".contains(c)));
            let behind = digits(end + 1 + sign);
            // Without digits behind it, the letter begins a name.
            end = if behind > end + 1 + sign { behind } else { end };
        }
        let text = &self.text[start..end];
        let number = text.parse::<f32>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| self.fault(format!("`{text}` is no number")))?;
        self.at = end;
        self.operations.push(Operation::Constant(number));
        Ok(())
    }

    fn name(&mut self) -> Result<(), FormulaFault> {
        let rest = &self.text[self.at..];
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let name = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
        let (column, Names { variables, constants }) = (self.at, self.names);
        self.at += name.len();
        if let Some(function) = Function::ALL.into_iter().find(|one| one.name() == name) {
            return self.call(function);
        }
        let variable = variables.iter().find(|variable| variable.name() == name);
        let constant = constants.iter().find(|(constant, _)| *constant == name);
        self.operations.push(match (variable, constant) {
            (Some(variable), _) => Operation::Variable(*variable),
            (_, Some((_, value))) => Operation::Constant(*value as f32),
            _ => {
                self.at = column;
                return Err(self.fault(self.unknown(name)));
            }
        });
        Ok(())
    }

    fn call(&mut self, function: Function) -> Result<(), FormulaFault> {
        self.expect('(')?;
        self.sum()?;
        for _ in 1..function.arguments() {
            self.expect(',')?;
            self.sum()?;
        }
        self.expect(')')?;
        self.operations.push(Operation::Call(function));
        Ok(())
    }

    fn unknown(&self, name: &str) -> String {
        let Names { variables, constants } = self.names;
        let variables: Vec<&str> = variables.iter().map(|variable| variable.name()).collect();
        let constants: Vec<&str> = constants.iter().map(|(constant, _)| *constant).collect();
        let functions = Function::ALL.map(Function::name);
        format!(
            "unknown name `{name}`; the variables here are {}, the constants {}, the functions {}",
            variables.join(", "),
            constants.join(", "),
            functions.join(", ")
        )
    }

    fn expect(&mut self, wanted: char) -> Result<(), FormulaFault> {
        match self.peek() {
            Some(found) if found == wanted => {
                self.at += wanted.len_utf8();
                Ok(())
            }
            Some(found) => Err(self.fault(format!("`{wanted}` is expected here, not `{found}`"))),
            None => Err(self.fault(format!("`{wanted}` is missing"))),
        }
    }

    fn take_one_of(&mut self, wanted: &str) -> Option<char> {
        let found = self.peek().filter(|found| wanted.contains(*found))?;
        self.at += found.len_utf8();
        Some(found)
    }

    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn fault(&self, problem: String) -> FormulaFault {
        FormulaFault { column: self.text[..self.at].chars().count() + 1, problem }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::variable::VARIABLES;

    const NAMES: Names<'static> =
        Names { variables: &[Variable::Light, Variable::Age], constants: &[("a", 3.0)] };

    fn value(text: &str) -> f32 {
        let mut point = [0.0; VARIABLES];
        point[Variable::Light as usize] = 0.5;
        point[Variable::Age as usize] = 20.0;
        parse(text, NAMES).unwrap_or_else(|fault| panic!("{text}: {fault}")).value(&point)
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2)*3", 9.0),
            ("8 - 3 - 2", 3.0),
            ("16 / 4 / 2", 2.0),
            ("2^3^2", 512.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("2*-3", -6.0),
            ("1e-2 + 1.5E1", 15.01),
            ("a*light", 1.5),
            ("min(age_ms, 7) + max(1, abs(-2))", 9.0),
            ("step(0) + step(-0.1)", 1.0),
            ("exp(log(5)) + sqrt(9)", 8.0),
            ("sin(0) + cos(0)", 1.0),
            (" 1 + 0.2*exp( -age_ms / 20 ) ", 1.073_575_9),
        ] {
            assert!((value(text) - expected).abs() < 1e-5, "{text}: {}", value(text));
        }
    }

    #[test]
    fn a_fault_has_its_column_and_what_is_allowed() {
        for (text, column, problem) in [
            ("1 + ", 5, "missing"),
            ("1 + * 2", 5, "`*` is not expected"),
            ("(1 + 2", 7, "`)` is missing"),
            ("1 2", 3, "`2` is not expected"),
            ("min(1)", 6, "`,` is expected"),
            ("exp 3", 5, "`(` is expected"),
            ("1.2.3", 1, "no number"),
            ("1e99", 1, "no number"),
            ("ü + 1", 1, "`ü` is not expected"),
            ("a + lihgt", 5, "unknown name `lihgt`; the variables here are light, age_ms"),
            ("", 1, "missing"),
        ] {
            let fault = parse(text, NAMES).unwrap_err();
            assert_eq!(fault.column, column, "{text}: {fault}");
            assert!(fault.problem.contains(problem), "{text}: {fault}");
        }
        let deep = format!("{}1{}", "(".repeat(5_000), ")".repeat(5_000));
        assert!(parse(&deep, NAMES).unwrap_err().problem.contains("brackets"));
    }
}
