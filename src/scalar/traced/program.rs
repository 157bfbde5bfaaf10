//! A graph as instructions on a few places of memory that are used again and again.

use super::operation::{NodeId, Operation};
use crate::scalar::Scalar;

/// A place in memory.
pub(super) type Slot = u32;

/// Instructions in order; constants and inputs have the first places.
#[derive(Clone, Debug)]
pub(super) struct Program {
    given: Vec<Operation>,
    instructions: Vec<Instruction>,
    /// Place of each result that is kept.
    pub(super) kept: Vec<Slot>,
    pub(super) slots: usize,
}

#[derive(Clone, Copy, Debug)]
enum Instruction {
    /// An operation, and where its result goes.
    Single(Operation<Slot>, Slot),
    /// Sine and cosine of an angle.
    SinCos { angle: Slot, sin: Slot, cos: Slot },
}

/// Free places, and when the one that a node has becomes free.
struct Allocation {
    places: Vec<Slot>,
    free: Vec<Slot>,
    slots: Slot,
}

impl Allocation {
    fn take(&mut self, node: usize) -> Slot {
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots += 1;
            self.slots - 1
        });
        self.places[node] = slot;
        slot
    }
}

impl Program {
    /// * `kept` – nodes whose results are needed at the end
    pub(super) fn new(nodes: &[Operation], kept: impl Iterator<Item = NodeId>) -> Self {
        let kept: Vec<NodeId> = kept.collect();
        let given = nodes.iter().take_while(|node| node.is_given()).count();
        let cosines = pairs(nodes);
        let last = last_uses(nodes, &cosines, &kept);
        let mut at = Allocation {
            places: (0..nodes.len()).map(|i| NodeId::from(i).0).collect(),
            free: Vec::new(),
            slots: NodeId::from(given).0,
        };
        let mut instructions = Vec::with_capacity(nodes.len() - given);
        let mut done = vec![false; nodes.len()];
        for i in given..nodes.len() {
            if done[i] {
                continue;
            }
            let operation = nodes[i].map(|x| at.places[x.index()]);
            let pair = cosines[i];
            // Operands go before the result comes, which may take the place of one.
            for x in nodes[i].distinct_operands().filter(|&x| x >= given) {
                if last[x] == Some(i) {
                    at.free.push(at.places[x]);
                }
            }
            let out = at.take(i);
            instructions.push(match (operation, pair) {
                (Operation::Sin(angle), Some(other)) => {
                    done[other] = true;
                    let (sin, cos) = (out, at.take(other));
                    Instruction::SinCos { angle, sin, cos }
                }
                (Operation::Cos(angle), Some(other)) => {
                    done[other] = true;
                    let (sin, cos) = (at.take(other), out);
                    Instruction::SinCos { angle, sin, cos }
                }
                _ => Instruction::Single(operation, out),
            });
        }
        Self {
            given: nodes[..given].to_vec(),
            instructions,
            kept: kept.iter().map(|x| at.places[x.index()]).collect(),
            slots: at.slots as usize,
        }
    }

    /// Number of places that results of operations take.
    pub(super) fn live_values(&self) -> usize {
        self.slots - self.given.len()
    }

    /// Computes all results, in as many places as there are `slots`.
    #[inline(always)]
    pub(super) fn run<T: Scalar>(&self, inputs: &[T], slots: &mut [T]) {
        for (slot, given) in slots.iter_mut().zip(&self.given) {
            *slot = given.map(|_| T::zero()).apply(inputs);
        }
        for instruction in &self.instructions {
            match *instruction {
                Instruction::Single(operation, out) => {
                    let operation = operation.map(|slot| slots[slot as usize]);
                    slots[out as usize] = operation.apply(inputs);
                }
                Instruction::SinCos { angle, sin, cos } => {
                    let (s, c) = slots[angle as usize].sin_cos();
                    (slots[sin as usize], slots[cos as usize]) = (s, c);
                }
            }
        }
    }
}

/// The last node that uses each one; `None` if none does. Sine and cosine of an angle are found together, where the first of them stands: uses of
/// the angle between them come later.
///
/// * `pairs` – of each sine its cosine, and the other way round
fn last_uses(nodes: &[Operation], pairs: &[Option<usize>], kept: &[NodeId]) -> Vec<Option<usize>> {
    let mut last = vec![None; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        let found = pairs[i].map_or(i, |other| i.min(other));
        node.operands()
            .map(NodeId::index)
            .for_each(|x| last[x] = last[x].max(Some(found)));
    }
    kept.iter().for_each(|x| last[x.index()] = Some(usize::MAX));
    last
}

/// Of each sine the cosine of the same angle, and the other way round.
fn pairs(nodes: &[Operation]) -> Vec<Option<usize>> {
    let (mut sines, mut cosines) = (vec![None; nodes.len()], vec![None; nodes.len()]);
    for (i, node) in nodes.iter().enumerate() {
        match node {
            Operation::Sin(angle) => sines[angle.index()] = Some(i),
            Operation::Cos(angle) => cosines[angle.index()] = Some(i),
            _ => {}
        }
    }
    let other = |node: &Operation| match node {
        Operation::Sin(angle) => cosines[angle.index()],
        Operation::Cos(angle) => sines[angle.index()],
        _ => None,
    };
    nodes.iter().map(other).collect()
}
