//! Dependence of outputs on inputs, and groups of inputs that can be seeded together.

use super::graph::Graph;
use super::operation::Operation;
use crate::nested::IntoNested;

/// Bits in a word.
const WORD: usize = u64::BITS as usize;

/// A set of inputs for each output.
pub(super) struct Sparsity {
    words: usize,
    /// Row by row.
    bits: Vec<u64>,
}

impl Sparsity {
    /// Of a graph, for the outputs and inputs of some indices.
    pub(super) fn of(graph: &Graph, outputs: &[usize], inputs: &[usize]) -> Self {
        let words = inputs.len().div_ceil(WORD).max(1);
        let nodes = graph.nodes();
        let mut sets = vec![0_u64; nodes.len() * words];
        for (i, node) in nodes.iter().enumerate() {
            if let Operation::Input(index) = node
                && let Some(k) = inputs.iter().position(|&x| x == *index as usize)
            {
                sets[i * words + k / WORD] |= 1 << (k % WORD);
            }
            let (before, own) = sets.split_at_mut(i * words);
            for x in node.operands() {
                let operand = &before[x.index() * words..][..words];
                let both = own[..words].iter_mut().zip(operand);
                both.for_each(|(own, &other)| *own |= other);
            }
        }
        let of = |&output: &usize| graph.results()[output].index();
        let rows = outputs.iter().map(of);
        let bits = rows.nested(|i| sets[i * words..][..words].to_vec());
        Self {
            words,
            bits: bits.collect(),
        }
    }

    /// Whether an output depends on an input, by their places among those that were requested.
    pub(super) fn depends(&self, output: usize, input: usize) -> bool {
        self.bits[output * self.words + input / WORD] >> (input % WORD) & 1 != 0
    }

    fn rows(&self) -> usize {
        self.bits.len() / self.words
    }
}

/// Colours of columns, or of rows: those of one colour have no entry in common.
///
/// Greedy, in order [Curtis, Powell, Reid 1974].
///
/// * `meet` – whether a column has an entry in a row
pub(super) fn colours(
    columns: usize,
    rows: usize,
    meet: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut out: Vec<(Vec<usize>, Vec<bool>)> = Vec::new();
    for column in 0..columns {
        let entries: Vec<usize> = (0..rows).filter(|&row| meet(column, row)).collect();
        if entries.is_empty() {
            continue;
        }
        let fits = |(_, taken): &&mut (Vec<usize>, Vec<bool>)| entries.iter().all(|&r| !taken[r]);
        match out.iter_mut().find(fits) {
            Some((members, taken)) => {
                members.push(column);
                entries.iter().for_each(|&r| taken[r] = true);
            }
            None => {
                let mut taken = vec![false; rows];
                entries.iter().for_each(|&r| taken[r] = true);
                out.push((vec![column], taken));
            }
        }
    }
    out.into_iter().map(|(members, _)| members).collect()
}

impl Sparsity {
    /// Colours of the inputs.
    pub(super) fn input_colours(&self, inputs: usize) -> Vec<Vec<usize>> {
        colours(inputs, self.rows(), |input, output| {
            self.depends(output, input)
        })
    }

    /// Colours of the outputs.
    pub(super) fn output_colours(&self, inputs: usize) -> Vec<Vec<usize>> {
        colours(self.rows(), inputs, |output, input| {
            self.depends(output, input)
        })
    }
}
