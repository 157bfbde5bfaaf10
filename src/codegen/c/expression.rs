//! An operation as an expression.

use super::precision::Precision;
use crate::scalar::traced::Operation;

/// Words of a function for a precision.
pub(super) struct Words<'a> {
    pub(super) precision: Precision,
    /// Prefix of names, in capitals.
    pub(super) prefix: &'a str,
    /// The expression of each input.
    pub(super) inputs: Vec<String>,
    /// Factor of the index of an output, or of a number that waits for a later part: its distance from the one before.
    pub(super) stride: &'static str,
}

impl Words<'_> {
    /// A number of the precision that is read back as itself.
    pub(super) fn number(&self, x: f64) -> String {
        let x = match self.precision {
            Precision::Double => x,
            Precision::Single => f64::from(x as f32),
        };
        let size = match (x.abs(), self.precision) {
            (size, _) if size.is_nan() => return "NAN".to_owned(),
            (f64::INFINITY, _) => "INFINITY".to_owned(),
            (size, Precision::Double) => format!("{size:e}"),
            (size, Precision::Single) => format!("{:e}f", size as f32),
        };
        if x < 0.0 { format!("(-{size})") } else { size }
    }

    /// The place of an output.
    pub(super) fn output(&self, k: usize) -> String {
        format!("out[{k}{}]", self.stride)
    }

    /// The place of a number that waits for a later part.
    pub(super) fn waiting(&self, slot: usize) -> String {
        format!("w[{slot}{}]", self.stride)
    }

    /// A function of the C library.
    fn function(&self, name: &str) -> String {
        match self.precision {
            Precision::Double => name.to_owned(),
            Precision::Single => format!("{name}f"),
        }
    }

    /// An operation on expressions that bind as names do.
    pub(super) fn expression(&self, operation: &Operation<String>) -> String {
        let call = |name: &str, x: &str| format!("{}({x})", self.function(name));
        let fma = |a: &str, b: &str, c: &str| format!("{}_FMA({a}, {b}, {c})", self.prefix);
        match operation {
            Operation::Constant(bits) => self.number(f64::from_bits(*bits)),
            Operation::Input(i) => self.inputs[*i as usize].clone(),
            Operation::Neg(a) => format!("-{a}"),
            Operation::Add(a, b) => format!("{a} + {b}"),
            Operation::Sub(a, b) => format!("{a} - {b}"),
            Operation::Mul(a, b) => format!("{a} * {b}"),
            Operation::Div(a, b) => format!("{a} / {b}"),
            Operation::MulAdd(a, b, c) => fma(a, b, c),
            Operation::MulSub(a, b, c) => fma(a, b, &format!("-{c}")),
            Operation::NegMulAdd(a, b, c) => fma(&format!("-{a}"), b, c),
            Operation::Sqrt(a) => call("sqrt", a),
            Operation::Sin(a) => call("sin", a),
            Operation::Cos(a) => call("cos", a),
            Operation::Exp(a) => call("exp", a),
            Operation::Ln(a) => call("log", a),
            Operation::Atan2(a, b) => call("atan2", &format!("{a}, {b}")),
            Operation::Asin(a) => call("asin", a),
            Operation::Acos(a) => call("acos", a),
            Operation::Tanh(a) => call("tanh", a),
            Operation::SelectLt(a, b, x, y) => format!("{a} < {b} ? {x} : {y}"),
        }
    }
}
