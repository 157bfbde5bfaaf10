//! Places of the inputs of a function in the memory of a kernel.

use crate::codegen::CodeError;
use crate::scalar::traced::{Graph, Port};

/// Numbers of values that a kernel reads and writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CudaSizes {
    /// Inputs of each state; for a rollout the constant ones, such as parameters.
    pub inputs: usize,
    /// Inputs of each state and step of a rollout; 0 in other kernels.
    pub each_step: usize,
    /// Inputs that are equal for all states.
    pub shared: usize,
    /// Outputs of each state; for a rollout the length of a state.
    pub outputs: usize,
    /// Values of each state that the kernels of a long function exchange; 0 for one kernel.
    pub work: usize,
}

impl CudaSizes {
    /// States in a tile of the workspace: the number of threads that run together, for coalesced access.
    pub const TILE: usize = 32;
}

/// The inputs of a graph, apart from those that all states share.
pub(super) struct Places<'a> {
    /// Those that each state has its own of, with the index of the first entry of each among them.
    pub(super) own: Vec<(&'a Port, usize)>,
    pub(super) shared: Vec<&'a Port>,
    /// The expression of each number of all inputs.
    pub(super) expressions: Vec<String>,
}

impl<'a> Places<'a> {
    /// * `stride` – factor of the index of a number that is not shared
    ///
    /// # Errors
    /// If there is no input with this name.
    pub(super) fn of(graph: &'a Graph, shared: &[String], stride: &str) -> Result<Self, CodeError> {
        let mut out = Self {
            own: Vec::new(),
            shared: Vec::new(),
            expressions: Vec::new(),
        };
        known(graph.inputs(), shared)?;
        let (mut own, mut common) = (0, 0);
        for port in graph.inputs() {
            let numbers = 0..port.len();
            if shared.iter().any(|name| name == &port.name) {
                let all = numbers.map(|k| format!("shared[{}]", common + k));
                out.expressions.extend(all);
                out.shared.push(port);
                common += port.len();
            } else {
                let all = numbers.map(|k| format!("in[{}{stride}]", own + k));
                out.expressions.extend(all);
                out.own.push((port, own));
                own += port.len();
            }
        }
        Ok(out)
    }

    pub(super) fn n_own(&self) -> usize {
        self.own.iter().map(|(port, _)| port.len()).sum()
    }

    pub(super) fn n_shared(&self) -> usize {
        self.shared.iter().map(|port| port.len()).sum()
    }
}

/// Checks that ports of these names are there.
pub(super) fn known(ports: &[Port], names: &[String]) -> Result<(), CodeError> {
    let is_there = |name: &&String| ports.iter().any(|port| port.name == **name);
    match names.iter().find(|name| !is_there(name)) {
        None => Ok(()),
        Some(name) => Err(CodeError::NoInput {
            name: name.clone(),
            known: ports.iter().map(|port| port.name.to_owned()).collect(),
        }),
    }
}
