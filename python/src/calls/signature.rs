//! Names and shapes of what functions take and give.

use dualbody_python_table::{Keyword, shape_of};

use super::{Call, Kind, Of};
use crate::dynamics::table::Entry;
use crate::prelude::*;

/// Arguments of a function, parameters of the model included, and its results.
pub(crate) struct Signature {
    pub(super) names: Vec<&'static str>,
    pub(super) inputs: Vec<Vec<usize>>,
    pub(super) outputs: Vec<Vec<usize>>,
    /// Its entry in the table; none for steps and rollouts.
    pub(super) entry: Option<&'static Entry>,
}

/// Vectors of steps and rollouts.
const OF_STEPS: [(&str, [&str; 4]); 2] = [
    ("step", ["q", "v", "u", "contact"]),
    ("rollout", ["q", "v", "inputs", "contact"]),
];

/// All entries of the table.
fn entries() -> impl Iterator<Item = &'static Entry> {
    crate::dynamics::entries().chain(crate::simulator::entries::ALL.iter().copied())
}

impl Signature {
    pub(super) fn of(call: &Call<'_>) -> PyResult<Self> {
        let (robot, _) = call.of.robot();
        let stepping = OF_STEPS.iter().find(|(name, _)| *name == call.function);
        let mut out = match (stepping, call.of) {
            (Some((_, names)), Of::Simulator(own)) => {
                let (nq, nv, nu, nc) = own.sizes();
                let rows = |n: usize| match call.function {
                    "step" => vec![n],
                    _ => vec![call.steps + 1, n],
                };
                let inputs = if call.function == "step" {
                    vec![nu]
                } else {
                    vec![call.steps, nu]
                };
                let count = call.given.clamp(3, 4);
                Self {
                    names: names[..count].to_vec(),
                    inputs: [vec![nq], vec![nv], inputs, vec![nc]][..count].to_vec(),
                    outputs: [rows(nq), rows(nv), rows(nc)][..count - 1].to_vec(),
                    entry: None,
                }
            }
            _ => {
                let entry = entries().find(|entry| entry.function.name == call.function);
                let entry =
                    entry.ok_or_else(|| invalid!("there is no function {}", call.function))?;
                let own = &entry.function;
                let names: Vec<_> = own
                    .arguments
                    .iter()
                    .chain(&own.option)
                    .copied()
                    .take(call.given)
                    .collect();
                guarded(|| Self {
                    inputs: names
                        .iter()
                        .map(|name| shape_of(robot, name).to_vec())
                        .collect(),
                    names,
                    outputs: vec![(own.tail)(robot).to_vec()],
                    entry: Some(entry),
                })?
            }
        };
        if call.has_parameters {
            out.names.push("parameters");
            out.inputs
                .push(vec![robot.model().parameter_layout().names().len()]);
        }
        Ok(out)
    }

    /// Numbers of an input.
    pub(super) fn input(&self, i: usize) -> usize {
        self.inputs.get(i).map_or(0, |shape| shape.iter().product())
    }
}

functions! {
    /// Shapes of the inputs and results of one row of a function, whose arguments by name are checked if they are given.
    fn _signature(
        of, function: &str, given: usize, has_parameters: bool, steps: usize, names: Option<Vec<String>> = None
    ) -> PyResult<(Vec<Vec<usize>>, Vec<Vec<usize>>)> {
        let checked = names.is_some();
        let names = names.unwrap_or_default();
        if let Some(name) = names.iter().find(|name| name.contains('\n')) {
            refuse!("{name:?} has a line break, as no name here may");
        }
        let call = Call {
            of: Of::read(of)?,
            kind: Kind::Value,
            function,
            given,
            has_parameters,
            active: Vec::new(),
            count: 0,
            directions: 0,
            steps,
            names: names.iter().map(String::as_str).collect(),
        };
        let signature = Signature::of(&call)?;
        if let Some(entry) = signature.entry.filter(|_| checked) {
            let model = call.of.robot().0.model();
            entry.prepared(model, &call.names).map(|_| ())?;
        }
        Ok((signature.inputs, signature.outputs))
    }

    /// All functions: name, vectors, one that may be left out, keywords with what they are if they are left out, whether they are of a simulator.
    fn _table() -> PyResult<Vec<(&'static str, Vec<&'static str>, Option<&'static str>, Vec<Keyword>, bool)>> {
        let of_entry = |entry: &Entry| {
            let own = &entry.function;
            (own.name, own.arguments.to_vec(), own.option, own.keywords.to_vec(), own.is_of_simulator)
        };
        let of_steps = OF_STEPS.iter().map(|(name, names)| (*name, names[..3].to_vec(), Some(names[3]), Vec::new(), true));
        Ok(entries().map(of_entry).chain(of_steps).collect())
    }
}
