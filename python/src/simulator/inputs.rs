//! Inputs of rollouts.

use crate::prelude::*;

/// Inputs of a rollout.
pub(crate) enum Inputs<'a> {
    None,
    /// Shared by all trajectories, or one block (steps × nu) each.
    Given {
        numbers: &'a [f64],
        shared: bool,
    },
}

impl<'a> Inputs<'a> {
    pub(super) fn of(rows: Option<&'a Rows<'_>>) -> Self {
        rows.map_or(Self::None, |rows| Self::Given {
            numbers: rows.as_slice(),
            shared: rows.batch().is_empty(),
        })
    }

    pub(super) fn at(&self, i: usize, k: usize, j: usize, steps: usize, nu: usize) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Given { numbers, shared } => {
                let i = if *shared { 0 } else { i };
                numbers[(i * steps + k) * nu + j]
            }
        }
    }
}

/// Reads inputs (…, steps, nu), and finds the number of steps.
pub(crate) fn read_inputs<'py>(
    inputs: Option<&Bound<'py, PyAny>>,
    steps: Option<&Bound<'py, PyAny>>,
    nu: usize,
) -> PyResult<(Option<Rows<'py>>, usize)> {
    let steps: Option<usize> = steps.map(|steps| whole("steps", steps)).transpose()?;
    let Some(inputs) = inputs else {
        let steps = steps.ok_or_else(|| value_error("steps is missing"))?;
        return Ok((None, steps));
    };
    let steps = match steps {
        Some(steps) => steps,
        None => {
            let array = numbers("inputs", inputs)?;
            let shape = array.shape();
            let axes = shape.len().checked_sub(2).map(|k| shape[k]);
            axes.ok_or_else(|| shape_error("inputs", shape, format_args!("(…, steps, {nu})")))?
        }
    };
    Ok((
        Some(Rows::read(&argument("inputs", inputs, &[steps, nu]))?),
        steps,
    ))
}

/// Reads the input that a control returned: a vector, or a number if there is one input.
pub(super) fn read_input(given: &Bound<'_, PyAny>, nu: usize, u: &mut [f64]) -> PyResult<()> {
    if nu == 1
        && let Ok(x) = given.extract::<f64>()
    {
        u[0] = x;
        return Ok(());
    }
    u.copy_from_slice(&read_vector("the control's input", given, Some(nu))?);
    Ok(())
}
