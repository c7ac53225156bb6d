//! A formula as a program for a stack machine, of one pixel or of rows of pixels.

use super::variable::{MAX_AGE_MS, Point, VARIABLES, Variable};

/// Pixels that an operation takes together: a stack of them stays in the first-level cache.
const ROW: usize = 64;

/// Combinations of values at which a formula is tried before it is used.
const MAX_TRIED: usize = 20_000;

/// One step of a program: takes its operands off the stack and puts its result there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Operation {
    Constant(f32),
    Variable(Variable),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Call(Function),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Exp,
    Log,
    Sqrt,
    Abs,
    Sin,
    Cos,
    Step,
    Min,
    Max,
}

impl Function {
    pub(crate) const ALL: [Self; 9] = [
        Self::Exp,
        Self::Log,
        Self::Sqrt,
        Self::Abs,
        Self::Sin,
        Self::Cos,
        Self::Step,
        Self::Min,
        Self::Max,
    ];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Exp => "exp",
            Self::Log => "log",
            Self::Sqrt => "sqrt",
            Self::Abs => "abs",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Step => "step",
            Self::Min => "min",
            Self::Max => "max",
        }
    }

    pub(crate) const fn arguments(self) -> usize {
        if matches!(self, Self::Min | Self::Max) { 2 } else { 1 }
    }
}

/// A checked sequence of operations, at the end of which one value is left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Program {
    operations: Vec<Operation>,
    /// The most values on the stack.
    depth: usize,
}

/// Values of one variable for consecutive pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Input<'a> {
    /// The same for all.
    Even(f32),
    /// One for each.
    Each(&'a [f32]),
}

/// Values of all variables, by their index.
pub(crate) type Inputs<'a> = [Input<'a>; VARIABLES];

impl Program {
    /// `operations` leave one value on the stack, as those of the parser do.
    pub(super) fn new(operations: Vec<Operation>) -> Self {
        let (mut height, mut depth) = (0_usize, 0);
        for operation in &operations {
            height = height + 1 - operation.operands();
            depth = depth.max(height);
        }
        Self { operations, depth }
    }

    pub(crate) fn uses(&self, variable: Variable) -> bool {
        self.operations.contains(&Operation::Variable(variable))
    }

    /// Value at one point.
    pub(crate) fn value(&self, point: &Point) -> f32 {
        let inputs: Inputs<'_> = point.map(Input::Even);
        let mut value = [0.0];
        self.rows(&inputs, &mut value);
        value[0]
    }

    /// Values for consecutive pixels.
    pub(crate) fn rows(&self, inputs: &Inputs<'_>, values: &mut [f32]) {
        let row = ROW.min(values.len());
        let mut stack = vec![0.0; (self.depth + 1) * row];
        let mut first = 0;
        for out in values.chunks_mut(ROW) {
            let pixels = out.len();
            let mut height = 0;
            for operation in &self.operations {
                height -= operation.operands().min(height);
                let (below, above) = stack[height * row..].split_at_mut(row);
                let x = &mut below[..pixels];
                operation.apply(inputs, first, x, &above[..pixels.min(above.len())]);
                height += 1;
            }
            out.copy_from_slice(&stack[..pixels]);
            first += pixels;
        }
    }

    /// The first point among samples of the variables at which the value is not finite, in words.
    pub(crate) fn first_not_finite(&self) -> Option<String> {
        let used: Vec<Variable> =
            Variable::ALL.into_iter().filter(|variable| self.uses(*variable)).collect();
        let all: usize = used.iter().map(|variable| variable.samples().len()).product();
        (0..all.min(MAX_TRIED)).find_map(|mut number| {
            let mut point = [0.0; VARIABLES];
            point[Variable::Age as usize] = MAX_AGE_MS;
            for variable in &used {
                let samples = variable.samples();
                point[*variable as usize] = samples[number % samples.len()];
                number /= samples.len();
            }
            let value = self.value(&point);
            let at = |v: &Variable| format!("{} = {}", v.name(), point[*v as usize]);
            let place = used.iter().map(at).collect::<Vec<_>>().join(", ");
            let place = if place.is_empty() { place } else { format!(" at {place}") };
            (!value.is_finite()).then(|| format!("is {value}{place}"))
        })
    }
}

impl Operation {
    const fn operands(self) -> usize {
        match self {
            Self::Constant(_) | Self::Variable(_) => 0,
            Self::Negate => 1,
            Self::Add | Self::Subtract | Self::Multiply | Self::Divide | Self::Power => 2,
            Self::Call(function) => function.arguments(),
        }
    }

    /// Applies it to operands `x` and `y` of consecutive pixels, the first of which has index `first`
    /// in the inputs. The result takes the place of `x`.
    fn apply(self, inputs: &Inputs<'_>, first: usize, x: &mut [f32], y: &[f32]) {
        let one = |x: &mut [f32], of: fn(f32) -> f32| x.iter_mut().for_each(|x| *x = of(*x));
        let two = |x: &mut [f32], of: fn(f32, f32) -> f32| {
            x.iter_mut().zip(y).for_each(|(x, y)| *x = of(*x, *y));
        };
        match self {
            Self::Constant(value) => x.fill(value),
            Self::Variable(variable) => match inputs[variable as usize] {
                Input::Even(value) => x.fill(value),
                Input::Each(values) => x.copy_from_slice(&values[first..first + x.len()]),
            },
            Self::Negate => one(x, |x| -x),
            Self::Add => two(x, |x, y| x + y),
            Self::Subtract => two(x, |x, y| x - y),
            Self::Multiply => two(x, |x, y| x * y),
            Self::Divide => two(x, |x, y| x / y),
            Self::Power => two(x, f32::powf),
            Self::Call(Function::Exp) => one(x, f32::exp),
            Self::Call(Function::Log) => one(x, f32::ln),
            Self::Call(Function::Sqrt) => one(x, f32::sqrt),
            Self::Call(Function::Abs) => one(x, f32::abs),
            Self::Call(Function::Sin) => one(x, f32::sin),
            Self::Call(Function::Cos) => one(x, f32::cos),
            Self::Call(Function::Step) => one(x, |x| f32::from(u8::from(x >= 0.0))),
            Self::Call(Function::Min) => two(x, f32::min),
            Self::Call(Function::Max) => two(x, f32::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::expression::{Names, parse};
    use super::*;

    fn program(text: &str) -> Program {
        parse(text, Names { variables: &Variable::ALL, constants: &[] }).unwrap()
    }

    #[test]
    fn rows_have_the_values_of_their_pixels() {
        let program = program("max(light, 0.1)^2 - exp(-age_ms/30)*(1 + row/(light + 1))");
        for pixels in [1, 63, 64, 65, 300] {
            let plane = |k: f32| (0..pixels).map(|i| i as f32 * k).collect::<Vec<f32>>();
            let (light, age) = (plane(0.01), plane(1.0));
            let mut inputs = [Input::Even(0.5); VARIABLES];
            inputs[Variable::Light as usize] = Input::Each(&light);
            inputs[Variable::Age as usize] = Input::Each(&age);
            let mut values = vec![0.0; pixels];
            program.rows(&inputs, &mut values);
            for (i, value) in values.iter().enumerate() {
                let mut point = [0.5; VARIABLES];
                point[Variable::Light as usize] = light[i];
                point[Variable::Age as usize] = age[i];
                assert_eq!(*value, program.value(&point), "{pixels} {i}");
                let (i, t) = (light[i], age[i]);
                let expected = i.max(0.1).powi(2) - (-t / 30.0).exp() * (1.0 + 0.5 / (i + 1.0));
                assert!((value - expected).abs() < 1e-5, "{value} {expected}");
            }
        }
    }

    #[test]
    fn a_formula_that_is_not_finite_somewhere_says_where() {
        let not_finite = |text: &str| program(text).first_not_finite();
        assert_eq!(not_finite("log(light)").unwrap(), "is -inf at light = 0");
        assert_eq!(not_finite("sqrt(-1)").unwrap(), "is NaN");
        assert!(not_finite("1/last_polarity").unwrap().contains("last_polarity = 0"));
        assert_eq!(not_finite("log(light + 0.001)*exp(-age_ms/30) + 1/(1 + time_s)"), None);
    }
}
