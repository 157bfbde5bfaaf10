//! Forward dynamics over numbers with derivatives: on values first, then by the implicit function theorem.
//!
//! With the accelerations a₀ of the values, the equation  τ − ID(q, v, a) − R a = 0  is solved over the scalar by chord
//! steps
//!   a ← a + (M₀ + R₀)⁻¹ (τ − ID(q, v, a) − R a),
//! with mass matrix and resistance of the values. A step multiplies what is missing in a by  1 − (M₀ + R₀)⁻¹ (M + R),
//! which is infinitesimal: each makes one more order of derivatives exact. Inverse dynamics is the only algorithm that
//! runs over the scalar, and costs a fraction of forward dynamics there.

use std::any::Any;

use nalgebra::DMatrix;

use super::aba::Driven;
use super::calls::Calls;
use super::coupled::factorize;
use super::crba::CrbaScratch;
use super::direct::DirectScratch;
use super::mass_matrix_factor::MassMatrixFactor;
use super::rnea::{RneaScratch, inverse_dynamics_into};
use crate::model::Model;
use crate::scalar::{MapEach, Over, Scalar, is_differential, lift_into};
use crate::spatial::Force;

/// Working memory of [`accelerations`](Self::accelerations).
#[derive(Clone, Debug)]
pub(super) struct DifferentialScratch<T> {
    /// The robot in plain numbers, where its own are not.
    robot: Option<Box<Model>>,
    values: Values,
    rnea: RneaScratch<T>,
    /// τ − ID(q, v, a) − R a, then what a chord step adds.
    missing: Vec<T>,
}

/// Forward dynamics of the values.
#[derive(Clone, Debug)]
struct Values {
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    /// Empty if there is none.
    resistance: Vec<f64>,
    a: Vec<f64>,
    /// Empty if there are none.
    external: Vec<Force<f64>>,
    direct: DirectScratch<f64>,
    crba: CrbaScratch<f64>,
    factor: MassMatrixFactor<f64>,
}

impl<T: Scalar> DifferentialScratch<T> {
    /// Memory for a model over numbers that are a value and derivatives; nothing for others. Also none for derivatives of higher order with mimic
    /// joints: there, one solution over the scalar costs less than several steps.
    pub(super) fn new<P: Scalar>(model: &Model<P>, calls: Calls) -> Option<Box<Self>> {
        let pays = is_differential::<T>() && (T::ORDER == 1 || !model.has_coupling());
        pays.then(|| {
            Box::new(Self {
                robot: as_plain(model).is_none().then(|| Box::new(model.values(0))),
                values: Values::new(model, calls),
                rnea: RneaScratch::new(model),
                missing: vec![T::zero(); model.nv()],
            })
        })
    }

    /// v̇ = (M + R)⁻¹ (τ − h + Σᵢ Jᵢᵀ Fᵢ).
    pub(super) fn accelerations<P: Scalar>(
        &mut self,
        model: &Model<P>,
        driven: &Driven<'_, T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let robot = as_plain(model).unwrap_or_else(|| {
            let robot = self.robot.get_or_insert_with(|| Box::new(model.values(0)));
            model.values_into(robot);
            robot
        });
        self.values.solve(robot, driven);
        let Driven { q, v, external, .. } = *driven;
        lift_into(&self.values.a, a);
        for _ in 0..T::ORDER {
            inverse_dynamics_into(model, q, v, a, external, &mut self.rnea, &mut self.missing);
            for (k, &resistance) in driven.resistance.iter().enumerate() {
                self.missing[k] = resistance.mul_add(a[k], self.missing[k]);
            }
            for (missing, &tau) in self.missing.iter_mut().zip(driven.tau) {
                let balance = tau - *missing;
                // The values stay: what is missing there is rounding.
                *missing = balance - balance.value(0);
            }
            self.values.factor.solve(&mut self.missing);
            a.iter_mut().zip(&self.missing).for_each(|(a, &x)| *a += x);
        }
    }
}

impl Values {
    fn new<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        Self {
            q: vec![0.0; nq],
            v: vec![0.0; nv],
            tau: vec![0.0; nv],
            resistance: Vec::with_capacity(nv),
            a: vec![0.0; nv],
            external: Vec::with_capacity(model.n_bodies()),
            direct: DirectScratch::new(model, calls),
            crba: CrbaScratch::new(model),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
        }
    }

    /// The accelerations and the factors of the mass matrix.
    fn solve<T: Scalar>(&mut self, robot: &Model, driven: &Driven<'_, T>) {
        let own = [&mut self.q, &mut self.v, &mut self.tau];
        for (own, x) in own.into_iter().zip([driven.q, driven.v, driven.tau]) {
            let both = own.iter_mut().zip(x);
            both.for_each(|(own, x)| *own = x.value(0));
        }
        self.resistance.clear();
        let resistances = driven.resistance.iter().map(|x| x.value(0));
        self.resistance.extend(resistances);
        self.external.clear();
        let values =
            |force: &Force<T>| Force::from_array(force.to_array().map_each(|x| x.value(0)));
        self.external.extend(driven.external.iter().map(values));
        let values = Driven {
            q: &self.q,
            v: &self.v,
            tau: &self.tau,
            resistance: &self.resistance,
            external: &self.external,
        };
        self.direct.accelerations(robot, &values, &mut self.a);
        let (q, resistance) = (&self.q, &self.resistance);
        factorize(robot, q, resistance, &mut self.crba, &mut self.factor);
    }
}

/// The model itself, if its parameters are plain numbers.
fn as_plain<P: Scalar>(model: &Model<P>) -> Option<&Model> {
    (model as &dyn Any).downcast_ref()
}
