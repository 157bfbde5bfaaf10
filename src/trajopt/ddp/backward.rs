//! The backward pass: the cost-to-go to second order, and the policy of every stage.
//!
//! With δz = (δx, δu), F = [A B] and gaps f, from the end to the start:
//!
//! ```text
//!   vₓ = Vₓ′ + V′ f                                                          (1)
//!   q  = l_z + Fᵀ vₓ,   Q = l_zz + Fᵀ V′ F                                   (2)
//!   δu = −k − K δx:  minimises  ½ δuᵀ (Q_uu + μ I) δu + (q_u + Q_ux δx)ᵀ δu  (3)
//!   V  = Q_xx − Yᵀ Y − μ Kᵀ K   with  L Lᵀ = Q_uu + μ I,  L Y = Q_ux         (4)
//!   Vₓ = q_x − Q_xu k − μ Kᵀ k                                               (5)
//! ```
//!
//! (4) and (5) are the cost of the policy; the regularisation μ affects the choice of the policy, but not its cost. For bounded inputs, (3) is a
//! box-constrained program unless the bounds are dropped; only the free inputs have rows of K.
//!
//! [Tassa, Mansard, Todorov 2014; Mastalli et al. 2020].

use super::stage::{ExpansionPoint, Stage};
use crate::linalg::product::{ColumnMajor, Part, add_scaled, mirror_upper};
use crate::linalg::{Bounds, BoxQp, NotConvex};
use crate::trajopt::curvature::Curvature;
use crate::trajopt::problem::{InitialState, Problem};

/// Whether the policy includes the bounds of the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Limits {
    /// The policy includes them, and may drop them later.
    Untried,
    /// The policy ignores them.
    Dropped,
    /// The policy includes them, and keeps them.
    Kept,
}

/// Working memory of the backward pass.
#[derive(Clone, Debug)]
pub(super) struct Backward {
    /// V, symmetric, and Vₓ of the stage after.
    v: Vec<f64>,
    v_x: Vec<f64>,
    /// Fᵀ V′, by columns.
    ftv: Vec<f64>,
    /// Q by columns, of which the upper triangle is known; q.
    q: Vec<f64>,
    q_z: Vec<f64>,
    /// `Q_uu` + μ I, both triangles.
    q_uu: Vec<f64>,
    /// Yᵀ by columns, `ndx` × the free inputs.
    y_t: Vec<f64>,
    /// Bounds on δu.
    lower: Vec<f64>,
    upper: Vec<f64>,
    qp: BoxQp,
    /// δx₀, and its box: the first state as one more decision.
    pub(super) first: Vec<f64>,
    first_qp: BoxQp,
}

impl Backward {
    pub(super) fn new(problem: &Problem) -> Self {
        let (n, m) = (problem.dynamics().ndx(), problem.dynamics().nu());
        let nz = n + m;
        let zeros = |n: usize| vec![0.0; n];
        Self {
            v: zeros(n * n),
            v_x: zeros(n),
            ftv: zeros(nz * n),
            q: zeros(nz * nz),
            q_z: zeros(nz),
            q_uu: zeros(m * m),
            y_t: zeros(n * m),
            lower: zeros(m),
            upper: zeros(m),
            qp: BoxQp::new(m),
            first: zeros(n),
            first_qp: BoxQp::new(n),
        }
    }

    /// Policies of all stages, with their bounds or without, and δx₀; an error where the regularisation `mu` is too
    /// small.
    pub(super) fn run(
        &mut self,
        at: &ExpansionPoint<'_>,
        stages: &mut [Stage],
        first_gap: &[f64],
        mu: f64,
        limits: Limits,
    ) -> Result<(), NotConvex> {
        let Some((last, rest)) = stages.split_last_mut() else {
            return Ok(());
        };
        let n = self.v_x.len();
        self.v.copy_from_slice(last.expansion.hessian.as_slice());
        self.v_x.copy_from_slice(last.expansion.gradient.as_slice());
        mirror_upper(&mut self.v, n);
        let bounded = limits != Limits::Dropped && at.problem.has_input_bounds();
        for (k, stage) in rest.iter_mut().enumerate().rev() {
            self.propagate(at, k, stage);
            let u = at.trajectory.input(k);
            self.choose_inputs(at.problem, u, bounded, mu, stage)?;
            self.finish(stage, mu);
        }
        self.choose_first_state(at.problem, first_gap, mu)
    }

    /// Equations (1) and (2).
    fn propagate(&mut self, at: &ExpansionPoint<'_>, k: usize, stage: &mut Stage) {
        let (n, nz) = (self.v_x.len(), self.q_z.len());
        if at.has_gaps {
            for (column, &gap) in self.v.chunks_exact(n).zip(&stage.gap) {
                add_scaled(&mut self.v_x, column, gap);
            }
        }
        let ft = columns(&stage.jacobian_t, nz);
        self.ftv.fill(0.0);
        let v = columns(&self.v, n);
        let ftv = ft.times_transposed(v, 1.0);
        ftv.add_to(&mut self.ftv, nz, Part::All);
        self.q.copy_from_slice(stage.expansion.hessian.as_slice());
        let ftv = columns(&self.ftv, nz);
        let ftvf = ftv.times_transposed(ft, 1.0);
        ftvf.add_to(&mut self.q, nz, Part::Upper);
        self.q_z
            .copy_from_slice(stage.expansion.gradient.as_slice());
        for (column, &v_x) in stage.jacobian_t.chunks_exact(nz).zip(&self.v_x) {
            add_scaled(&mut self.q_z, column, v_x);
        }
        if at.curvature == Curvature::Exact {
            let hessian = &mut stage.dynamics_hessian;
            hessian.clear();
            hessian.resize(nz * nz, 0.0);
            let (x, u) = (at.trajectory.states[k].as_slice(), at.trajectory.input(k));
            at.problem
                .dynamics()
                .add_step_hessian(x, u, &self.v_x, hessian);
            add_scaled(&mut self.q, hessian, 1.0);
        }
    }

    /// Equation (3): k into the stage, the factor of the free inputs into the box's memory.
    fn choose_inputs(
        &mut self,
        problem: &Problem,
        u: &[f64],
        bounded: bool,
        mu: f64,
        stage: &mut Stage,
    ) -> Result<(), NotConvex> {
        let (n, nz) = (self.v_x.len(), self.q_z.len());
        let m = nz - n;
        for j in 0..m {
            let column = &self.q[(n + j) * nz + n..][..m];
            self.q_uu[j * m..(j + 1) * m].copy_from_slice(column);
            self.q_uu[j * m + j] += mu;
        }
        let q_u = &self.q_z[n..];
        if bounded {
            mirror_upper(&mut self.q_uu, m);
            let (lower, upper) = problem.input_bounds();
            for i in 0..m {
                self.lower[i] = lower[i] - u[i];
                self.upper[i] = upper[i] - u[i];
            }
            let bounds = Bounds {
                lower: &self.lower,
                upper: &self.upper,
            };
            self.qp.solve(&self.q_uu, q_u, bounds)?;
        } else {
            self.qp.solve_unbounded(&self.q_uu, q_u)?;
        }
        for (k, &d) in stage.feedforward.iter_mut().zip(&self.qp.d) {
            *k = -d;
        }
        let finite = stage.feedforward.iter().all(|k| k.is_finite());
        if finite { Ok(()) } else { Err(NotConvex) }
    }

    /// K, and equations (4) and (5).
    fn finish(&mut self, stage: &mut Stage, mu: f64) {
        let (n, nz) = (self.v_x.len(), self.q_z.len());
        let free = self.qp.factor.free.len();
        self.solve_gains(stage);
        // The upper triangle of Q_xx
        for (v, q) in self.v.chunks_exact_mut(n).zip(self.q.chunks_exact(nz)) {
            v.copy_from_slice(&q[..n]);
        }
        let y_t = columns(&self.y_t[..n * free], n);
        let yy = y_t.times_transposed(y_t, -1.0);
        yy.add_to(&mut self.v, n, Part::Upper);
        let k_t = columns(&stage.gain_t, n);
        let kk = k_t.times_transposed(k_t, -mu);
        kk.add_to(&mut self.v, n, Part::Upper);
        mirror_upper(&mut self.v, n);
        self.v_x.copy_from_slice(&self.q_z[..n]);
        for (j, &k) in stage.feedforward.iter().enumerate() {
            add_scaled(&mut self.v_x, &self.q[(n + j) * nz..][..n], -k);
            add_scaled(&mut self.v_x, &stage.gain_t[j * n..][..n], -mu * k);
        }
    }

    /// Yᵀ Lᵀ = `Q_xu` and Kᵀ L = Yᵀ, over the free inputs, a column at a time; K of the others is zero.
    fn solve_gains(&mut self, stage: &mut Stage) {
        let (n, nz, m) = (self.v_x.len(), self.q_z.len(), self.lower.len());
        let (l, free) = (&self.qp.factor.l, &self.qp.factor.free);
        for (row, &i) in free.iter().enumerate() {
            let (done, rest) = self.y_t.split_at_mut(row * n);
            let y = &mut rest[..n];
            y.copy_from_slice(&self.q[(n + i) * nz..][..n]);
            for (k, earlier) in done.chunks_exact(n).enumerate() {
                add_scaled(y, earlier, -l[row * m + k]);
            }
            let inverse = 1.0 / l[row * m + row];
            y.iter_mut().for_each(|y| *y *= inverse);
        }
        stage.gain_t.fill(0.0);
        for (row, &i) in free.iter().enumerate().rev() {
            let (before, after) = stage.gain_t.split_at_mut((i + 1) * n);
            let k_t = &mut before[i * n..];
            k_t.copy_from_slice(&self.y_t[row * n..][..n]);
            for (later, &at) in free.iter().enumerate().skip(row + 1) {
                add_scaled(k_t, &after[(at - i - 1) * n..][..n], -l[later * m + row]);
            }
            let inverse = 1.0 / l[row * m + row];
            k_t.iter_mut().for_each(|k| *k *= inverse);
        }
    }

    /// δx₀: the step to the given state, or the optimal one.
    fn choose_first_state(
        &mut self,
        problem: &Problem,
        first_gap: &[f64],
        mu: f64,
    ) -> Result<(), NotConvex> {
        if problem.initial() == InitialState::Fixed {
            self.first.copy_from_slice(first_gap);
            return Ok(());
        }
        let n = self.v_x.len();
        for k in 0..n {
            self.v[k * n + k] += mu;
        }
        self.first_qp.solve_unbounded(&self.v, &self.v_x)?;
        self.first.copy_from_slice(&self.first_qp.d);
        Ok(())
    }
}

fn columns(data: &[f64], rows: usize) -> ColumnMajor<'_> {
    ColumnMajor { data, rows }
}

#[cfg(test)]
mod tests {
    use crate::tests::SAME_ALGEBRA;
    use crate::trajopt::tests::{START, linear_quadratic, riccati};
    use crate::trajopt::{Ddp, DdpOptions, RegularizationOptions, Trajectory};

    #[test]
    fn gains_and_cost_of_a_linear_quadratic_problem_equal_riccatis_recursion() {
        for horizon in [1, 2, 7] {
            let problem = linear_quadratic(horizon);
            let options = DdpOptions {
                regularization: RegularizationOptions::none(),
                ..DdpOptions::default()
            };
            let mut ddp = Ddp::with_options(&problem, options);
            let solution = ddp.solve(&problem, &Trajectory::zero_input(&problem));
            let (gains, p) = riccati(horizon);
            assert!(solution.is_converged() && solution.iterations <= 2);
            assert!((solution.cost - 0.5 * p * START * START).abs() < SAME_ALGEBRA);
            for (k, gain) in solution.gains.iter().zip(gains) {
                assert!((k[0] - gain).abs() < SAME_ALGEBRA, "{k} {gain}");
            }
        }
    }
}
