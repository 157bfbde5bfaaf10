//! Functions with their derivatives, on plain numbers: what JAX and PyTorch call.
//!
//! | file | what it is |
//! |---|---|
//! | `signature` | names and shapes of what a function takes and gives |
//! | `entries` | functions of the table |
//! | `steps` | steps and rollouts |
//!
//! A call says in a text what it is: lines with the kind, the function, the number of its vectors, whether parameters of the model follow them, the
//! inputs that change or whose derivatives are wanted, the number of rows, of directions of each row, of steps of a rollout, then arguments by name. Its
//! arrays are the inputs, then for `push` changes of inputs and for `pull` weights of the results, so many directions of each row; its results are those of
//! the function, their changes, or the gradients of their weighted sums. Changes of q are changes of its coordinates, of which only the part along a motion counts.

mod entries;
mod signature;
mod steps;

use numpy::PyArrayDyn;

use dualbody_python_table::Robot;

use crate::prelude::*;
pub(crate) use signature::{_signature, _table, Signature};

/// The object that a function belongs to.
#[derive(Clone, Copy)]
pub(crate) enum Of<'a> {
    Model(&'a PyModel),
    Simulator(&'a PySimulator),
}

impl<'a> Of<'a> {
    pub(crate) fn read(of: &'a Bound<'_, PyAny>) -> PyResult<Self> {
        match (of.cast::<PyModel>(), of.cast::<PySimulator>()) {
            (Ok(model), _) => Ok(Self::Model(model.get())),
            (_, Ok(simulator)) => Ok(Self::Simulator(simulator.get())),
            _ => Err(type_error("a Model or a Simulator is expected")),
        }
    }

    /// The robot, and what it is known by.
    fn robot(self) -> (Robot<'a, f64>, u64) {
        match self {
            Self::Model(own) => (Robot::Model(&own.model), own.id),
            Self::Simulator(own) => (Robot::Simulator(&own.simulator), own.id()),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Value,
    /// Changes of the results along directions.
    Push,
    /// Derivatives of weighted sums of the results.
    Pull,
}

/// A call.
pub(crate) struct Call<'a> {
    of: Of<'a>,
    kind: Kind,
    function: &'a str,
    /// Number of vectors.
    given: usize,
    has_parameters: bool,
    /// Inputs that change, or whose derivatives are wanted.
    active: Vec<usize>,
    count: usize,
    directions: usize,
    steps: usize,
    names: Vec<&'a str>,
}

fn number(text: &str) -> PyResult<usize> {
    let broken = |_| invalid!("{text:?} is no number");
    text.parse().map_err(broken)
}

impl<'a> Call<'a> {
    /// The call of a text.
    pub(crate) fn read(of: Of<'a>, text: &'a str) -> PyResult<Self> {
        let mut lines = text.split('\n');
        let mut next = || lines.next().unwrap_or_default();
        let kind = match next() {
            "value" => Kind::Value,
            "push" => Kind::Push,
            "pull" => Kind::Pull,
            other => {
                refuse!("there is no kind {other:?} of calls");
            }
        };
        Ok(Self {
            of,
            kind,
            function: next(),
            given: number(next())?,
            has_parameters: next() == "1",
            active: (next().split_terminator(',').map(number)).collect::<PyResult<_>>()?,
            count: number(next())?,
            directions: number(next())?,
            steps: number(next())?,
            names: lines.collect(),
        })
    }

    /// Whether it is one of a step; else of a rollout, or of an entry of the table.
    fn is_step(&self) -> bool {
        self.function == "step"
    }

    /// Calls the function; the interpreter lock is not needed.
    pub(crate) fn run(&self, arrays: &[&[f64]], out: &mut [&mut [f64]]) -> PyResult<()> {
        let signature = Signature::of(self)?;
        let directions = if self.kind == Kind::Value {
            1
        } else {
            self.directions
        };
        let size = |shape: &Vec<usize>| shape.iter().product::<usize>() * directions;
        let results: Vec<usize> = signature.outputs.iter().map(size).collect();
        let moved = self.active.iter().map(|&i| signature.input(i) * directions);
        let (more, found) = match self.kind {
            Kind::Value => (Vec::new(), results),
            Kind::Push => (moved.collect(), results),
            Kind::Pull => (results, moved.collect()),
        };
        let inputs = 0..signature.inputs.len();
        let widths: Vec<usize> = inputs.map(|i| signature.input(i)).chain(more).collect();
        self.check("array", &widths, arrays.iter().map(|x| x.len()))?;
        self.check("result", &found, out.iter().map(|x| x.len()))?;
        let rows = Rows {
            arrays,
            widths: &widths,
            given: signature.inputs.len(),
        };
        match (signature.entry, self.of) {
            (None, Of::Simulator(own)) => steps::run(self, own, &signature, &rows, &found, out),
            _ => entries::call(self, &signature, &rows, &found, out),
        }
    }

    fn check(
        &self,
        what: &str,
        widths: &[usize],
        lengths: impl ExactSizeIterator<Item = usize>,
    ) -> PyResult<()> {
        if lengths.len() != widths.len() {
            refuse!(
                "{} has {} of {what}s, expected {}",
                self.function,
                lengths.len(),
                widths.len()
            );
        }
        for (k, (length, width)) in lengths.zip(widths).enumerate() {
            if length != width * self.count {
                refuse!(
                    "{what} {k} of {} has {length} numbers, expected {} rows of {width}",
                    self.function,
                    self.count
                );
            }
        }
        Ok(())
    }
}

/// Rows of arrays.
struct Rows<'a> {
    arrays: &'a [&'a [f64]],
    widths: &'a [usize],
    /// Number of inputs.
    given: usize,
}

impl<'a> Rows<'a> {
    fn row(&self, i: usize, k: usize) -> &'a [f64] {
        let width = self.widths[i];
        &self.arrays[i][k * width..(k + 1) * width]
    }

    /// The part after the inputs: changes of inputs, or weights of results.
    fn more(&self, p: usize, k: usize) -> &'a [f64] {
        self.row(self.given + p, k)
    }
}

functions! {
    /// Calls a function as its text says, from arrays into arrays in C order.
    fn _call(of, text: &str, arrays: Vec<Bound<'py, PyArrayDyn<f64>>>, out: Vec<Bound<'py, PyArrayDyn<f64>>>) -> PyResult<()> {
        let call = Call::read(Of::read(of)?, text)?;
        // SAFETY: the package makes the arrays for this call, and nothing else refers to them.
        let numbers: Vec<&[f64]> = arrays.iter().map(|x| unsafe { x.as_slice() }.unwrap_or(&[])).collect();
        let mut out: Vec<&mut [f64]> = out.iter().map(|array| numbers_mut(array)).collect();
        of.py().detach(|| call.run(&numbers, &mut out))
    }
}
