//! The gradient of a kinetic energy under a force, by two passes along the tree.
//!
//! With the motion V that the rates v give to each body,  E = ½ vᵀ M v − F · V  with a force F on one of them, is a sum over the bodies. Where a joint moves on by
//! ξ, seen from the parent, the motion that it hands on changes by X⁻¹ (V × ξ); with the momentum h of all that it carries, less F, E changes by
//! −ξ · (V ×* h): Lagrange's term ∂T/∂q.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::slots::ParameterSlots;
use super::sweep::{Sweep, along_joint};
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, INERTIAL_PARAMETERS, Inertia, Motion};

/// A force under which the energy is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pushed<T> {
    pub(crate) body: BodyId,
    /// F, in the body.
    pub(crate) force: Force<T>,
    /// Derivative of F · V in the pose of the body, by a small motion of it, seen from it, while V stays.
    pub(crate) by_pose: Force<T>,
}

/// Sums of a gradient in a configuration and in parameters, at fixed rates.
#[derive(Debug)]
pub(crate) struct EnergyGradientSum<'a, T> {
    /// In tangent directions of q.
    pub(crate) q: &'a mut [T],
    /// All parameters; empty if they are not wanted.
    pub(crate) parameters: &'a mut [T],
}

/// Working memory of the passes.
#[derive(Clone, Debug)]
pub(crate) struct EnergySweep<T> {
    /// Whether the kinetic energy counts, or the force alone.
    with_mass: bool,
    /// Motion of each body.
    V: Vec<Motion<T>>,
    /// Derivative in it, after the pass inward with those of all that the body carries.
    by_V: Vec<Force<T>>,
    by_pose: Vec<Force<T>>,
}

/// Rates at a configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates<'a, T> {
    pub(crate) q: &'a [T],
    pub(crate) v: &'a [T],
}

impl<T: Scalar> EnergySweep<T> {
    /// Makes memory for a model.
    pub(crate) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            with_mass: true,
            V: vec![Motion::zero(); n],
            by_V: vec![Force::zero(); n],
            by_pose: vec![Force::zero(); n],
        }
    }

    /// The motion of a body, after the pass outward.
    pub(crate) fn motion(&self, body: Option<BodyId>) -> Motion<T> {
        body.map_or_else(Motion::zero, |body| self.V[body.0])
    }

    /// The pass outward.
    ///
    /// * `placed` – a sweep at the configuration, after its own pass outward
    /// * `with_mass` – whether the kinetic energy counts, or the force alone
    pub(crate) fn start<P: Scalar>(
        &mut self,
        model: &Model<P>,
        placed: &Sweep<T>,
        v: &[T],
        with_mass: bool,
    ) where
        T: Over<P>,
    {
        for (i, body) in model.bodies().iter().enumerate() {
            let mut V = body.parent.map_or_else(Motion::zero, |p| {
                placed.bodies[i].X_PB.motion_inverse(&self.V[p.0])
            });
            body.add_motion(v, &mut V);
            self.by_V[i] = match with_mass {
                true => body.inertia.times(&V),
                false => Force::zero(),
            };
            self.V[i] = V;
        }
        self.with_mass = with_mass;
        self.by_pose.fill(Force::zero());
    }

    /// The pass inward: adds the gradient of E, times a weight.
    pub(crate) fn finish<P: Scalar>(
        &mut self,
        model: &Model<P>,
        placed: &Sweep<T>,
        at: &Rates<'_, T>,
        pushed: Option<&Pushed<T>>,
        weight: T,
        out: &mut EnergyGradientSum<'_, T>,
    ) where
        T: Over<P>,
    {
        if let Some(pushed) = pushed {
            let own = pushed.body.0;
            self.by_V[own] = self.by_V[own] - pushed.force;
            self.by_pose[own] = -pushed.by_pose;
        }
        for (i, body) in model.bodies().iter().enumerate().rev() {
            let X = &placed.bodies[i].X_PB;
            let mut turned = X.force(&self.by_pose[i]);
            if let Some(p) = body.parent {
                self.by_pose[p.0] += turned;
                let by_V = X.force(&self.by_V[i]);
                self.by_V[p.0] += by_V;
                turned = turned - self.V[p.0].cross_force(&by_V);
            }
            let turned = turned.scaled(weight);
            let by_q = X.force_inverse(&turned);
            body.add_projection(&by_q, out.q);
            if !out.parameters.is_empty() {
                let slots = &placed.slots;
                slots.add_placement(i, body, &turned, out.parameters);
                if self.with_mass {
                    self.add_inertia(i, slots, weight, out.parameters);
                }
                self.add_coupling(i, body, at, &by_q, slots, weight, out.parameters);
            }
        }
        if self.with_mass && !out.parameters.is_empty() {
            let armature = out.parameters[placed.slots.armature..].iter_mut();
            let half = weight * T::constant(0.5);
            armature
                .zip(at.v)
                .for_each(|(out, &v)| *out += half * v * v);
        }
    }

    /// ½ V · I V
    fn add_inertia(&self, i: usize, slots: &ParameterSlots, weight: T, out: &mut [T]) {
        let first = slots.inertia[i];
        let slopes = Inertia::power_slopes(&self.V[i], &self.V[i]);
        let half = weight * T::constant(0.5);
        let own = out[first..first + INERTIAL_PARAMETERS].iter_mut();
        own.zip(slopes)
            .for_each(|(out, slope)| *out += half * slope);
    }

    /// The position of a mimic joint is r q + o, and its rate r times that of its leader.
    fn add_coupling<P: Scalar>(
        &self,
        i: usize,
        body: &Body<P>,
        at: &Rates<'_, T>,
        by_q: &Force<T>,
        slots: &ParameterSlots,
        weight: T,
        out: &mut [T],
    ) where
        T: Over<P>,
    {
        let Some(ratio) = slots.coupling[i] else {
            return;
        };
        let by_q = along_joint(body, by_q);
        let by_v = along_joint(body, &self.by_V[i]) * weight;
        out[ratio] += by_q * at.q[body.q] + by_v * at.v[body.v];
        out[ratio + 1] += by_q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::{VectorFunction, gradient};
    use crate::dynamics::{Weighted, forward_kinematics, kinetic_energy};
    use crate::model::samples;
    use crate::spatial::linear::{lift_vector, rotate_back};
    use crate::tests::SAME_ALGEBRA;
    use nalgebra::{DVector, Vector3};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// T − F · V − c · p of the last body, over the tangent of q and all parameters.
    struct Energy<'a> {
        model: &'a Model,
        q: &'a DVector<f64>,
        v: &'a DVector<f64>,
        force: Force<f64>,
        pull: Vector3<f64>,
    }

    impl VectorFunction for Energy<'_> {
        fn n_outputs(&self) -> usize {
            1
        }

        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            let (dq, parameters) = x.split_at(self.model.nv());
            let model = self.model.with_parameters(parameters);
            let lift = |x: &DVector<f64>| x.iter().map(|&x| T::from(x)).collect::<Vec<_>>();
            let (q, v) = (self.model.integrate(&lift(self.q), dq), lift(self.v));
            let moved = forward_kinematics(&model, q.as_slice(), &v);
            let last = Some(BodyId(model.n_bodies() - 1));
            let power = moved.velocity(last).power(&self.force.lift());
            let pull = lift_vector::<f64, T>(&self.pull);
            let height = pull.dot(&moved.pose(last).translation);
            y[0] = kinetic_energy(&model, q.as_slice(), &v) - power - height;
        }
    }

    #[test]
    fn gradient_equals_that_by_dual_numbers() {
        for seed in 0..8 {
            let model = &samples::random_tree(9, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = &model.random_configuration(&mut rng);
            let v = &model.random_velocity(&mut rng, 1.0);
            let force = Force::from_array([0.3, -1.0, 0.4, 2.0, 0.1, -0.7]);
            let pull = Vector3::new(0.2, 0.5, -1.5);
            let energy = Energy {
                model,
                q,
                v,
                force,
                pull,
            };
            let parameters = model.parameters();
            let zeros = std::iter::repeat_n(0.0, model.nv());
            let x: Vec<f64> = zeros.chain(parameters.iter().copied()).collect();
            let expected = gradient(&energy, &x);

            let (mut placed, mut sweep) = (Sweep::new(model), EnergySweep::new(model));
            let rest = vec![0.0; model.nv()];
            let at = Weighted {
                q: q.as_slice(),
                v: &rest,
                a: &rest,
                mu: &rest,
                external: &[],
            };
            placed.start(model, &at);
            let body = BodyId(model.n_bodies() - 1);
            sweep.start(model, &placed, v.as_slice(), true);
            let linear = rotate_back(&placed.pose(model, body).rotation, &pull);
            let by_pose = Force::new(linear, Vector3::zeros());
            let pushed = Pushed {
                body,
                force,
                by_pose,
            };
            let mut found = DVector::zeros(x.len());
            let (of_q, of_parameters) = found.as_mut_slice().split_at_mut(model.nv());
            let mut out = EnergyGradientSum {
                q: of_q,
                parameters: of_parameters,
            };
            let rates = Rates {
                q: q.as_slice(),
                v: v.as_slice(),
            };
            sweep.finish(model, &placed, &rates, Some(&pushed), 1.0, &mut out);
            let error = (&found - &expected).amax();
            assert!(
                error < SAME_ALGEBRA * expected.amax(),
                "tree {seed}: {error:e}"
            );
        }
    }
}
