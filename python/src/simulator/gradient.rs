//! Gradients through steps, and what those through rollouts have in common with them.

use std::ops::Range;

use dualbody::linearize::{StepGradient, VjpScratch, WantedParameters};
use dualbody::sim::SimulatorParameterGroup;

use super::given::check_finite;
use super::memory::check_batch;
use crate::prelude::*;

/// Gradient of ⟨adjoint, next state⟩ of a step.
pub(crate) fn pull_step(
    own: &Simulator,
    wanted: WantedParameters,
    (state, u): (&State, &[f64]),
    adjoint: &[f64],
    scratch: &mut VjpScratch,
) -> StepGradient {
    let all = StepGradient::zeros(own);
    let mut out = match wanted {
        WantedParameters::None => all.without_parameters(),
        WantedParameters::Model => all.with_model_parameters_only(own),
        WantedParameters::All => all,
    };
    own.vjp_into(state, u, adjoint, scratch, &mut out);
    out
}

/// All parameters, or none.
pub(super) fn wanted(parameters: bool) -> WantedParameters {
    match parameters {
        true => WantedParameters::All,
        false => WantedParameters::None,
    }
}

methods! { PySimulator {
    /// Gradient of ⟨adjoint, next state⟩, the vector-Jacobian product of a step: a StepGradient (state, input, parameters, friction,
    /// simulator_parameters).
    ///
    /// q (..., nq), v (..., nv), u (..., nu), adjoint (..., n_tangent): weights of the tangent of the next state. The cost is three to six steps, for
    /// any number of parameters. parameters: False omits parameters and friction.
    fn vjp(
        &self, q, v, u, adjoint, *, contact = None, models: Option<Vec<Py<PyModel>>> = None, parameters: bool = true
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), &*self.simulator);
        let (n, nu) = (own.n_tangent(), own.nu());
        let given = self.read(q, v, Some(u), contact)?;
        let adjoint = Rows::read(&argument("adjoint", adjoint, &[n]))?;
        check_finite("adjoint", adjoint.as_slice())?;
        let all = [("q", &given.batch[..]), ("adjoint", adjoint.batch())];
        let batch = common_batch(all.into_iter())?;
        let count = batch.iter().product();
        let (states, inputs) = (self.states(&given, count)?, self.inputs(&given, count)?);
        check_batch(&batch, models.is_some())?;
        let variants = self.variants(models.as_deref(), count)?;
        let weights = adjoint.view();
        let one = |k: usize| {
            let at = (&states[k], &inputs[k * nu..(k + 1) * nu]);
            let pull = |own: &Simulator, scratch: &mut VjpScratch| {
                pull_step(own, wanted(parameters), at, weights.row(k), scratch)
            };
            match &variants {
                None => with_kept(self.id, || VjpScratch::new(own), |kept| pull(own, kept)),
                Some(all) => pull(&all[k], &mut VjpScratch::new(&all[k])),
            }
        };
        let all = py.detach(|| each(count, one))?;
        let slopes: Vec<&[f64]> = all.iter().map(|g| g.parameters.as_slice()).collect();
        let [model, friction, simulator] = self.parameters_of(py, &batch, parameters, &slopes);
        let arrays = (
            stack(py, &batch, &[n], all.iter().map(|g| g.state.as_slice())),
            stack(py, &batch, &[nu], all.iter().map(|g| g.input.as_slice())),
            model,
            friction,
            simulator,
        );
        of_package!(py, "_rollout", "StepGradient").call1(arrays)
    }
} }

impl PySimulator {
    /// Derivatives in the parameters of the model, in the friction of each point of contact and in all parameters of the simulator, from the latter of each
    /// state; in no number if they are not wanted.
    pub(super) fn parameters_of<'py>(
        &self,
        py: Python<'py>,
        batch: &[usize],
        wanted: bool,
        rows: &[&[f64]],
    ) -> [Array<'py>; 3] {
        let own = &*self.simulator;
        let model = own.model().parameter_layout().names().len();
        let parts: [Vec<usize>; 3] = match wanted {
            true => [
                (0..model).collect(),
                self.friction(),
                (0..own.parameters().len()).collect(),
            ],
            false => Default::default(),
        };
        parts.map(|part| {
            let of = |row: &&[f64]| part.iter().map(|&k| row[k]).collect();
            let rows: Vec<Vec<f64>> = rows.iter().map(of).collect();
            stack(py, batch, &[part.len()], rows.iter().map(Vec::as_slice))
        })
    }

    /// Indices of the friction of each point of contact among the parameters.
    fn friction(&self) -> Vec<usize> {
        let layout = self.simulator.parameter_layout();
        let of_law = |(group, range): &(SimulatorParameterGroup, Range<usize>)| {
            let is_friction = |&k: &usize| layout.names()[k].ends_with(": friction");
            let is_law = matches!(group, SimulatorParameterGroup::ContactLaw(_));
            range.clone().find(is_friction).filter(|_| is_law)
        };
        let contacts = self.simulator.contacts();
        let points = contacts.map_or(0, |contacts| contacts.points().len());
        let all = layout.groups().iter().filter_map(of_law);
        all.take(points).collect()
    }
}
