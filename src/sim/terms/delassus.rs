//! Derivatives of the Delassus diagonal d = n M⁻¹ nᵀ of a normal row n.
//!
//! M is without bounded forces. With the response s = M⁻¹ nᵀ,  δd = 2 δn s − sᵀ δM s: twice that of the power n · s less the kinetic energy at the rates s. In all coordinates for columns,
//! by a sweep for a weighted sum, which has parameters too.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::chain::{Chain, most_coordinates};
use super::local::{BodyDerivatives, FURTHER, OfCoordinate, RATE};
use super::sink::{BodyRow, Normal};
use crate::dynamics::{
    Blocks, EnergyGradientSum, EnergySweep, Pushed, Rates, Sweep, each_kinetic_derivative,
};
use crate::model::Model;
use crate::scalar::{MapEach, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::spatial::{Force, Motion};

/// Direction of the Delassus diagonal of a contact point.
pub(super) const DELASSUS: usize = FURTHER;

/// ∂d in all coordinates.
#[derive(Clone, Debug)]
pub(super) struct DelassusColumns<T> {
    /// s.
    response: Vec<T>,
    momenta: Vec<(Motion<T>, Force<T>)>,
    turns: Vec<Motion<T>>,
    /// ∂d/∂q, without the part of the implicit damping diagonal.
    by_q: Vec<T>,
}

impl<T: Scalar> DelassusColumns<T> {
    pub(super) fn new(model: &Model) -> Self {
        let nv = model.nv();
        Self {
            response: vec![T::zero(); nv],
            momenta: vec![(Motion::zero(), Force::zero()); model.n_bodies()],
            turns: Vec::with_capacity(most_coordinates(model)),
            by_q: vec![T::zero(); nv],
        }
    }

    /// Finds ∂d of a row.
    ///
    /// * `chains` – those of the bodies on which the normal acts
    pub(super) fn differentiate(
        &mut self,
        model: &Model,
        balance: &Balance<T>,
        chains: [Option<&Chain<T>>; 2],
        row: usize,
        normal: &Normal<'_, T>,
    ) {
        let (s, by_q) = (&mut self.response, &mut self.by_q);
        balance.bare_response_into(row, s);
        by_q.fill(T::zero());
        if normal.with_mass {
            let poses = balance.motions().0;
            each_kinetic_derivative(model, poses, s, &mut self.momenta, |k, _, slope| {
                by_q[k] += slope;
            });
            by_q.iter_mut().for_each(|x| *x = *x * -2.0);
        }
        let Some(chain) = chains[normal.side] else {
            return;
        };
        let along = (normal.along)(&chains.map_each(|chain| motion_along(chain, s)));
        chain.turns(s, &mut self.turns);
        for (&(k, S), turn) in chain.coordinates.iter().zip(&self.turns) {
            by_q[k] += (along.by_pose(&S) + turn.power(&normal.force)) * 2.0;
        }
    }

    /// Adds what rows change with d, in q.
    pub(super) fn add_to(&self, rows: &[BodyRow<T>], out: &mut Blocks<T>) {
        for BodyRow { row, y, .. } in rows {
            for (k, &x) in self.by_q.iter().enumerate() {
                *out.at(*row, k) += y.eps[DELASSUS] * x;
            }
        }
    }

    /// Adds the derivatives of rows with d through the implicit damping diagonal, in v.
    pub(super) fn add_dampers_to(
        &self,
        rows: &[BodyRow<T>],
        resistance: &[OfCoordinate<T>],
        out: &mut Blocks<T>,
    ) {
        let nv = self.response.len();
        for BodyRow { row, y, .. } in rows {
            for (k, (resistance, &s)) in resistance.iter().zip(&self.response).enumerate() {
                *out.at(*row, nv + k) -= y.eps[DELASSUS] * (s * s * resistance.eps[RATE]);
            }
        }
    }
}

/// The motion of a body at rates s; none of the world.
fn motion_along<T: Scalar>(chain: Option<&Chain<T>>, s: &[T]) -> Motion<T> {
    chain.map_or_else(Motion::zero, |chain| chain.motion(s))
}

/// d of a row, with a weight.
pub(super) struct WeightedDiagonal<'a, T: Scalar> {
    pub(super) balance: &'a Balance<T>,
    pub(super) row: usize,
    pub(super) weight: T,
}

/// Gradient of a weighted d.
#[derive(Clone, Debug)]
pub(super) struct DelassusAdjoint<T: Scalar> {
    energy: EnergySweep<T>,
    /// s.
    response: Vec<T>,
}

/// Slope of d in the kinetic energy under the normal force, and so of the velocity along the normal.
pub(super) const ALONG: f64 = -2.0;

impl<T: Scalar> DelassusAdjoint<T> {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            energy: EnergySweep::new(model),
            response: vec![T::zero(); model.nv()],
        }
    }

    /// Adds the gradient of d of a row, times a weight, in q and parameters; matrices that are added to M get separate weights. Returns the motions of the bodies
    /// at the rates s, times −weight.
    ///
    /// * `sweep` – after its pass outward
    pub(super) fn add(
        &mut self,
        point: &EvaluationPoint<'_, f64, T>,
        diagonal: &WeightedDiagonal<'_, T>,
        normal: &Normal<'_, T>,
        sweep: &Sweep<T>,
        out: &mut EnergyGradientSum<'_, T>,
        by_resistance: &mut [T],
    ) -> [Motion<T>; 2] {
        let (model, weight, s) = (point.model(), diagonal.weight, &mut self.response);
        (diagonal.balance).bare_response_into(diagonal.row, s);
        self.energy.start(model, sweep, s, normal.with_mass);
        let V = normal.on.map_each(|on| self.energy.motion(on));
        let pushed = normal.on[normal.side].map(|body| Pushed {
            body,
            force: normal.force,
            by_pose: (normal.along)(&V).in_pose(),
        });
        let rates = Rates { q: point.q(), v: s };
        let weight_of_energy = weight * T::constant(ALONG);
        (self.energy).finish(model, sweep, &rates, pushed.as_ref(), weight_of_energy, out);
        if normal.with_mass {
            let squares = by_resistance.iter_mut().zip(s);
            squares.for_each(|(sum, s)| *sum -= weight * *s * *s);
        }
        V.map_each(|V| V * -weight)
    }
}
