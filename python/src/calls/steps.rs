//! Steps and rollouts with their derivatives.

use dualbody::linearize::{RolloutGradientOptions, StepGradient, VjpScratch, WantedParameters};
use dualbody::{Linearization, Model, Simulator, State};
use nalgebra::{DMatrix, DVector};
use pyo3::prelude::*;
use rayon::prelude::*;

use super::{Call, Kind, Rows, Signature};
use crate::arrays::in_rows;
use crate::errors::{OrRaise, guarded};
use crate::simulator::{PySimulator, Slice, Weighted, check_finite, diverged};
use crate::threads::pool;

/// Weighted sums of a step whose derivatives are found one by one; for more of them its Jacobians are.
const FEW: usize = 2;

/// Steps of all rows: one, or those of a rollout.
struct Steps<'a> {
    call: &'a Call<'a>,
    own: &'a PySimulator,
    rows: &'a Rows<'a>,
    /// Whether the state of contact is given.
    has_contact: bool,
    /// Index of the parameters.
    parameters: usize,
    robots: Option<Vec<Simulator>>,
    states: Vec<State>,
}

impl<'a> Steps<'a> {
    fn new(
        call: &'a Call<'a>,
        own: &'a PySimulator,
        signature: &Signature,
        rows: &'a Rows<'a>,
    ) -> PyResult<Self> {
        let parameters = signature.inputs.len() - usize::from(call.has_parameters);
        check_finite("u", rows.arrays[2])?;
        let mut out = Self {
            call,
            own,
            rows,
            has_contact: parameters == 4,
            parameters,
            robots: None,
            states: Vec::new(),
        };
        out.states = (0..call.count)
            .map(|k| out.state(k))
            .collect::<PyResult<_>>()?;
        if call.has_parameters {
            let all = guarded(|| {
                (0..call.count)
                    .map(|k| out.changed(k))
                    .collect::<Result<Vec<_>, _>>()
            })?;
            out.robots = Some(all.or_raise()?);
        }
        Ok(out)
    }

    fn changed(&self, k: usize) -> Result<Simulator, dualbody::error::StructureMismatch> {
        let model = self.own.simulator.model();
        let model = model.with_parameters(self.rows.row(self.parameters, k));
        self.own.simulator.with_model(model)
    }

    fn state(&self, k: usize) -> PyResult<State> {
        let simulator = &self.own.simulator;
        let state = simulator.state(self.rows.row(0, k), self.rows.row(1, k));
        let state = match self.has_contact {
            true => self.own.with_beside(state, self.rows.row(3, k)),
            false => state,
        };
        state.check(simulator.model()).or_raise()?;
        Ok(state)
    }

    fn robot(&self, k: usize) -> &Simulator {
        self.robots
            .as_ref()
            .map_or(&*self.own.simulator, |all| &all[k])
    }

    fn model(&self, k: usize) -> &Model {
        self.robot(k).model()
    }

    fn slice(&self) -> Slice<'_> {
        Slice {
            q: self.rows.arrays[0],
            v: self.rows.arrays[1],
            u: self.rows.arrays[2],
            contact: self.has_contact.then(|| self.rows.arrays[3]),
            count: self.call.count,
        }
    }

    /// The part after the inputs: changes of inputs, or weights of results.
    fn more(&self, p: usize, k: usize) -> &[f64] {
        self.rows.row(
            self.parameters + usize::from(self.call.has_parameters) + p,
            k,
        )
    }

    /// The changes of an input along a direction; none if it does not change.
    fn change(&self, i: usize, k: usize, direction: usize) -> Option<&[f64]> {
        let p = self.call.active.iter().position(|&own| own == i)?;
        let width = self.rows.widths[i];
        Some(&self.more(p, k)[direction * width..(direction + 1) * width])
    }

    /// Change of a state along a direction, in its tangent.
    fn change_of_start(&self, k: usize, direction: usize) -> DVector<f64> {
        let simulator = self.robot(k);
        let nv = simulator.model().nv();
        let mut out = DVector::zeros(simulator.n_tangent());
        if let Some(dq) = self.change(0, k, direction) {
            let tangent = simulator.model().difference_jacobian(self.rows.row(0, k))
                * DVector::from_column_slice(dq);
            out.rows_mut(0, nv).copy_from(&tangent);
        }
        for (i, first) in [(1, nv), (3, 2 * nv)] {
            if let Some(dx) = self.change(i, k, direction) {
                out.rows_mut(first, dx.len()).copy_from_slice(dx);
            }
        }
        out
    }

    /// Jacobians of the steps of all rows, and those in the parameters where they change.
    fn linear(
        &self,
        states: &[State],
        inputs: &[f64],
    ) -> PyResult<Vec<(Linearization, Option<DMatrix<f64>>)>> {
        let nu = self.own.simulator.nu();
        let of = |k: usize| k * self.call.count / states.len().max(1);
        let u = |k: usize| &inputs[k * nu..(k + 1) * nu];
        let linear = match &self.robots {
            None => self.own.linearize_states(states, inputs)?,
            Some(_) => self.each(states.len(), |k| {
                self.robot(of(k)).linearize(&states[k], u(k))
            })?,
        };
        let by_parameters =
            match self.call.active.contains(&self.parameters) && self.call.has_parameters {
                true => self.each(states.len(), |k| {
                    Some(by_parameters(self.robot(of(k)), &states[k], u(k)))
                })?,
                false => vec![None; states.len()],
            };
        Ok(linear.into_iter().zip(by_parameters).collect())
    }

    fn each<R: Send>(
        &self,
        count: usize,
        one: impl Fn(usize) -> R + Sync + Send,
    ) -> PyResult<Vec<R>> {
        match count {
            1 => guarded(|| vec![one(0)]),
            _ => {
                let pool = pool()?;
                guarded(|| pool.install(|| (0..count).into_par_iter().map(one).collect()))
            }
        }
    }

    /// Change of a step: A δx + B δu + P δp.
    fn advance(
        &self,
        (linear, by_parameters): &(Linearization, Option<DMatrix<f64>>),
        dx: &DVector<f64>,
        du: Option<&[f64]>,
        dp: Option<&[f64]>,
    ) -> DVector<f64> {
        let mut out = &linear.a * dx;
        if let Some(du) = du {
            out += &linear.b * DVector::from_column_slice(du);
        }
        if let (Some(all), Some(dp)) = (by_parameters, dp) {
            out += all * DVector::from_column_slice(dp);
        }
        out
    }

    /// Derivatives in the coordinates of q, in v and in the state of contact, from those in the tangent of the start, written where they are wanted.
    fn write_slopes(&self, k: usize, direction: usize, slopes: &Derivatives<'_>, out: &mut [f64]) {
        let (model, mut first) = (self.model(k), 0);
        let nv = model.nv();
        for &i in &self.call.active {
            let width = self.rows.widths[i];
            let own = &mut out[first + direction * width..first + (direction + 1) * width];
            match i {
                0 => {
                    let tangent = slopes.start.rows(0, nv);
                    let all = model
                        .difference_jacobian(self.rows.row(0, k))
                        .tr_mul(&tangent);
                    own.copy_from_slice(all.as_slice());
                }
                1 => own.copy_from_slice(&slopes.start.as_slice()[nv..2 * nv]),
                2 => own.copy_from_slice(slopes.inputs),
                3 if self.has_contact => own.copy_from_slice(&slopes.start.as_slice()[2 * nv..]),
                _ => own.copy_from_slice(&slopes.parameters[..width]),
            }
            first += width * self.call.directions;
        }
    }
}

/// Derivatives of a weighted sum.
struct Derivatives<'a> {
    start: &'a DVector<f64>,
    inputs: &'a [f64],
    parameters: &'a [f64],
}

/// Jacobian of a step in all parameters of the model, row by row by its adjoint.
fn by_parameters(simulator: &Simulator, state: &State, u: &[f64]) -> DMatrix<f64> {
    let (n, count) = (
        simulator.n_tangent(),
        simulator.model().parameter_layout().names().len(),
    );
    let mut scratch = VjpScratch::new(simulator);
    let mut out = DMatrix::zeros(n, count);
    let mut unit = vec![0.0; n];
    for i in 0..n {
        unit[i] = 1.0;
        let mut all = StepGradient::zeros(simulator).with_model_parameters_only(simulator);
        simulator.vjp_into(state, u, &unit, &mut scratch, &mut all);
        let row = all.parameters.rows(0, count);
        out.row_mut(i).copy_from(&row.transpose());
        unit[i] = 0.0;
    }
    out
}

/// A step, its changes or derivatives.
pub(super) fn step(
    call: &Call<'_>,
    own: &PySimulator,
    signature: &Signature,
    rows: &Rows<'_>,
    found: &[usize],
    out: &mut [&mut [f64]],
) -> PyResult<()> {
    let steps = Steps::new(call, own, signature, rows)?;
    if call.kind == Kind::Value && steps.robots.is_none() {
        return own.step_slice(&steps.slice(), out);
    }
    let next = steps.each(call.count, |k| {
        steps.robot(k).step(&steps.states[k], rows.row(2, k))
    })?;
    if let Some(k) = next.iter().position(|state| !state.is_finite()) {
        return Err(diverged((call.count > 1).then_some(k)));
    }
    let needs = call.kind == Kind::Push
        || (call.kind == Kind::Pull && call.directions > FEW && !call.has_parameters);
    let linear = match needs {
        true => steps.linear(&steps.states, rows.arrays[2])?,
        false => Vec::new(),
    };
    let one = |k: usize, out: &mut [f64]| -> Result<(), PyErr> {
        match call.kind {
            Kind::Value => write_trajectory(&next[k..=k], steps.has_contact, out),
            Kind::Push => steps.push(k, &next[k..=k], &linear[k..=k], out),
            Kind::Pull => steps.pull_step(k, &next[k], linear.get(k).map(|pair| &pair.0), out),
        }
        Ok(())
    };
    in_rows(call.count, found, out, one)?
}

impl Steps<'_> {
    fn change_of_parameters(&self, k: usize, direction: usize) -> Option<&[f64]> {
        let changes = self.call.has_parameters;
        changes
            .then(|| self.change(self.parameters, k, direction))
            .flatten()
    }

    /// Weights of the results of a row along a direction.
    fn weights(&self, k: usize, direction: usize) -> [&[f64]; 3] {
        let count = if self.has_contact { 3 } else { 2 };
        std::array::from_fn(|p| {
            let all = if p < count { self.more(p, k) } else { &[] };
            let width = all.len() / self.call.directions.max(1);
            &all[direction * width..(direction + 1) * width]
        })
    }

    fn pull_step(&self, k: usize, next: &State, linear: Option<&Linearization>, out: &mut [f64]) {
        let (simulator, u) = (self.robot(k), self.rows.row(2, k));
        let nv = simulator.model().nv();
        let to_coordinates = simulator.model().integrate_jacobian(next.q.as_slice());
        let mut scratch = linear.is_none().then(|| VjpScratch::new(simulator));
        for d in 0..self.call.directions {
            let [by_q, by_v, by_contact] = self.weights(k, d);
            let mut adjoint = DVector::zeros(simulator.n_tangent());
            adjoint
                .rows_mut(0, nv)
                .copy_from(&to_coordinates.tr_mul(&DVector::from_column_slice(by_q)));
            adjoint.rows_mut(nv, nv).copy_from_slice(by_v);
            adjoint
                .rows_mut(2 * nv, by_contact.len())
                .copy_from_slice(by_contact);
            let mut all = StepGradient::zeros(simulator);
            all = match self.call.has_parameters {
                true => all.with_model_parameters_only(simulator),
                false => all.without_parameters(),
            };
            match (linear, &mut scratch) {
                (None, Some(scratch)) => {
                    simulator.vjp_into(&self.states[k], u, adjoint.as_slice(), scratch, &mut all)
                }
                (Some(linear), _) => {
                    (all.state, all.input) = (linear.a.tr_mul(&adjoint), linear.b.tr_mul(&adjoint))
                }
                (None, None) => {}
            }
            let slopes = Derivatives {
                start: &all.state,
                inputs: all.input.as_slice(),
                parameters: all.parameters.as_slice(),
            };
            self.write_slopes(k, d, &slopes, out);
        }
    }

    /// All states of the k-th rollout; those it does not reach are not numbers.
    fn trajectory(&self, k: usize) -> Vec<State> {
        let (steps, nu) = (self.call.steps, self.own.simulator.nu());
        let (inputs, mut step) = (self.rows.row(2, k), 0);
        let rollout = self.robot(k).rollout(&self.states[k], steps, |_, _, u| {
            u.copy_from_slice(&inputs[step * nu..(step + 1) * nu]);
            step += 1;
        });
        let mut all = rollout.states;
        let mut lost = self.states[k].clone();
        lost.numbers_mut().for_each(|x| *x = f64::NAN);
        all.resize(steps + 1, lost);
        all
    }

    /// Changes of the states of a row along its directions: of those behind each of so many steps, and of the start before them if it is among the states.
    fn push(
        &self,
        k: usize,
        states: &[State],
        linear: &[(Linearization, Option<DMatrix<f64>>)],
        out: &mut [f64],
    ) {
        let (model, nu) = (self.model(k), self.own.simulator.nu());
        let (nq, nv, n) = (model.nq(), model.nv(), states.len());
        let chart = |state: &State| model.integrate_jacobian(state.q.as_slice());
        let charts: Vec<_> = states.iter().map(chart).collect();
        let (by_q, rest) = out.split_at_mut(nq * n * self.call.directions);
        let (by_v, by_contact) = rest.split_at_mut(nv * n * self.call.directions);
        let nc = by_contact.len() / (n * self.call.directions).max(1);
        for d in 0..self.call.directions {
            let mut dx = self.change_of_start(k, d);
            for t in 0..=linear.len() {
                if t > 0 {
                    let du = self.change(2, k, d).map(|all| &all[(t - 1) * nu..t * nu]);
                    dx = self.advance(&linear[t - 1], &dx, du, self.change_of_parameters(k, d));
                }
                let Some(i) = (t + n).checked_sub(linear.len() + 1) else {
                    continue;
                };
                let at = d * n + i;
                by_q[at * nq..(at + 1) * nq]
                    .copy_from_slice((&charts[i] * dx.rows(0, nv)).as_slice());
                by_v[at * nv..(at + 1) * nv].copy_from_slice(dx.rows(nv, nv).as_slice());
                by_contact[at * nc..(at + 1) * nc]
                    .copy_from_slice(&dx.as_slice()[2 * nv..2 * nv + nc]);
            }
        }
    }

    fn pull_rollout(&self, k: usize, out: &mut [f64]) {
        let (simulator, steps, nu) = (self.robot(k), self.call.steps, self.own.simulator.nu());
        let parameters = match self.call.has_parameters {
            true => WantedParameters::Model,
            false => WantedParameters::None,
        };
        let options = RolloutGradientOptions {
            parameters,
            ..RolloutGradientOptions::default()
        };
        let inputs = self.rows.row(2, k);
        let inputs: Vec<_> = (0..steps)
            .map(|t| DVector::from_column_slice(&inputs[t * nu..(t + 1) * nu]))
            .collect();
        for d in 0..self.call.directions {
            let [q, v, contact] = self.weights(k, d);
            let contact = self.has_contact.then_some(contact);
            let cost = Weighted {
                steps,
                q: Some(q),
                v: Some(v),
                contact,
                u: None,
            };
            let start = std::slice::from_ref(&self.states[k]);
            let all = simulator.rollout_gradients(start, &[&inputs], &cost, &options);
            let [all] = &all[..] else { continue };
            let by_inputs: Vec<f64> = all.inputs.iter().flat_map(|u| u.iter().copied()).collect();
            let slopes = Derivatives {
                start: &all.start,
                inputs: &by_inputs,
                parameters: all.parameters.as_slice(),
            };
            self.write_slopes(k, d, &slopes, out);
        }
    }
}

/// A rollout, its changes or derivatives.
pub(super) fn rollout(
    call: &Call<'_>,
    own: &PySimulator,
    signature: &Signature,
    rows: &Rows<'_>,
    found: &[usize],
    out: &mut [&mut [f64]],
) -> PyResult<()> {
    let steps = Steps::new(call, own, signature, rows)?;
    match call.kind {
        Kind::Value if steps.robots.is_none() => {
            own.rollout_slice(&steps.states, rows.arrays[2], call.steps, out)
        }
        Kind::Value => in_rows(call.count, found, out, |k, out| -> Result<(), PyErr> {
            write_trajectory(&steps.trajectory(k), steps.has_contact, out);
            Ok(())
        })?,
        Kind::Push => {
            let all = steps.each(call.count, |k| steps.trajectory(k))?;
            let before: Vec<State> = all
                .iter()
                .flat_map(|states| states[..call.steps].to_vec())
                .collect();
            let linear = match before.is_empty() {
                true => Vec::new(),
                false => steps.linear(&before, rows.arrays[2])?,
            };
            in_rows(call.count, found, out, |k, out| -> Result<(), PyErr> {
                let own = &linear[k * call.steps..(k + 1) * call.steps];
                steps.push(k, &all[k], own, out);
                Ok(())
            })?
        }
        Kind::Pull => in_rows(call.count, found, out, |k, out| -> Result<(), PyErr> {
            steps.pull_rollout(k, out);
            Ok(())
        })?,
    }
}

/// Writes all q, then all v, then all states of contact if they are wanted.
fn write_trajectory(states: &[State], has_contact: bool, out: &mut [f64]) {
    let q = states.iter().flat_map(|state| state.q.iter());
    let v = states.iter().flat_map(|state| state.v.iter());
    let contact = states
        .iter()
        .filter(|_| has_contact)
        .flat_map(|state| state.contact.iter().chain(&state.activation));
    let numbers = out.iter_mut().zip(q.chain(v).chain(contact));
    numbers.for_each(|(out, &x)| *out = x);
}
