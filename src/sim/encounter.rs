//! A point of contact as its law sees it.

use nalgebra::Vector3;

use super::horizon::Horizon;
use crate::contact::{ContactLaw, Contacts, PointRows, PointState, bounded};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::dot;

/// Rows of a point: along its normal, and two across.
pub(crate) const ROWS: usize = 3;

/// A point that touches, at the start of a step.
pub(crate) struct Encounter<'a, T> {
    pub(crate) point: &'a PointState<T>,
    /// Normal, tangent, tangent, in the world.
    pub(crate) axes: &'a [Vector3<T>; ROWS],
    /// Of the bristle, in the world, m; `None` for laws without.
    pub(crate) deflection: Option<Vector3<T>>,
    /// Acceleration along the normal by a unit force there, 1/kg.
    pub(crate) mobility: T,
    /// Δt, s.
    pub(crate) dt: f64,
}

impl<T: Scalar> Encounter<'_, T> {
    /// Reference acceleration and regularisation that the law of a point gives, along its axes, and μ.
    pub(crate) fn ask<P: Scalar>(&self, contacts: &Contacts<P>, point: usize) -> (PointRows<T>, T)
    where
        T: Over<P>,
    {
        let kappa = contacts.kappa_over_step(self.dt);
        let (asked, friction) = self.ask_law(&contacts.laws()[point], kappa);
        if kappa > 0.0 {
            let margin = Horizon::new(contacts, self.dt).margin(self.point);
            return (asked.within(margin), friction);
        }
        (asked, friction)
    }

    fn ask_law<P: Scalar>(&self, law: &ContactLaw<P>, kappa: f64) -> (PointRows<T>, T)
    where
        T: Over<P>,
    {
        let along = |x: &Vector3<T>| self.axes.map(|axis| dot(&axis, x));
        let (depth, v) = (self.point.depth, &along(&self.point.velocity));
        match law {
            ContactLaw::Rigid(law) => (law.ask(depth, v, self.dt), bounded(law.friction)),
            ContactLaw::RelaxedRigid(law) if kappa > 0.0 => {
                let asked = law.ask_smoothed(depth, v, self.mobility, kappa);
                (asked, bounded(law.friction))
            }
            ContactLaw::RelaxedRigid(law) => {
                (law.ask(depth, v, self.mobility), bounded(law.friction))
            }
            ContactLaw::Soft(law) => {
                let deflection = self.deflection.map(|m| along(&m));
                let [_, m_1, m_2] = deflection.unwrap_or([T::zero(); ROWS]);
                let asked = law.ask(depth, v, [m_1, m_2], self.dt);
                (asked, bounded(law.friction))
            }
        }
    }
}
