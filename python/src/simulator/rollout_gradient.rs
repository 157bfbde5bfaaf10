//! Gradients through rollouts.

use dualbody::linearize::{Checkpoints, RolloutGradient, RolloutGradientOptions};
use dualbody::sim::RolloutStatus;

use super::given::{check_finite, read_inputs};
use super::gradient::wanted;
use super::memory::check_batch;
use super::trajectories::status_of;
use super::weighted::Weighted;
use crate::prelude::*;

fn checkpoints_of(value: &Bound<'_, PyAny>) -> PyResult<Checkpoints> {
    if let Ok(interval) = value.extract::<usize>() {
        return Ok(Checkpoints::Every(interval.max(1)));
    }
    match value.extract::<String>().as_deref() {
        Ok("all") => Ok(Checkpoints::All),
        Ok("square_root") => Ok(Checkpoints::SquareRoot),
        _ => Err(value_error(
            "checkpoints is not \"all\", \"square_root\" or a number of steps",
        )),
    }
}

fn options_of(
    parameters: bool,
    checkpoints: Option<&Bound<'_, PyAny>>,
) -> PyResult<RolloutGradientOptions> {
    let own = RolloutGradientOptions::default();
    Ok(RolloutGradientOptions {
        parameters: wanted(parameters),
        checkpoints: checkpoints.map_or(Ok(own.checkpoints), checkpoints_of)?,
    })
}

methods! { PySimulator {
    /// Gradient of Σₖ ⟨by_q[k], q[k]⟩ + ⟨by_v[k], v[k]⟩ + ⟨by_contact[k], contact[k]⟩ + ⟨by_u[k], u[k]⟩ over a rollout, the vector-Jacobian
    /// product of all its steps: a RolloutGradient (start, inputs, parameters, friction, status, simulator_parameters).
    ///
    /// q (..., nq), v (..., nv), inputs (..., steps, nu) or (steps, nu) for all; by_q (..., steps + 1, nq) in coordinates, by_v (..., steps + 1, nv),
    /// by_contact (..., steps + 1, n_contact), by_u (..., steps, nu); zero if left out. parameters: False leaves parameters and friction out;
    /// checkpoints: states that are kept, "all", "square_root", or one in so many. A trajectory that does not come to its end has no slopes.
    fn rollout_vjp(
        &self, q, v, inputs, *, by_q = None, by_v = None, by_contact = None, by_u = None, contact = None, models: Option<Vec<Py<PyModel>>> = None,
        parameters: bool = true, checkpoints = None
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), &*self.simulator);
        let (nq, nv, nu, nc) = self.sizes();
        let given = self.read(q, v, None, contact)?;
        let (inputs, steps) = read_inputs(Some(inputs), None, nu)?;
        let read = |name, value: Option<&Bound<'py, PyAny>>, shape: [usize; 2]| {
            let rows = value.map(|value| Rows::read(&argument(name, value, &shape)));
            let rows = rows.transpose()?;
            let numbers = rows.as_ref().map_or(&[][..], Rows::as_slice);
            check_finite(name, numbers).map(|()| rows)
        };
        let weights = [
            ("by_q", read("by_q", by_q, [steps + 1, nq])?),
            ("by_v", read("by_v", by_v, [steps + 1, nv])?),
            ("by_contact", read("by_contact", by_contact, [steps + 1, nc])?),
            ("by_u", read("by_u", by_u, [steps, nu])?),
            ("inputs", inputs),
        ];
        let own_batches = weights.iter().filter_map(|(name, rows)| Some((*name, rows.as_ref()?.batch())));
        let batch = common_batch([("q", &given.batch[..])].into_iter().chain(own_batches))?;
        let count = batch.iter().product();
        check_batch(&batch, models.is_some())?;
        let variants = self.variants(models.as_deref(), count)?;
        let states = self.states(&given, count)?;
        let views = weights.each_ref().map(|(_, rows)| rows.as_ref().map(Rows::view));
        let options = options_of(parameters, checkpoints)?;
        let one = |k: usize| {
            let [q, v, contact, u, inputs] = views.map(|view| view.map_or(&[][..], |view| view.row(k)));
            let cost = Weighted {
                steps,
                q,
                v,
                contact,
                u,
            };
            let own = variants.as_ref().map_or(own, |all| &all[k]);
            cost.pull(own, &states[k], inputs, &options)
        };
        let all = py.detach(|| each(count, one))?;
        self.rollout_slopes(py, &batch, steps, parameters, &all)
    }
} }

impl PySimulator {
    fn rollout_slopes<'py>(
        &self,
        py: Python<'py>,
        batch: &[usize],
        steps: usize,
        parameters: bool,
        all: &[RolloutGradient],
    ) -> PyResult<Bound<'py, PyAny>> {
        let (n, nu) = (self.simulator.n_tangent(), self.simulator.nu());
        let slopes: Vec<&[f64]> = all.iter().map(|g| g.parameters.as_slice()).collect();
        let [model, friction, simulator] = self.parameters_of(py, batch, parameters, &slopes);
        let inputs: Vec<Vec<f64>> = all
            .iter()
            .map(|g| g.inputs.iter().flat_map(|u| u.iter().copied()).collect())
            .collect();
        let stopped: Vec<_> = (0..all.len())
            .filter(|&k| !matches!(all[k].status, RolloutStatus::Completed))
            .map(|k| (k, status_of(all[k].status)))
            .collect();
        let status = of_package!(py, "_rollout", "_statuses");
        let status = status.call1((all.len(), stopped, !batch.is_empty()))?;
        let fields = (
            stack(py, batch, &[n], all.iter().map(|g| g.start.as_slice())),
            stack(py, batch, &[steps, nu], inputs.iter().map(Vec::as_slice)),
            model,
            friction,
            status,
            py.None(),
            simulator,
        );
        of_package!(py, "_rollout", "RolloutGradient").call1(fields)
    }
}
