//! The order in which nodes are evaluated.
//!
//! Two orders are tried: that in which they were recorded, and that in which they are first needed when the outputs are
//! asked for in sequence, of the operands of a node the one with the deeper expression first [Sethi, Ullman
//! 1970]. The one with fewer results alive at once is taken.

use super::operation::{NodeId, Operation};
use crate::sorting::sort_indices;

/// Nodes in order, and where each node of before is.
pub(super) struct Schedule {
    pub(super) nodes: Vec<Operation>,
    pub(super) places: Vec<NodeId>,
}

/// Orders the nodes that are requested: constants, then all inputs, then operations.
pub(super) fn schedule(nodes: &[Operation], wanted: &[NodeId], n_inputs: usize) -> Schedule {
    let live = needed(nodes, wanted);
    let recorded: Vec<usize> = (0..nodes.len())
        .filter(|&i| live[i] && !nodes[i].is_given())
        .collect();
    let demanded = on_demand(nodes, wanted);
    let best = [recorded, demanded]
        .into_iter()
        .min_by_key(|order| most_alive(nodes, wanted, order))
        .unwrap_or_default();
    place(nodes, &live, &best, n_inputs)
}

/// Nodes on which an output depends.
fn needed(nodes: &[Operation], wanted: &[NodeId]) -> Vec<bool> {
    let mut live = vec![false; nodes.len()];
    wanted.iter().for_each(|node| live[node.index()] = true);
    for i in (0..nodes.len()).rev() {
        if live[i] {
            nodes[i].operands().for_each(|x| live[x.index()] = true);
        }
    }
    live
}

/// Operations in the order in which the outputs ask for them.
fn on_demand(nodes: &[Operation], wanted: &[NodeId]) -> Vec<usize> {
    let mut depth = vec![0_u32; nodes.len()];
    for i in 0..nodes.len() {
        let operands = nodes[i].operands().map(|x| depth[x.index()] + 1);
        depth[i] = operands.max().unwrap_or(0);
    }
    let (mut done, mut order) = (vec![false; nodes.len()], Vec::new());
    // Whether the operands of a node have been asked for already.
    let mut open: Vec<(usize, bool)> = Vec::new();
    for &output in wanted {
        open.push((output.index(), false));
        while let Some((i, asked)) = open.pop() {
            if done[i] || nodes[i].is_given() {
                continue;
            }
            if asked {
                done[i] = true;
                order.push(i);
                continue;
            }
            open.push((i, true));
            let mut operands: Vec<usize> = nodes[i].operands().map(NodeId::index).collect();
            // The last one is taken first.
            sort_indices(&mut operands, &|x, y| (depth[x], x).cmp(&(depth[y], y)));
            open.extend(operands.into_iter().map(|x| (x, false)));
        }
    }
    order
}

/// The largest number of results that are needed at once.
fn most_alive(nodes: &[Operation], wanted: &[NodeId], order: &[usize]) -> usize {
    let mut last = vec![usize::MAX; nodes.len()];
    for (at, &i) in order.iter().enumerate() {
        nodes[i].operands().for_each(|x| last[x.index()] = at);
    }
    wanted.iter().for_each(|x| last[x.index()] = usize::MAX);
    let (mut alive, mut most) = (0_usize, 0);
    for (at, &i) in order.iter().enumerate() {
        alive += 1;
        most = most.max(alive);
        let ending = |&x: &usize| last[x] == at && !nodes[x].is_given();
        alive -= nodes[i].distinct_operands().filter(ending).count();
    }
    most
}

fn place(nodes: &[Operation], live: &[bool], order: &[usize], n_inputs: usize) -> Schedule {
    let mut places = vec![NodeId(u32::MAX); nodes.len()];
    let mut out = Vec::with_capacity(order.len());
    for (i, node) in nodes.iter().enumerate() {
        if live[i] && matches!(node, Operation::Constant(_)) {
            places[i] = NodeId::from(out.len());
            out.push(*node);
        }
    }
    let first = out.len();
    out.extend((0..n_inputs).map(|i| Operation::Input(NodeId::from(i).0)));
    for (i, node) in nodes.iter().enumerate() {
        if let Operation::Input(index) = node {
            places[i] = NodeId::from(first + *index as usize);
        }
    }
    for &i in order {
        places[i] = NodeId::from(out.len());
        out.push(nodes[i].map(|x| places[x.index()]));
    }
    Schedule { nodes: out, places }
}
