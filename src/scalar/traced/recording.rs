//! Nodes as they are recorded: each expression once, folded where numbers are known.
//!
//! Rules, in the order in which they are tried: operations on constants are done at once; x + 0, x · 1, x · 0, 0 / x,
//! x − x, x / x and x / 2ᵏ are simplified, numbers taken to be finite; signs move outward, so that −a · b, a · −b and
//! −(a · b) are one node; sums and products know no order; a fused product whose product is there already is a sum; of
//! two selections by one comparison, one inside the other, the inner is resolved. An expression that is there already
//! is not recorded again. No rule changes a result by more than the sign of a zero and where a product is rounded.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::operation::{NodeId, Operation};
use Operation::{
    Add, Constant, Cos, Div, Input, Mul, MulAdd, MulSub, Neg, NegMulAdd, SelectLt, Sin, Sub,
};

/// Condition of a graph: a number is at most a limit. If it is violated, the outputs differ from the recorded computation.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The number.
    pub node: NodeId,
    /// Its upper limit.
    pub limit: f64,
    /// Its meaning, as text.
    pub condition: String,
}

/// A recording that goes on.
#[derive(Debug, Default)]
pub(super) struct Recording {
    /// Differs between any two of a thread.
    pub(super) id: u32,
    pub(super) nodes: Vec<Operation>,
    known: HashMap<Operation, NodeId, BuildHasherDefault<Mixer>>,
    pub(super) conditions: Vec<Condition>,
}

/// A fast hash of small keys that is the same in every run; nothing depends on the order in which they come out.
#[derive(Debug, Default)]
struct Mixer(u64);

/// 2⁶⁴ over the golden ratio, odd: spreads neighbours [Knuth 1998, section 6.4].
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

impl Hasher for Mixer {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u32(&mut self, x: u32) {
        self.write_u64(x.into());
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(26) ^ x).wrapping_mul(SPREAD);
    }

    fn write_isize(&mut self, x: isize) {
        self.write_u64(x as u64);
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}

impl Recording {
    pub(super) fn new(id: u32) -> Self {
        Self {
            id,
            ..Self::default()
        }
    }

    /// The node of an operation, recorded if it is new.
    fn put(&mut self, operation: Operation) -> NodeId {
        let next = NodeId::from(self.nodes.len());
        let node = *self.known.entry(operation).or_insert(next);
        if node == next {
            self.nodes.push(operation);
        }
        node
    }

    fn find(&self, operation: Operation) -> Option<NodeId> {
        self.known.get(&operation).copied()
    }

    fn at(&self, node: NodeId) -> Operation {
        self.nodes[node.index()]
    }

    /// The number of a node that is one.
    pub(super) fn number(&self, node: NodeId) -> Option<f64> {
        match self.at(node) {
            Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(super) fn constant(&mut self, x: f64) -> NodeId {
        // One zero.
        let x = if x == 0.0 { 0.0 } else { x };
        self.put(Constant(x.to_bits()))
    }

    pub(super) fn input(&mut self, index: u32) -> NodeId {
        self.put(Input(index))
    }

    pub(super) fn neg(&mut self, a: NodeId) -> NodeId {
        match self.at(a) {
            Constant(bits) => self.constant(-f64::from_bits(bits)),
            Neg(a) => a,
            Sub(a, b) => self.put(Sub(b, a)),
            MulSub(a, b, c) => self.put(NegMulAdd(a, b, c)),
            NegMulAdd(a, b, c) => self.put(MulSub(a, b, c)),
            _ => self.put(Neg(a)),
        }
    }

    /// The node without its sign, and whether it had one.
    fn unsigned(&self, a: NodeId) -> (NodeId, bool) {
        match self.at(a) {
            Neg(a) => (a, true),
            _ => (a, false),
        }
    }

    pub(super) fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if let (Some(x), Some(y)) = (self.number(a), self.number(b)) {
            return self.constant(x + y);
        }
        if self.number(a) == Some(0.0) {
            return b;
        }
        if self.number(b) == Some(0.0) {
            return a;
        }
        match (self.unsigned(a), self.unsigned(b)) {
            ((a, true), (b, true)) => {
                let sum = self.add(a, b);
                self.neg(sum)
            }
            ((a, true), (b, false)) => self.sub(b, a),
            ((a, false), (b, true)) => self.sub(a, b),
            ((a, false), (b, false)) => self.put(Add(a.min(b), a.max(b))),
        }
    }

    pub(super) fn sub(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if a == b {
            return self.constant(0.0);
        }
        if let (Some(x), Some(y)) = (self.number(a), self.number(b)) {
            return self.constant(x - y);
        }
        if self.number(a) == Some(0.0) {
            return self.neg(b);
        }
        if self.number(b) == Some(0.0) {
            return a;
        }
        match (self.unsigned(a), self.unsigned(b)) {
            ((a, true), (b, true)) => self.sub(b, a),
            ((a, true), (b, false)) => {
                let sum = self.add(a, b);
                self.neg(sum)
            }
            ((a, false), (b, true)) => self.add(a, b),
            ((a, false), (b, false)) => match self.find(Sub(b, a)) {
                Some(opposite) => self.put(Neg(opposite)),
                None => self.put(Sub(a, b)),
            },
        }
    }

    pub(super) fn mul(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let (x, y) = (self.number(a), self.number(b));
        if let (Some(x), Some(y)) = (x, y) {
            return self.constant(x * y);
        }
        for (x, other) in [(x, b), (y, a)] {
            match x {
                Some(0.0) => return self.constant(0.0),
                Some(1.0) => return other,
                Some(-1.0) => return self.neg(other),
                Some(x) if x < 0.0 => {
                    let positive = self.constant(-x);
                    let product = self.mul(positive, other);
                    return self.neg(product);
                }
                _ => {}
            }
        }
        let ((a, minus_a), (b, minus_b)) = (self.unsigned(a), self.unsigned(b));
        let product = self.put(Mul(a.min(b), a.max(b)));
        self.signed(product, minus_a != minus_b)
    }

    fn signed(&mut self, a: NodeId, negative: bool) -> NodeId {
        if negative { self.neg(a) } else { a }
    }

    pub(super) fn div(&mut self, a: NodeId, b: NodeId) -> NodeId {
        if a == b {
            return self.constant(1.0);
        }
        if let (Some(x), Some(y)) = (self.number(a), self.number(b)) {
            return self.constant(x / y);
        }
        if self.number(a) == Some(0.0) {
            return self.constant(0.0);
        }
        if let Some(inverse) = self.number(b).and_then(exact_inverse) {
            let inverse = self.constant(inverse);
            return self.mul(a, inverse);
        }
        let ((a, minus_a), (b, minus_b)) = (self.unsigned(a), self.unsigned(b));
        let quotient = self.put(Div(a, b));
        self.signed(quotient, minus_a != minus_b)
    }

    /// a b + c
    pub(super) fn mul_add(&mut self, a: NodeId, b: NodeId, c: NodeId) -> NodeId {
        let simple = |x: Option<f64>| x.is_some_and(|x| x == 0.0 || x.abs() == 1.0);
        let (x, y) = (self.number(a), self.number(b));
        if simple(x) || simple(y) || (x.is_some() && y.is_some()) || self.number(c) == Some(0.0) {
            let product = self.mul(a, b);
            return self.add(product, c);
        }
        let ((a, minus_a), (b, minus_b)) = (self.positive(a), self.positive(b));
        let (c, minus_c) = self.positive(c);
        let (a, b) = (a.min(b), a.max(b));
        if let Some(product) = self.find(Mul(a, b)) {
            let product = self.signed(product, minus_a != minus_b);
            let c = self.signed(c, minus_c);
            return self.add(product, c);
        }
        match (minus_a != minus_b, minus_c) {
            (false, false) => self.put(MulAdd(a, b, c)),
            (false, true) => self.put(MulSub(a, b, c)),
            (true, false) => self.put(NegMulAdd(a, b, c)),
            (true, true) => {
                let sum = self.put(MulAdd(a, b, c));
                self.neg(sum)
            }
        }
    }

    /// A node without its sign, also where it is a number.
    fn positive(&mut self, a: NodeId) -> (NodeId, bool) {
        match self.number(a) {
            Some(x) if x < 0.0 => (self.constant(-x), true),
            _ => self.unsigned(a),
        }
    }

    /// A function of one number that nothing is known of.
    pub(super) fn function(&mut self, operation: Operation) -> NodeId {
        let numbers: Option<Vec<f64>> = operation.operands().map(|x| self.number(x)).collect();
        match numbers {
            Some(numbers) => {
                let mut next = numbers.into_iter();
                let known = operation.map(|_| next.next().unwrap_or(f64::NAN));
                self.constant(known.apply(&[]))
            }
            None => self.put(operation),
        }
    }

    /// Sine and cosine, always both: what is not used is left out of the graph.
    pub(super) fn sin_cos(&mut self, a: NodeId) -> (NodeId, NodeId) {
        let (angle, negative) = self.unsigned(a);
        let (sin, cos) = (self.function(Sin(angle)), self.function(Cos(angle)));
        (self.signed(sin, negative), cos)
    }

    pub(super) fn select_lt(&mut self, a: NodeId, b: NodeId, x: NodeId, y: NodeId) -> NodeId {
        if x == y || a == b {
            return y;
        }
        if let (Some(a), Some(b)) = (self.number(a), self.number(b)) {
            return if a < b { x } else { y };
        }
        let chosen = match self.at(x) {
            SelectLt(c, d, x, _) if (c, d) == (a, b) => x,
            _ => x,
        };
        let other = match self.at(y) {
            SelectLt(c, d, _, y) if (c, d) == (a, b) => y,
            _ => y,
        };
        if chosen == other {
            return other;
        }
        self.put(SelectLt(a, b, chosen, other))
    }
}

/// 1 / x, where it is a number without rounding: for powers of two.
fn exact_inverse(x: f64) -> Option<f64> {
    const MANTISSA: u64 = (1 << 52) - 1;
    let inverse = 1.0 / x;
    let exact = x.is_normal() && inverse.is_normal() && x.to_bits() & MANTISSA == 0;
    exact.then_some(inverse)
}
