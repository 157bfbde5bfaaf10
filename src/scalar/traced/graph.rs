//! The graph: nodes in the order of evaluation.

use std::fmt;

use super::operation::{NodeId, Operation};
use super::port::{Port, find};
use super::program::Program;
use super::recording::{Condition, Recording};
use super::schedule::schedule;
use crate::error::UnknownName;

/// A computation as a graph of operations on numbers; [`trace`](super::trace) makes one.
///
/// Constants come first, then inputs, then operations, each after its operands, in an order with few simultaneously alive results.
#[derive(Clone, Debug)]
pub struct Graph {
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    nodes: Vec<Operation>,
    results: Vec<NodeId>,
    conditions: Vec<Condition>,
    pub(super) program: Program,
    origin: Option<Origin>,
}

/// The robot of a graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Name of the robot.
    pub name: String,
    /// Fingerprint of the robot: with high probability different for another robot or after a change.
    pub fingerprint: u64,
}

/// Numbers of nodes by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Constants.
    pub constants: usize,
    /// Entries of the inputs, used or not.
    pub inputs: usize,
    /// Sums, differences and signs.
    pub sums: usize,
    /// Products.
    pub products: usize,
    /// Fused multiply-adds, which are one instruction on many CPUs.
    pub fused_products: usize,
    /// Quotients and square roots.
    pub divisions: usize,
    /// Sines, cosines, and other functions.
    pub functions: usize,
    /// Selections by a comparison.
    pub selections: usize,
}

impl Counts {
    /// Number of operations: nodes without constants and inputs.
    pub fn operations(&self) -> usize {
        let simple = self.sums + self.products + self.fused_products;
        simple + self.divisions + self.functions + self.selections
    }
}

impl Graph {
    /// The computation of a recording, without what no output depends on.
    pub(super) fn new(
        inputs: Vec<Port>,
        outputs: Vec<Port>,
        recording: &Recording,
        results: &[NodeId],
    ) -> Self {
        let conditions = recording.conditions.iter();
        let wanted: Vec<NodeId> = results
            .iter()
            .copied()
            .chain(conditions.map(|c| c.node))
            .collect();
        let n_inputs = inputs.iter().map(Port::len).sum();
        let ordered = schedule(&recording.nodes, &wanted, n_inputs);
        let place = |node: NodeId| ordered.places[node.index()];
        let conditions = recording.conditions.iter().map(|c| Condition {
            node: place(c.node),
            ..c.clone()
        });
        let conditions: Vec<_> = conditions.collect();
        let results: Vec<_> = results.iter().map(|&node| place(node)).collect();
        let kept = results
            .iter()
            .copied()
            .chain(conditions.iter().map(|c| c.node));
        Self {
            program: Program::new(&ordered.nodes, kept),
            nodes: ordered.nodes,
            inputs,
            outputs,
            results,
            conditions,
            origin: None,
        }
    }

    /// Notes of which robot the graph is; generated code says so.
    #[must_use]
    pub(crate) fn with_origin(mut self, origin: Origin) -> Self {
        self.origin = Some(origin);
        self
    }

    /// The robot of the graph, if known.
    pub fn origin(&self) -> Option<&Origin> {
        self.origin.as_ref()
    }

    /// The inputs in order.
    pub fn inputs(&self) -> &[Port] {
        &self.inputs
    }

    /// The outputs in order.
    pub fn outputs(&self) -> &[Port] {
        &self.outputs
    }

    /// Number of entries of all inputs.
    pub fn n_inputs(&self) -> usize {
        self.inputs.iter().map(Port::len).sum()
    }

    /// Number of entries of all outputs.
    pub fn n_outputs(&self) -> usize {
        self.results.len()
    }

    /// All nodes: constants, then inputs, then operations.
    #[doc(hidden)]
    pub fn nodes(&self) -> &[Operation] {
        &self.nodes
    }

    /// The node of each entry of the outputs.
    #[doc(hidden)]
    pub fn results(&self) -> &[NodeId] {
        &self.results
    }

    /// Assumptions of the graph.
    pub fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// Maximum number of simultaneously alive results of operations, without inputs and constants.
    #[doc(hidden)]
    pub fn live_values(&self) -> usize {
        self.program.live_values()
    }

    /// Counts the nodes.
    pub fn counts(&self) -> Counts {
        use Operation::{
            Acos, Add, Asin, Atan2, Constant, Cos, Div, Exp, Input, Ln, Mul, MulAdd, MulSub, Neg,
            NegMulAdd, SelectLt, Sin, Sqrt, Sub, Tanh,
        };
        let mut out = Counts::default();
        for node in &self.nodes {
            let count = match node {
                Constant(_) => &mut out.constants,
                Input(_) => &mut out.inputs,
                Neg(_) | Add(..) | Sub(..) => &mut out.sums,
                Mul(..) => &mut out.products,
                MulAdd(..) | MulSub(..) | NegMulAdd(..) => &mut out.fused_products,
                Div(..) | Sqrt(_) => &mut out.divisions,
                Sin(_) | Cos(_) | Exp(_) | Ln(_) | Atan2(..) | Asin(_) | Acos(_) | Tanh(_) => {
                    &mut out.functions
                }
                SelectLt(..) => &mut out.selections,
            };
            *count += 1;
        }
        out
    }

    /// The input of this name, with the index of its first entry among all inputs.
    ///
    /// # Errors
    /// If there is no input with this name.
    pub fn input(&self, name: &str) -> Result<(&Port, usize), UnknownName> {
        find(&self.inputs, name).ok_or_else(|| self.unknown("input", name, &self.inputs))
    }

    /// The output of this name, with the index of its first entry among all outputs.
    ///
    /// # Errors
    /// If there is no output with this name.
    pub fn output(&self, name: &str) -> Result<(&Port, usize), UnknownName> {
        find(&self.outputs, name).ok_or_else(|| self.unknown("output", name, &self.outputs))
    }

    fn unknown(&self, element: &str, name: &str, known: &[Port]) -> UnknownName {
        let origin = self.origin.as_ref();
        UnknownName {
            model: origin.map_or("a graph", |origin| &origin.name).to_owned(),
            element: element.to_owned(),
            name: name.to_owned(),
            known: known.iter().map(|port| port.name.to_owned()).collect(),
        }
    }
}

/// Prints the graph, a node a line.
impl fmt::Display for Graph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, node) in self.nodes.iter().enumerate() {
            match node {
                Operation::Constant(bits) => writeln!(f, "%{k} = {:?}", f64::from_bits(*bits))?,
                Operation::Input(i) => writeln!(f, "%{k} = {}", entry(&self.inputs, *i as usize))?,
                other => {
                    let name = format!("{:?}", other.map(|_| ()));
                    let name = name.split('(').next().unwrap_or_default();
                    let operands: Vec<_> = other.operands().map(|x| format!("%{}", x.0)).collect();
                    writeln!(f, "%{k} = {name} {}", operands.join(" "))?;
                }
            }
        }
        for (k, node) in self.results.iter().enumerate() {
            writeln!(f, "{} = %{}", entry(&self.outputs, k), node.0)?;
        }
        for Condition {
            node,
            limit,
            condition,
        } in &self.conditions
        {
            writeln!(f, "granted: %{} <= {limit:?}, {condition}", node.0)?;
        }
        Ok(())
    }
}

/// Name of a number among those of all ports.
fn entry(ports: &[Port], mut index: usize) -> String {
    for port in ports {
        if index < port.len() {
            return format!("{}[{index}]", &port.name);
        }
        index -= port.len();
    }
    "?".to_owned()
}
