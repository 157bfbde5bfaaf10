//! The reverse sweep: from weights of the outputs to those of the inputs.
//!
//! With y = f(x) and a weight ȳ of each output, x̄ = (∂f/∂x)ᵀ ȳ. Each node hands its weight on to its operands, times the
//! derivative in each [Griewank, Walther 2008, chapter 3]; the sweep costs a few times what the graph costs, whatever
//! the number of inputs. It is recorded, so that the result is a graph again.

use super::graph::Graph;
use super::number::Traced;
use super::operation::{NodeId, Operation};
use crate::scalar::{One, Scalar, Zero};

impl Graph {
    /// Weights of all inputs for weights of all outputs, in the innermost trace.
    ///
    /// * `values` – of all nodes, from [`replay_nodes`](Self::replay_nodes)
    pub(super) fn reverse_sweep(&self, values: &[Traced], weights: &[Traced]) -> Vec<Traced> {
        let mut bar = vec![Traced::zero(); values.len()];
        for (node, &weight) in self.results().iter().zip(weights) {
            bar[node.index()] += weight;
        }
        let mut out = vec![Traced::zero(); self.n_inputs()];
        for (i, node) in self.nodes().iter().enumerate().rev() {
            if bar[i].is_zero() {
                continue;
            }
            match node {
                Operation::Input(index) => out[*index as usize] = bar[i],
                _ => hand_on(*node, values[i], bar[i], values, &mut bar),
            }
        }
        out
    }

    /// The values of all nodes, in the innermost trace.
    pub(super) fn replay_nodes(&self, inputs: &[Traced]) -> Vec<Traced> {
        let mut values: Vec<Traced> = Vec::with_capacity(self.nodes().len());
        for node in self.nodes() {
            let known = node.map(|x| values[x.index()]);
            values.push(known.apply(inputs));
        }
        for own in self.conditions() {
            values[own.node.index()].is_at_most(own.limit, &own.condition);
        }
        values
    }
}

/// Adds w ∂y/∂x to the weight of each operand x of a node with the value y and the weight w.
fn hand_on(node: Operation, y: Traced, w: Traced, values: &[Traced], bar: &mut [Traced]) {
    use Operation::{
        Acos, Add, Asin, Atan2, Constant, Cos, Div, Exp, Input, Ln, Mul, MulAdd, MulSub, Neg,
        NegMulAdd, SelectLt, Sin, Sqrt, Sub, Tanh,
    };
    let value = |x: NodeId| values[x.index()];
    let mut add = |x: NodeId, weight: Traced| bar[x.index()] += weight;
    match node {
        Constant(_) | Input(_) => {}
        Neg(a) => add(a, -w),
        Add(a, b) => {
            add(a, w);
            add(b, w);
        }
        Sub(a, b) => {
            add(a, w);
            add(b, -w);
        }
        Mul(a, b) => product(bar, [a, b], values, w),
        MulAdd(a, b, c) | MulSub(a, b, c) => {
            let is_sum = matches!(node, MulAdd(..));
            add(c, if is_sum { w } else { -w });
            product(bar, [a, b], values, w);
        }
        NegMulAdd(a, b, c) => {
            add(c, w);
            product(bar, [a, b], values, -w);
        }
        Div(a, b) => {
            let share = w / value(b);
            add(a, share);
            add(b, -(share * y));
        }
        Sqrt(a) => add(a, w * 0.5 / y),
        Sin(a) => add(a, w * value(a).sin_cos().1),
        Cos(a) => add(a, -(w * value(a).sin_cos().0)),
        Exp(a) => add(a, w * y),
        Ln(a) => add(a, w / value(a)),
        Atan2(a, b) => {
            let (a_value, b_value) = (value(a), value(b));
            let share = w / a_value.mul_add(a_value, b_value * b_value);
            add(a, share * b_value);
            add(b, -(share * a_value));
        }
        Asin(a) => add(a, w / across(value(a))),
        Acos(a) => add(a, -(w / across(value(a)))),
        Tanh(a) => add(a, w * slope_of_tanh(value(a))),
        SelectLt(a, b, x, other) => {
            let (a, b, zero) = (value(a), value(b), Traced::zero());
            add(x, a.select_lt(b, w, zero));
            add(other, a.select_lt(b, zero, w));
        }
    }
}

/// Of a product with the weight w.
fn product(bar: &mut [Traced], [a, b]: [NodeId; 2], values: &[Traced], w: Traced) {
    let (x, y) = (values[a.index()], values[b.index()]);
    bar[a.index()] = w.mul_add(y, bar[a.index()]);
    bar[b.index()] = w.mul_add(x, bar[b.index()]);
}

/// √(1 − x²)
fn across(x: Traced) -> Traced {
    ((-x + 1.0) * (x + 1.0)).sqrt()
}

/// 4 e / (1 + e)² with e = e⁻²|ˣ|, which has all its digits however flat it is.
fn slope_of_tanh(x: Traced) -> Traced {
    let e = (x.abs() * -2.0).exp();
    let below = e + Traced::one();
    e * 4.0 / (below * below)
}
