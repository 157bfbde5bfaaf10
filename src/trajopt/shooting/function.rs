//! The merit of a rollout as a function of its variables.

use std::sync::{MutexGuard, PoisonError};

use nalgebra::{DMatrix, DVector};

use super::SingleShooting;
use super::bound_transform::{BoundTransform, Transformed};
use super::lambdas::Lambdas;
use super::sweep::{Gradient, Sweep, Transposed, Variation, start_jacobian};
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::trajectory::Trajectory;

/// The last point with its evaluations.
pub(super) struct Work {
    sweep: Sweep,
    z: Vec<f64>,
    /// Inputs, each with its derivatives in its variable.
    transformed: Vec<Transformed>,
    /// ∂x₀/∂δx₀, `ndx` × `ndx`; `ndx` × 0 where the first state is given.
    start_map: DMatrix<f64>,
    known: Known,
    /// Whether Hessians are requested, which need the Jacobians of steps. Gradients alone come from vector-Jacobian products of steps.
    has_hessians: bool,
    merit: f64,
}

/// Extent to which the working memory is valid at its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Known {
    Nothing,
    Merit,
    /// Costs to second order.
    Costs,
    /// Jacobians of steps, too.
    Expansion,
}

impl Work {
    pub(super) fn new(problem: &Problem) -> Self {
        Self {
            sweep: Sweep::new(problem),
            z: Vec::new(),
            transformed: Vec::new(),
            start_map: DMatrix::zeros(0, 0),
            known: Known::Nothing,
            has_hessians: false,
            merit: f64::INFINITY,
        }
    }
}

impl SingleShooting<'_> {
    /// Number of variables.
    pub fn dim(&self) -> usize {
        self.start_dim() + self.problem.horizon() * self.problem.dynamics().nu()
    }

    /// Returns the variables of a guess: of its inputs, moved inside their bounds by a thousandth of their range, and of its first state if that is
    /// free. Its other states are ignored. Allocates.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem.
    pub fn variables(&self, guess: &Trajectory) -> Vec<f64> {
        guess.check(self.problem);
        let mut z = vec![0.0; self.start_dim()];
        if !z.is_empty() {
            let (start, first) = (self.problem.start().as_slice(), guess.states[0].as_slice());
            self.problem
                .dynamics()
                .difference(start, first, z.as_mut_slice());
        }
        for u in &guess.inputs {
            let transforms = self.transforms();
            z.extend(transforms.zip(u).map(|(transform, &u)| transform.invert(u)));
        }
        z
    }

    /// Returns the trajectory of variables: it satisfies the dynamics, and its inputs are within their bounds. Allocates.
    ///
    /// # Panics
    /// If the number of variables is not [`dim`](Self::dim).
    pub fn trajectory(&self, z: &[f64]) -> Trajectory {
        self.at(z, Known::Merit).sweep.trajectory.clone()
    }

    /// Computes the cost with the penalties of constraints; infinite if it, or the rollout, is not finite. Costs one rollout.
    ///
    /// # Panics
    /// If the number of variables is not [`dim`](Self::dim).
    pub fn value(&self, z: &[f64]) -> f64 {
        self.at(z, Known::Merit).merit
    }

    /// Computes the exact gradient of [`value`](Self::value) by the adjoint sweep. Costs about as much as the step Jacobians of one rollout.
    ///
    /// # Panics
    /// If the number of variables is not [`dim`](Self::dim).
    pub fn gradient(&self, z: &[f64]) -> DVector<f64> {
        let mut work = self.at(z, Known::Costs);
        if work.has_hessians {
            drop(work);
            work = self.at(z, Known::Expansion);
        }
        let by = match work.known {
            Known::Expansion => Transposed::Jacobians,
            _ => Transposed::Products,
        };
        let gradient = work.sweep.gradient(self.problem, by);
        work.in_variables(&gradient)
    }

    /// Computes the dense Hessian, [`dim`](Self::dim) × [`dim`](Self::dim), by a forward and a backward sweep through the step Jacobians for each
    /// column: O(N²) in the horizon. Gauss–Newton or exact according to [`ShootingOptions::curvature`](super::ShootingOptions::curvature); the
    /// curvature of the bound transform is always included.
    ///
    /// # Panics
    /// If the number of variables is not [`dim`](Self::dim), or with exact curvature where the system
    /// [has no Hessians of its step](crate::trajopt::System::has_step_hessian).
    pub fn hessian(&self, z: &[f64]) -> DMatrix<f64> {
        let mut work = self.at(z, Known::Expansion);
        work.has_hessians = true;
        let gradient = work.sweep.gradient(self.problem, Transposed::Jacobians);
        // Afterwards the expansion is no longer that of the costs alone.
        work.known = Known::Merit;
        let curvature = self.options.curvature;
        work.sweep.complete_hessians(self.problem, curvature);
        let mut out = DMatrix::zeros(z.len(), z.len());
        for (j, mut column) in out.column_iter_mut().enumerate() {
            let moved = work.sweep.hessian_column(work.variation(j));
            column.copy_from(&work.in_variables(&moved));
        }
        let slopes = gradient.inputs.iter().flatten();
        let first = work.start_map.ncols();
        for (j, (u, slope)) in work.transformed.iter().zip(slopes).enumerate() {
            out[(first + j, first + j)] += slope * u.curvature;
        }
        out
    }

    /// λ at zero, with this penalty.
    pub(super) fn reset_multipliers(&mut self, penalty: f64) {
        self.lambdas = Lambdas::new(self.problem, penalty);
        self.lock().known = Known::Nothing;
    }

    /// The multipliers of the constraints at `z` after one more update; those of the function stay.
    pub(super) fn multipliers(&self, z: &[f64]) -> Vec<DVector<f64>> {
        let (mut work, mut updated) = (self.at(z, Known::Merit), self.lambdas.clone());
        work.sweep.update_multipliers(self.problem, &mut updated);
        updated.lambda.into_iter().map(DVector::from_vec).collect()
    }

    /// λ from the violations at `z`, then this penalty.
    pub(super) fn update_multipliers(&mut self, z: &[f64], penalty: f64) {
        drop(self.at(z, Known::Merit));
        let work = self.work.get_mut().unwrap_or_else(PoisonError::into_inner);
        work.sweep
            .update_multipliers(self.problem, &mut self.lambdas);
        work.known = Known::Nothing;
        self.lambdas.mu = penalty;
    }

    /// Number of variables of the first state.
    fn start_dim(&self) -> usize {
        match self.problem.initial() {
            InitialState::Fixed => 0,
            InitialState::Free => self.problem.dynamics().ndx(),
        }
    }

    /// The bounds of the inputs of a stage.
    fn transforms(&self) -> impl Iterator<Item = BoundTransform> {
        let (lower, upper) = self.problem.input_bounds();
        let both = lower.iter().zip(upper);
        both.map(|(&lower, &upper)| BoundTransform { lower, upper })
    }

    fn lock(&self) -> MutexGuard<'_, Work> {
        // A panic in a user's function leaves partial results; they are recomputed.
        self.work.lock().unwrap_or_else(|poisoned| {
            let mut work = PoisonError::into_inner(poisoned);
            work.known = Known::Nothing;
            work
        })
    }

    /// Working memory that knows at least so much of this point.
    fn at(&self, z: &[f64], wanted: Known) -> MutexGuard<'_, Work> {
        assert_eq!(z.len(), self.dim(), "as many variables as the problem has");
        let mut work = self.lock();
        if work.z != z || work.known == Known::Nothing {
            work.known = Known::Nothing;
            self.roll(z, &mut work);
            work.known = Known::Merit;
        }
        if wanted >= Known::Costs && work.known < Known::Costs {
            let curvature = self.options.curvature;
            let (delta, start) = (&z[..self.start_dim()], self.problem.start().as_slice());
            work.start_map = start_jacobian(self.problem.dynamics(), start, delta);
            work.sweep
                .expand_costs(self.problem, &self.lambdas, curvature);
            work.known = Known::Costs;
        }
        if work.known < wanted {
            work.sweep.linearize(self.problem);
            work.known = Known::Expansion;
        }
        work
    }

    /// The rollout of variables, and its merit.
    fn roll(&self, z: &[f64], work: &mut Work) {
        work.z.clear();
        work.z.extend_from_slice(z);
        let (delta, inputs) = z.split_at(self.start_dim());
        let system = self.problem.dynamics();
        let Trajectory { states, inputs: u } = &mut work.sweep.trajectory;
        if !delta.is_empty() {
            let start = self.problem.start().as_slice();
            system.integrate(start, delta, states[0].as_mut_slice());
        }
        work.transformed.clear();
        for (u, z) in u.iter_mut().zip(inputs.chunks_exact(system.nu().max(1))) {
            let transforms = self.transforms().zip(z);
            let transformed = transforms.map(|(transform, &z)| transform.apply(z));
            work.transformed.extend(transformed);
            let own = &work.transformed[work.transformed.len() - u.len()..];
            u.iter_mut().zip(own).for_each(|(u, own)| *u = own.value);
        }
        work.sweep.roll(system);
        let merit = work.sweep.merit(self.problem, &self.lambdas);
        work.merit = if merit.is_finite() {
            merit
        } else {
            f64::INFINITY
        };
    }
}

impl Work {
    /// The chain rule from x₀ and inputs to the variables.
    fn in_variables(&self, gradient: &Gradient) -> DVector<f64> {
        let start = self.start_map.tr_mul(&gradient.start);
        let inputs = gradient.inputs.iter().flatten().zip(&self.transformed);
        let inputs = inputs.map(|(slope, u)| slope * u.slope);
        let all = start.iter().copied().chain(inputs);
        DVector::from_vec(all.collect())
    }

    /// Variation of x₀ or an input by variable `j`.
    fn variation(&self, j: usize) -> Variation<'_> {
        let (ndx, first) = self.start_map.shape();
        if j < first {
            return Variation::Start(&self.start_map.as_slice()[j * ndx..][..ndx]);
        }
        let (of, nu) = (j - first, self.sweep.trajectory.inputs[0].len());
        Variation::Input {
            stage: of / nu,
            entry: of % nu,
            rate: self.transformed[of].slope,
        }
    }
}
