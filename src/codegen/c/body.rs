//! The statements of a function, part by part.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::Range;

use super::expression::Words;
use super::parts::Parts;
use crate::nested::IntoNested;
use crate::scalar::traced::{Graph, NodeId, Operation};

/// A graph as statements.
pub(super) struct Body<'a> {
    graph: &'a Graph,
    words: Words<'a>,
    parts: Parts,
    /// The outputs that each node is.
    outputs: BTreeMap<usize, Vec<usize>>,
}

impl<'a> Body<'a> {
    /// * `length` – most operations of a part
    pub(super) fn new(graph: &'a Graph, words: Words<'a>, length: usize) -> Self {
        let mut outputs: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, node) in graph.results().iter().enumerate() {
            outputs.entry(node.index()).or_default().push(k);
        }
        Self {
            parts: Parts::of(graph, length),
            graph,
            words,
            outputs,
        }
    }

    /// Whether there is more than one part.
    pub(super) fn is_split(&self) -> bool {
        self.parts.ranges.len() > 1
    }

    /// Number of parts.
    pub(super) fn parts(&self) -> usize {
        self.parts.ranges.len()
    }

    /// Length of the array in which numbers wait for later parts.
    pub(super) fn waiting(&self) -> usize {
        self.parts.size
    }

    /// Name of a node, or its number where it is given.
    fn operand(&self, node: NodeId) -> String {
        match self.graph.nodes()[node.index()] {
            Operation::Constant(bits) => self.words.number(f64::from_bits(bits)),
            Operation::Input(i) => self.words.inputs[i as usize].clone(),
            _ => format!("t{}", node.index()),
        }
    }

    /// The statements of a part: what earlier ones have found, its own, what later ones need, the outputs.
    pub(super) fn part(&self, part: usize) -> String {
        let (range, mut out) = (self.parts.ranges[part].clone(), String::new());
        for (node, slot) in self.taken(&range) {
            let place = self.words.waiting(slot);
            line(&mut out, &format!("const REAL t{node} = {place};"));
        }
        for i in range {
            let operation = self.graph.nodes()[i].map(|x| self.operand(x));
            let own = self.words.expression(&operation);
            line(&mut out, &format!("const REAL t{i} = {own};"));
            if let Some(slot) = self.parts.slot(NodeId::from(i)) {
                line(&mut out, &format!("{} = t{i};", self.words.waiting(slot)));
            }
            for k in self.outputs.get(&i).into_iter().flatten() {
                line(&mut out, &format!("{} = t{i};", self.words.output(*k)));
            }
        }
        out
    }

    /// Nodes of earlier parts that a part uses, with where they wait.
    fn taken(&self, range: &Range<usize>) -> Vec<(usize, usize)> {
        let nodes = &self.graph.nodes()[range.clone()];
        let used = nodes.iter().nested(Operation::operands);
        let earlier: BTreeSet<NodeId> = used.filter(|x| x.index() < range.start).collect();
        let waiting = earlier.into_iter();
        waiting
            .filter_map(|x| Some((x.index(), self.parts.slot(x)?)))
            .collect()
    }

    /// Outputs that are inputs or constants.
    pub(super) fn given_outputs(&self) -> String {
        let mut out = String::new();
        for (&i, outputs) in &self.outputs {
            if self.graph.nodes()[i].is_given() {
                let own = self.operand(NodeId::from(i));
                for k in outputs {
                    line(&mut out, &format!("{} = {own};", self.words.output(*k)));
                }
            }
        }
        out
    }

    /// Returns the number of the first condition that does not hold, or 0.
    pub(super) fn status(&self) -> String {
        let mut out = String::new();
        for (index, own) in self.graph.conditions().iter().enumerate() {
            let number = match self.parts.slot(own.node) {
                Some(slot) => self.words.waiting(slot),
                None => self.operand(own.node),
            };
            let limit = self.words.number(own.limit);
            line(
                &mut out,
                &format!("if ({number} > {limit}) return {};", index + 1),
            );
        }
        line(&mut out, "return 0;");
        out
    }
}

fn line(out: &mut String, statement: &str) {
    // Writing to a string does not fail.
    let _ = writeln!(out, "    {statement}");
}
