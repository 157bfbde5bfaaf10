//! The defects of an interval: how far it is from a cubic that obeys the dynamics at both ends and in the middle.
//!
//! In tangent coordinates ξ of the first node (`chart.rs`), with f₀ its rate and h the length of the interval,
//!
//! ```text
//!   Hermite:  (ξₘ − ½ ξ₁) / h − (f₀ − ξ̇₁) / 8 = 0      the middle is where the cubic is
//!   Simpson:  ξ₁ / h − (f₀ + 4 ξ̇ₘ + ξ̇₁) / 6 = 0        the end is where the integral of the rates leads
//! ```
//!
//! Divided by h they are errors of a rate, of one size on fine and coarse meshes.
//!
//! [Hargraves, Paris 1987; Kelly 2017, section 4; Betts 2010, section 4.5].

use nalgebra::{DMatrix, DMatrixView};

use super::chart::{Chart, ChartScratch, FLOW, POINT, RATE, START, XI};
use crate::linearize::Linearization;
use crate::scalar::MapEach;
use crate::trajopt::system::{AnySystem, zero_linearization};

/// The rate of one point, and its Jacobians.
#[derive(Clone, Debug)]
pub(super) struct Flow {
    pub(super) rate: Vec<f64>,
    pub(super) jacobian: Linearization,
}

impl Flow {
    pub(super) fn new(system: &dyn AnySystem) -> Self {
        Self {
            rate: vec![0.0; system.ndx()],
            jacobian: zero_linearization(system),
        }
    }
}

/// Share of the rates in the Hermite defect.
const EIGHTH: f64 = 1.0 / 8.0;
/// Shares of the rates in the Simpson defect.
const SIXTH: f64 = 1.0 / 6.0;
const FOUR_SIXTHS: f64 = 4.0 / 6.0;

/// The defects of one interval.
#[derive(Clone, Debug)]
pub(super) struct Defects {
    /// Hermite, then Simpson, length 2 `ndx`.
    pub(super) values: Vec<f64>,
    /// Their derivatives in (δx, δu) at start, middle and end, 2 `ndx` × (`ndx` + `nu`) each.
    pub(super) blocks: [DMatrix<f64>; 3],
    middle: Chart,
    end: Chart,
}

impl Defects {
    pub(super) fn new(system: &dyn AnySystem) -> Self {
        let (ndx, nu) = (system.ndx(), system.nu());
        Self {
            values: vec![0.0; 2 * ndx],
            blocks: [(); 3].map(|()| DMatrix::zeros(2 * ndx, ndx + nu)),
            middle: Chart::new(system),
            end: Chart::new(system),
        }
    }

    /// The defects, from states and rates at start, middle and end.
    pub(super) fn measure(
        &mut self,
        system: &dyn AnySystem,
        [x0, xm, x1]: [&[f64]; 3],
        flows: [&Flow; 3],
    ) {
        let h = system.time_step();
        let [f0, fm, f1] = flows.map_each(|flow| flow.rate.as_slice());
        self.middle.measure(system, x0, xm, fm);
        self.end.measure(system, x0, x1, f1);
        let (m, e) = (&self.middle, &self.end);
        let (hermite, simpson) = self.values.split_at_mut(f0.len());
        for (i, &f0) in f0.iter().enumerate() {
            hermite[i] = (m.xi[i] - 0.5 * e.xi[i]) / h - EIGHTH * (f0 - e.rate[i]);
            simpson[i] = e.xi[i] / h - (SIXTH * (f0 + e.rate[i]) + FOUR_SIXTHS * m.rate[i]);
        }
    }

    /// Their derivatives, from the Jacobians of the rates too.
    pub(super) fn linearize(
        &mut self,
        system: &dyn AnySystem,
        [x0, xm, x1]: [&[f64]; 3],
        [start, middle, end]: [&Flow; 3],
        scratch: &mut ChartScratch,
    ) {
        let inverse_h = 1.0 / system.time_step();
        self.middle.linearize(system, x0, xm, &middle.rate, scratch);
        self.end.linearize(system, x0, x1, &end.rate, scratch);
        self.blocks.iter_mut().for_each(|block| block.fill(0.0));
        let (m, e) = (&self.middle, &self.end);
        let [of_start, of_middle, of_end] = &mut self.blocks;
        // Coefficients of each ξ and ξ̇ in Hermite's and Simpson's defects.
        let (xi_m, xi_e) = ([inverse_h, 0.0], [-0.5 * inverse_h, inverse_h]);
        let (rate_m, rate_e) = ([0.0, -FOUR_SIXTHS], [EIGHTH, -SIXTH]);
        for (chart, xi, rate) in [(m, xi_m, rate_m), (e, xi_e, rate_e)] {
            add(of_start, xi, chart.block(XI, START));
            add(of_start, rate, chart.block(RATE, START));
        }
        for (own, chart, xi, rate) in [
            (&mut *of_middle, m, xi_m, rate_m),
            (&mut *of_end, e, xi_e, rate_e),
        ] {
            add(own, xi, chart.block(XI, POINT));
            add(own, rate, chart.block(RATE, POINT));
        }
        add_flow(of_start, [-EIGHTH, -SIXTH], &start.jacobian, None);
        let curved = !system.is_vector_space();
        let by_flow = |chart: &Chart| curved.then(|| chart.block(RATE, FLOW).into_owned());
        add_flow(of_middle, rate_m, &middle.jacobian, by_flow(m));
        add_flow(of_end, rate_e, &end.jacobian, by_flow(e));
    }
}

/// Adds a matrix, `ndx` × `ndx`, times its shares to the columns of the state in both rows of blocks.
fn add(out: &mut DMatrix<f64>, shares: [f64; 2], m: DMatrixView<'_, f64>) {
    let ndx = m.nrows();
    for (row, share) in shares.into_iter().enumerate() {
        if share != 0.0 {
            let mut block = out.view_mut((row * ndx, 0), (ndx, ndx));
            block.zip_apply(&m, |out, m| *out += share * m);
        }
    }
}

/// Adds the Jacobian of a rate, mapped into the chart where that is not flat.
fn add_flow(
    out: &mut DMatrix<f64>,
    shares: [f64; 2],
    jacobian: &Linearization,
    by_flow: Option<DMatrix<f64>>,
) {
    let ndx = jacobian.a.nrows();
    for (first, m) in [(0, &jacobian.a), (ndx, &jacobian.b)] {
        let mapped = by_flow.as_ref().map(|by_flow| by_flow * m);
        let m = mapped.as_ref().unwrap_or(m);
        for (row, share) in shares.into_iter().enumerate() {
            let mut block = out.view_mut((row * ndx, first), m.shape());
            block.zip_apply(m, |out, m| *out += share * m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::sim::{Simulator, State};
    use crate::tests::FINITE_DIFFERENCE;
    use crate::trajopt::transcription::points::{Points, Sample};
    use crate::trajopt::{InitialState, Problem, Robot, Scratch, System};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Three points near one another, all inputs different.
    fn points(simulator: &Simulator, seed: u64) -> Points {
        let (ndx, nu) = (simulator.ndx(), simulator.nu());
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let start = simulator.pack(&State::random(simulator.model(), &mut rng, 1.0));
        let problem = Problem::new(simulator.clone(), 1, start.as_slice());
        let mut points =
            Points::from_trajectory(&problem, &crate::trajopt::Trajectory::zero_input(&problem));
        let wiggle = |k: usize| 0.3 * (k as f64).sin();
        let dz: Vec<f64> = (0..3 * (ndx + nu)).map(wiggle).collect();
        let from = points.clone();
        from.step(&problem, &dz, 1.0, &mut points);
        points
    }

    fn states(points: &Points) -> [&[f64]; 3] {
        [0, 1, 2].map(|i| points.at(i).x)
    }

    fn defects_at(simulator: &Simulator, points: &Points) -> (Defects, [Flow; 3]) {
        let mut flows = [(); 3].map(|()| Flow::new(simulator));
        let mut scratch = Scratch::new();
        for (i, flow) in flows.iter_mut().enumerate() {
            let Sample { x, u } = points.at(i);
            System::rate(simulator, x, u, &mut scratch, flow.rate.as_mut_slice());
            System::linearize_rate(simulator, x, u, &mut scratch, &mut flow.jacobian);
        }
        let mut defects = Defects::new(simulator);
        defects.measure(simulator, states(points), flows.each_ref());
        (defects, flows)
    }

    #[test]
    fn derivatives_of_the_defects_equal_finite_differences() {
        const STEP: f64 = 1e-5;
        for (seed, model) in [
            samples::cartpole(),
            samples::arm(),
            samples::random_tree(6, 5),
        ]
        .into_iter()
        .enumerate()
        {
            let simulator = Simulator::new(model).with_time_step(0.1);
            let points = points(&simulator, seed as u64);
            // A given first state would not be moved.
            let problem = Problem::new(simulator.clone(), 1, points.states[0].as_slice())
                .with_initial_state(InitialState::Free);
            let (mut defects, flows) = defects_at(&simulator, &points);
            let mut scratch = ChartScratch::new(&simulator);
            defects.linearize(&simulator, states(&points), flows.each_ref(), &mut scratch);
            let nz = simulator.ndx() + simulator.nu();
            for j in 0..3 * nz {
                let at = |step: f64| {
                    let (mut dz, mut moved) = (vec![0.0; 3 * nz], points.clone());
                    dz[j] = step;
                    points.step(&problem, &dz, 1.0, &mut moved);
                    defects_at(&simulator, &moved).0.values
                };
                let (before, after) = (at(-STEP), at(STEP));
                let exact = defects.blocks[j / nz].column(j % nz);
                let scale = defects.blocks[j / nz].amax();
                for (i, exact) in exact.iter().enumerate() {
                    let expected = (after[i] - before[i]) / (2.0 * STEP);
                    let error = (exact - expected).abs() / scale;
                    assert!(
                        error < FINITE_DIFFERENCE,
                        "robot {seed}, ({i}, {j}): {exact} {expected}"
                    );
                }
            }
        }
    }
}
