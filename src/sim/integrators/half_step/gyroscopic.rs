//! Coriolis and centrifugal forces at the middle of a step.
//!
//! These forces c(q, v) grow with the square of the velocity, and rotate the motion of spinning bodies. Evaluated at the start of a step they add
//! energy: a nutation at the rate λ grows by the factor √(1 + (λ Δt)²) in each step. Evaluated in the middle, at v + ½ Δt a, and to first order in
//! the acceleration,
//!
//! > M a + c(v) + ½ Δt ∂c/∂v a = τ − g,
//!
//! they add none: this is the implicit midpoint rule, which conserves energy and momentum of a free body to third order in Δt, and is stable at all rates.
//!
//! Kinematic constraints also act on a₀, with additional forces: otherwise these forces would be those of another motion, and add energy to linkages.
//!
//! For joints with rotating axes, v and a exclude the linear velocity of the centre of mass r here: it is stepped in the fixed joint frame. The
//! remainder is N v: rotation about r, with the linear velocity −ω × r of the origin; ∂c/∂v means ∂c/∂v N at N v.

use nalgebra::Vector3;

use super::half_step;
use crate::dynamics::{CoriolisScratch, TreeMatrix, add_coriolis_matrix};
use crate::joint::Joint;
use crate::model::manifold::v_range;
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::bilateral::Bilateral;
use crate::sim::integrators::tree_lu::TreeLu;
use crate::sim::placed::add_diagonal;
use crate::spatial::linear::cross;

/// Coriolis and centrifugal forces c of a step, to first order in the acceleration: derivatives, factors, working memory.
#[derive(Clone, Debug)]
pub(crate) struct Gyroscopic<T> {
    coriolis: CoriolisScratch<T>,
    /// N v: the velocity without that of centres of mass of joints whose axes turn.
    pub(super) v: Vec<T>,
    /// ∂c/∂v N at that velocity, zero in the columns that are left out.
    pub(super) slope: TreeMatrix<T>,
    /// Factors of M + s ∂c/∂v.
    pub(super) factor: TreeLu<T>,
    /// The rows that hold a₀.
    pub(super) bilateral: Bilateral<T>,
    /// The acceleration a₀ under the forces that were given.
    pub(in crate::sim::integrators) a: Vec<T>,
    /// ∂c/∂v a₀.
    pub(super) change: Vec<T>,
}

impl<T: Scalar> Gyroscopic<T> {
    /// Memory for a model, held by so many rows.
    pub(super) fn new<P: Scalar>(model: &Model<P>, rows: usize) -> Self {
        let nv = model.nv();
        Self {
            coriolis: CoriolisScratch::new(model),
            v: vec![T::zero(); nv],
            slope: TreeMatrix::zeros(model),
            factor: TreeLu::new(model),
            bilateral: Bilateral::new(rows, nv),
            a: vec![T::zero(); nv],
            change: vec![T::zero(); nv],
        }
    }

    /// Finds ∂c/∂v at a state whose mass matrix has `mass` for its upper triangle.
    ///
    /// The Coriolis matrix gives it, except for the order of rotations: ∂c/∂v u = 2 C(v) u − M (ω × u)  along the axes of joints that rotate about
    /// several axes, because there C(v) u − C(u) v = M (ω × u). If v and u rotate about r, so does ω × u.
    fn differentiate<P: Scalar>(&mut self, model: &Model<P>, q: &[T], v: &[T], mass: &TreeMatrix<T>)
    where
        T: Over<P>,
    {
        self.v.copy_from_slice(v);
        keep_spin(model, &mut self.v);
        self.slope.values_mut().fill(T::zero());
        add_coriolis_matrix(model, q, &self.v, &mut self.coriolis, &mut self.slope);
        let all = self.slope.values_mut().iter_mut();
        all.for_each(|x| *x = *x * 2.0);
        self.fold_columns(model);
        for body in model.independent() {
            if body.joint.quaternion().is_some() {
                self.reorder_turns(model, body, mass);
            }
        }
    }

    /// From ∂c/∂v to ∂c/∂v N, column by column.
    fn fold_columns<P: Scalar>(&mut self, model: &Model<P>)
    where
        T: Over<P>,
    {
        let slope = &mut self.slope;
        each_spin(model, |l, k, x: T| {
            for row in slope.in_tree(k).0 {
                let linear = slope[(row, l)];
                slope[(row, k)] += linear * x;
            }
        });
        each_left_out(model, |l| {
            for row in slope.in_tree(l).0 {
                slope[(row, l)] = T::zero();
            }
        });
    }

    /// Subtracts M N (ω × u) in the columns of the rotations of a joint; rotor inertias act in their own coordinates and do not rotate.
    fn reorder_turns<P: Scalar>(&mut self, model: &Model<P>, body: &Body<P>, mass: &TreeMatrix<T>)
    where
        T: Over<P>,
    {
        let first = v_range(body).end - 3;
        let omega = Vector3::from_fn(|k, _| self.v[first + k]);
        let entry = |row: usize, column: usize| match row == column {
            true => mass[(row, row)] - model.armature()[row],
            false => mass[(row.min(column), row.max(column))],
        };
        for row in self.slope.in_tree(first).0 {
            let mut inertia = Vector3::from_fn(|k, _| entry(row, first + k));
            body.each_spin(|l, k, x: T| inertia[k - first] += entry(row, l) * x);
            // Iᵀ (ω × u) = (I × ω)ᵀ u
            let along = cross(&inertia, &omega);
            for k in 0..3 {
                self.slope[(row, first + k)] -= along[k];
            }
        }
    }

    /// Finds a₀ and ∂c/∂v a₀ with  (M + s ∂c/∂v) a₀ − Jᵀ λ₀ = τ − h  and  J a₀ = r − R λ₀  at the point of [`differentiate`](Self::differentiate).
    ///
    /// * `mass` – M with the implicit damping diagonal; only the upper triangle is read
    /// * `s` – half of the step for the rule above, 0 for the forces of its start, s
    /// * `forces` – τ − h at the start of the step
    /// * `held` – J, row by row, and r and R of each; empty for none; a row with an infinite R takes no part
    fn solve(
        &mut self,
        mass: &TreeMatrix<T>,
        s: T,
        forces: &[T],
        held: (&[T], impl Iterator<Item = (T, T)>),
    ) {
        let slope = &self.slope;
        let entry = |i: usize, j: usize| mass[(i.min(j), i.max(j))] + slope[(i, j)] * s;
        self.factor.factorize(entry);
        self.a.copy_from_slice(forces);
        self.factor.solve(&mut self.a);
        let (a, (jacobian, wanted)) = (&mut self.a, held);
        self.bilateral.hold(&self.factor, jacobian, wanted, a);
        self.change.fill(T::zero());
        let (change, a) = (&mut self.change, &self.a);
        let mut add = |i: usize, j: usize| change[i] = slope[(i, j)].mul_add(a[j], change[i]);
        for k in 0..a.len() {
            add(k, k);
            for &i in self.factor.ancestors_of(k) {
                add(i, k);
                add(k, i);
            }
        }
    }

    /// Subtracts from τ − h the change of these forces until the middle of a step, and adds the corresponding terms to M.
    ///
    /// * `mass` – M, of which the upper triangle is read
    /// * `held` – of constraints along the velocity of the start: J, row by row, and the accelerations J a₀; empty for none
    pub(in crate::sim::integrators) fn correct<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        resistance: &[T],
        mass: &mut TreeMatrix<T>,
        forces: &mut [T],
        held: (&[T], impl Iterator<Item = (T, T)>),
    ) where
        T: Over<P>,
    {
        let s = half_step(at);
        self.differentiate(at.model(), at.q(), at.v(), mass);
        add_diagonal(mass, resistance);
        self.solve(mass, s, forces, held);
        self.subtract(s, forces);
    }

    /// The velocity N (v ± s a₀): as c is quadratic in v,  s ∂c/∂v N a₀ = ½ (c(N (v + s a₀)) − c(N (v − s a₀))).
    pub(super) fn velocity_into<P: Scalar>(&self, model: &Model<P>, s: T, side: f64, out: &mut [T])
    where
        T: Over<P>,
    {
        for (out, (&v, &a)) in out.iter_mut().zip(self.v.iter().zip(&self.a)) {
            *out = v + s * a * side;
        }
        keep_spin(model, out);
    }

    /// Subtracts s ∂c/∂v a₀ from forces of the start of a step: with the remainder, M alone gives a₀. No change for s = 0.
    pub(super) fn subtract(&self, s: T, forces: &mut [T]) {
        for (force, &change) in forces.iter_mut().zip(&self.change) {
            *force = T::zero().select_lt(s, *force - change * s, *force);
        }
    }
}

/// From v to N v: bodies of joints whose axes rotate with them rotate about their centres of mass.
fn keep_spin<P: Scalar, T: Over<P>>(model: &Model<P>, v: &mut [T]) {
    each_left_out(model, |l| v[l] = T::zero());
    each_spin(model, |l, k, x: T| {
        let turned = v[k] * x;
        v[l] += turned;
    });
}

/// From weights of N v to those of v.
pub(super) fn fold_weights<P: Scalar, T: Over<P>>(model: &Model<P>, by_v: &mut [T]) {
    each_spin(model, |l, k, x: T| {
        let weight = by_v[l] * x;
        by_v[k] += weight;
    });
    each_left_out(model, |l| by_v[l] = T::zero());
}

/// Passes each entry of N outside its diagonal to `each`, with its row and its column.
pub(super) fn each_spin<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    mut each: impl FnMut(usize, usize, T),
) {
    for body in model.independent() {
        body.each_spin(&mut each);
    }
}

/// Passes the coordinates of linear velocities along body axes to `each`.
pub(super) fn each_left_out<P: Scalar>(model: &Model<P>, mut each: impl FnMut(usize)) {
    for body in model.independent() {
        if body.joint.turns_with_body() {
            let linear = body.axes().filter(|(_, axis)| !axis.is_angular());
            linear.for_each(|(k, _)| each(k));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{bias_forces, mass_matrix};
    use crate::model::samples;
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    // c is quadratic in the velocity, so  ∂c/∂v u = ½ (c(v + u) − c(v − u))  exactly.
    #[test]
    fn slope_equals_the_polarised_bias_forces_on_every_joint_kind() {
        for seed in 0..20 {
            let model = samples::random_tree(9, seed).with_gravity(Vector3::zeros());
            let last = model.nv() - 1;
            let model = model.with_armature(last, 0.3);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 2.0);
            let mut u = model.random_velocity(&mut rng, 2.0);
            let mut still = v.clone();
            keep_spin(&model, u.as_mut_slice());
            keep_spin(&model, still.as_mut_slice());
            let c = |v: DVector<f64>| bias_forces(&model, q.as_slice(), v.as_slice());
            let expected = (c(&still + &u) - c(&still - &u)) * 0.5;
            let mut gyroscopic = Gyroscopic::new(&model, 0);
            let mut mass = TreeMatrix::zeros(&model);
            mass.copy_from(&mass_matrix(&model, q.as_slice()));
            gyroscopic.differentiate(&model, q.as_slice(), v.as_slice(), &mass);
            let slope = &gyroscopic.slope;
            let product = DVector::from_fn(model.nv(), |i, _| {
                (0..model.nv())
                    .map(|j| slope.entry(i, j) * u[j])
                    .sum::<f64>()
            });
            let error = (product - &expected).amax();
            assert!(
                error < 1e-11 * expected.amax().max(1.0),
                "tree {seed}: {error:e}"
            );
        }
    }
}
