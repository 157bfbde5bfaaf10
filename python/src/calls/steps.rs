//! Steps and rollouts with their derivatives.

use dualbody::Linearization;
use dualbody::error::StructureMismatch;
use dualbody::linearize::{RolloutGradientOptions, StepGradient, VjpScratch, WantedParameters};

use super::{Call, Kind, Rows, Signature};
use crate::prelude::*;
use crate::simulator::{States, Weighted, check_finite, diverged, pull_step, write_row};

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
        check_finite(signature.names[2], rows.arrays[2])?;
        let mut out = Self {
            call,
            own,
            rows,
            has_contact: parameters == 4,
            parameters,
            robots: None,
            states: Vec::new(),
        };
        out.states = own.states(out.given(), call.count)?;
        if call.has_parameters {
            let changed = || (0..call.count).map(|k| out.changed(k)).collect();
            let all: Result<_, StructureMismatch> = guarded(changed)?;
            out.robots = Some(all.or_raise()?);
        }
        Ok(out)
    }

    /// States and inputs.
    fn given(&self) -> States<'a> {
        let view = |i: usize| View::of_batch(self.rows.arrays[i], self.rows.widths[i]);
        States {
            q: view(0),
            v: view(1),
            u: Some(view(2)),
            contact: self.has_contact.then(|| view(3)),
            is_batch: self.call.count > 1,
        }
    }

    fn changed(&self, k: usize) -> Result<Simulator, StructureMismatch> {
        let model = self.own.simulator.model();
        let model = model.with_parameters(self.rows.row(self.parameters, k));
        self.own.simulator.with_model(model)
    }

    fn robot(&self, k: usize) -> &Simulator {
        self.robots
            .as_ref()
            .map_or(&*self.own.simulator, |all| &all[k])
    }

    fn model(&self, k: usize) -> &Model {
        self.robot(k).model()
    }

    /// The changes of an input along a direction; none if it does not change.
    fn change(&self, i: usize, k: usize, direction: usize) -> Option<&[f64]> {
        let p = self.call.active.iter().position(|&own| own == i)?;
        let width = self.rows.widths[i];
        Some(&self.rows.more(p, k)[direction * width..(direction + 1) * width])
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
                let rest = &mut out.as_mut_slice()[first..];
                copy_known(dx, rest);
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
            None => self.own.linearize_states(states, inputs, None)?,
            Some(_) => {
                let one = |k: usize| self.robot(of(k)).linearize(&states[k], u(k));
                each(states.len(), one)?
            }
        };
        let changes = self.call.has_parameters && self.call.active.contains(&self.parameters);
        let one = |k: usize| changes.then(|| by_parameters(self.robot(of(k)), &states[k], u(k)));
        let by_parameters = each(states.len(), one)?;
        Ok(linear.into_iter().zip(by_parameters).collect())
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
    fn write_slopes(
        &self,
        (k, direction): (usize, usize),
        [start, inputs, parameters]: [&[f64]; 3],
        out: &mut [f64],
    ) {
        let (model, mut first) = (self.model(k), 0);
        let nv = model.nv();
        for &i in &self.call.active {
            let width = self.rows.widths[i];
            let own = &mut out[first + direction * width..first + (direction + 1) * width];
            match i {
                0 => {
                    let tangent = DVector::from_column_slice(&start[..nv]);
                    let all = model
                        .difference_jacobian(self.rows.row(0, k))
                        .tr_mul(&tangent);
                    own.copy_from_slice(all.as_slice());
                }
                1 => own.copy_from_slice(&start[nv..2 * nv]),
                2 => own.copy_from_slice(inputs),
                3 if self.has_contact => copy_known(&start[2 * nv..], own),
                _ => own.copy_from_slice(&parameters[..width]),
            }
            first += width * self.call.directions;
        }
    }
}

/// Copies a list to the front of a longer one, and fills the rest with zeros: a state has numbers for sleep, its tangent has none.
fn copy_known(from: &[f64], to: &mut [f64]) {
    let n = from.len().min(to.len());
    to[..n].copy_from_slice(&from[..n]);
    to[n..].fill(0.0);
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
        let wanted = WantedParameters::Model;
        let all = pull_step(simulator, wanted, (state, u), &unit, &mut scratch);
        out.row_mut(i).copy_from(&all.parameters.transpose());
        unit[i] = 0.0;
    }
    out
}

impl Steps<'_> {
    /// Weights of the results of a row along a direction.
    fn weights(&self, k: usize, direction: usize) -> [&[f64]; 3] {
        let count = if self.has_contact { 3 } else { 2 };
        std::array::from_fn(|p| {
            let all = if p < count { self.rows.more(p, k) } else { &[] };
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
            copy_known(by_contact, &mut adjoint.as_mut_slice()[2 * nv..]);
            let all = match (linear, &mut scratch) {
                (Some(linear), _) => {
                    let mut all = StepGradient::zeros(simulator).without_parameters();
                    (all.state, all.input) = (linear.a.tr_mul(&adjoint), linear.b.tr_mul(&adjoint));
                    all
                }
                (None, Some(scratch)) => {
                    let (at, adjoint) = ((&self.states[k], u), adjoint.as_slice());
                    pull_step(simulator, self.wanted(), at, adjoint, scratch)
                }
                (None, None) => continue,
            };
            let slopes = [&all.state, &all.input, &all.parameters].map(DVector::as_slice);
            self.write_slopes((k, d), slopes, out);
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
        let [by_q, by_v, by_contact] = parts(model, n * self.call.directions, out);
        let nc = by_contact.len() / (n * self.call.directions).max(1);
        for d in 0..self.call.directions {
            let mut dx = self.change_of_start(k, d);
            for t in 0..=linear.len() {
                if t > 0 {
                    let du = self.change(2, k, d).map(|all| &all[(t - 1) * nu..t * nu]);
                    dx = self.advance(&linear[t - 1], &dx, du, self.change(self.parameters, k, d));
                }
                let Some(i) = (t + n).checked_sub(linear.len() + 1) else {
                    continue;
                };
                let at = d * n + i;
                by_q[at * nq..(at + 1) * nq]
                    .copy_from_slice((&charts[i] * dx.rows(0, nv)).as_slice());
                by_v[at * nv..(at + 1) * nv].copy_from_slice(dx.rows(nv, nv).as_slice());
                let own = &mut by_contact[at * nc..(at + 1) * nc];
                copy_known(&dx.as_slice()[2 * nv..], own);
            }
        }
    }

    fn wanted(&self) -> WantedParameters {
        match self.call.has_parameters {
            true => WantedParameters::Model,
            false => WantedParameters::None,
        }
    }

    fn pull_rollout(&self, k: usize, out: &mut [f64]) {
        let options = RolloutGradientOptions {
            parameters: self.wanted(),
            ..RolloutGradientOptions::default()
        };
        for d in 0..self.call.directions {
            let [q, v, contact] = self.weights(k, d);
            let cost = Weighted {
                steps: self.call.steps,
                q,
                v,
                contact,
                u: &[],
            };
            let (start, inputs) = (&self.states[k], self.rows.row(2, k));
            let all = cost.pull(self.robot(k), start, inputs, &options);
            let by_inputs: Vec<f64> = all.inputs.iter().flat_map(|u| u.iter().copied()).collect();
            let slopes = [all.start.as_slice(), &by_inputs, all.parameters.as_slice()];
            self.write_slopes((k, d), slopes, out);
        }
    }

    /// The states of the results of a row: that after a step, or all those of a rollout.
    fn results(&self, k: usize) -> Vec<State> {
        match self.call.is_step() {
            true => vec![self.robot(k).step(&self.states[k], self.rows.row(2, k))],
            false => self.trajectory(k),
        }
    }

    /// Jacobians of all steps, row after row, where the call needs them.
    fn linear_steps(
        &self,
        results: &[Vec<State>],
    ) -> PyResult<Vec<(Linearization, Option<DMatrix<f64>>)>> {
        let (call, inputs) = (self.call, self.rows.arrays[2]);
        let is_wide = call.directions > FEW && !call.has_parameters;
        match (call.kind, call.is_step()) {
            (Kind::Push, false) => {
                let before = results.iter().flat_map(|all| all[..call.steps].to_vec());
                self.linear(&before.collect::<Vec<_>>(), inputs)
            }
            (Kind::Push, true) => self.linear(&self.states, inputs),
            (Kind::Pull, true) if is_wide => self.linear(&self.states, inputs),
            _ => Ok(Vec::new()),
        }
    }
}

/// Steps or rollouts, their changes or derivatives.
pub(super) fn run(
    call: &Call<'_>,
    own: &PySimulator,
    signature: &Signature,
    rows: &Rows<'_>,
    found: &[usize],
    out: &mut [&mut [f64]],
) -> PyResult<()> {
    let (steps, is_step) = (Steps::new(call, own, signature, rows)?, call.is_step());
    if call.kind == Kind::Value && steps.robots.is_none() {
        return match (is_step, call.count) {
            (true, 1) => own.step_one(steps.given(), out, |memory| own.step_in(memory)),
            (true, count) => own.step_batch(&steps.given(), count, None, out),
            _ => own.rollout_slice(&steps.states, rows.arrays[2], call.steps, out),
        };
    }
    let results = match call.kind == Kind::Pull && !is_step {
        true => Vec::new(),
        false => each(call.count, |k| steps.results(k))?,
    };
    let is_lost = |all: &Vec<State>| is_step && !all[0].is_finite();
    if let Some(k) = results.iter().position(is_lost) {
        return Err(diverged((call.count > 1).then_some(k)));
    }
    let linear = steps.linear_steps(&results)?;
    let n = linear.len() / call.count.max(1);
    in_rows(call.count, found, out, &|k, out| {
        let linear = &linear[k * n..(k + 1) * n];
        match (call.kind, is_step) {
            (Kind::Value, _) => {
                let mut out = parts(steps.model(k), results[k].len(), out);
                let states = results[k].iter().enumerate();
                states.for_each(|(i, state)| write_row(state, i, &mut out, |&x| x));
            }
            (Kind::Push, _) => steps.push(k, &results[k], linear, out),
            (Kind::Pull, true) => {
                let linear = linear.first().map(|(linear, _)| linear);
                steps.pull_step(k, &results[k][0], linear, out);
            }
            (Kind::Pull, false) => steps.pull_rollout(k, out),
        }
        Ok(())
    })
}

/// Room for so many q, for as many v, and for the states of contact.
fn parts<'o>(model: &Model, count: usize, out: &'o mut [f64]) -> [&'o mut [f64]; 3] {
    let (q, rest) = out.split_at_mut(model.nq() * count);
    let (v, contact) = rest.split_at_mut(model.nv() * count);
    [q, v, contact]
}
