//! Numbers that record how they came about, so that the same can be done with others.

use dualbody::Scalar;
use dualbody::scalar::{One, Zero};
use std::cell::RefCell;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A node of the graph of its thread, with its value at the point of recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Traced {
    node: usize,
    value: f64,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Input(usize),
    Constant(f64),
    One(fn(f64) -> f64, usize),
    Two(fn(f64, f64) -> f64, usize, usize),
    /// if a < b { c } else { d }
    Select([usize; 4]),
}

thread_local! {
    static GRAPH: RefCell<Vec<Node>> = const { RefCell::new(Vec::new()) };
}

/// Discards the recording of this thread, and makes inputs with these values.
pub(super) fn record(values: &[f64]) -> Vec<Traced> {
    GRAPH.with_borrow_mut(Vec::clear);
    let inputs = values.iter().enumerate();
    inputs
        .map(|(i, &value)| push(Node::Input(i), value))
        .collect()
}

/// The recorded graph at other inputs.
pub(super) fn replay(inputs: &[f64], outputs: &[Traced]) -> Vec<f64> {
    let graph = GRAPH.with_borrow(Vec::clone);
    let mut x: Vec<f64> = Vec::with_capacity(graph.len());
    for node in graph {
        x.push(match node {
            Node::Input(i) => inputs[i],
            Node::Constant(value) => value,
            Node::One(f, a) => f(x[a]),
            Node::Two(f, a, b) => f(x[a], x[b]),
            Node::Select([a, b, c, d]) => x[if x[a] < x[b] { c } else { d }],
        });
    }
    outputs.iter().map(|output| x[output.node]).collect()
}

fn push(node: Node, value: f64) -> Traced {
    GRAPH.with_borrow_mut(|graph| {
        graph.push(node);
        Traced {
            node: graph.len() - 1,
            value,
        }
    })
}

fn one(f: fn(f64) -> f64, x: Traced) -> Traced {
    push(Node::One(f, x.node), f(x.value))
}

fn two(f: fn(f64, f64) -> f64, x: Traced, y: Traced) -> Traced {
    push(Node::Two(f, x.node, y.node), f(x.value, y.value))
}

impl From<f64> for Traced {
    fn from(x: f64) -> Self {
        push(Node::Constant(x), x)
    }
}

super::operators! {
    Traced;
    Add add AddAssign add_assign |x, y| two(|x, y| x + y, x, y);
    Sub sub SubAssign sub_assign |x, y| two(|x, y| x - y, x, y);
    Mul mul MulAssign mul_assign |x, y| two(|x, y| x * y, x, y);
    Div div DivAssign div_assign |x, y| two(|x, y| x / y, x, y);
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        one(|x| -x, self)
    }
}

impl Scalar for Traced {
    fn value(&self, _: usize) -> f64 {
        self.value
    }

    fn sqrt(self) -> Self {
        one(f64::sqrt, self)
    }

    // With the functions of the crate, whose last digit is not that of the library.
    fn sin_cos(self) -> (Self, Self) {
        let sin = one(|x| Scalar::sin_cos(x).0, self);
        (sin, one(|x| Scalar::sin_cos(x).1, self))
    }

    fn exp(self) -> Self {
        one(f64::exp, self)
    }

    fn ln(self) -> Self {
        one(f64::ln, self)
    }

    fn atan2(self, x: Self) -> Self {
        two(f64::atan2, self, x)
    }

    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        let value = if self.value < other.value { a } else { b }.value;
        let nodes = [self, other, a, b].map(|x| x.node);
        push(Node::Select(nodes), value)
    }
}
