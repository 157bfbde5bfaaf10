//! The row of a force along an axis of one attachment frame: its length, rate and Jacobian.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Matrix3;

use super::anchor::{Anchor, AnchorMotion};
use super::carried::{CarriedRow, CarrierMotion};
use super::hold::Hold;
use super::rows::{ConstraintRow, ConstraintRows, turn};
use crate::model::Model;
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::linear::{cross, dot, rotate};
use crate::spatial::{Force, Motion, Representation, Transform, rotation_vector};

/// A wrench per unit of force, in a representation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameAxis<T> {
    pub(crate) wrench: Force<T>,
    pub(crate) representation: Representation,
    /// Pose in the world of the frame from which the length counts; `None` for the world.
    pub(crate) origin: Option<Transform<f64>>,
}

impl<T: Scalar> FrameAxis<T> {
    /// Whether there is a position along it.
    pub(crate) fn has_length(&self) -> bool {
        self.representation == Representation::Mixed
    }

    /// w · (position; rotation vector) in the world. `None` where the axis moves with the frame, which then has no length along it.
    pub(crate) fn length(&self, X: &Transform<T>) -> Option<T> {
        self.has_length()
            .then(|| self.displacement(X).power(&self.wrench))
    }

    /// Displacement and rotation vector from the origin, in the axes of the world.
    fn displacement(&self, X: &Transform<T>) -> Motion<T> {
        let Some(origin) = &self.origin else {
            let turn = rotation_vector(&Matrix3::identity(), &X.rotation);
            return Motion::new(X.translation, turn);
        };
        let rotation = origin.rotation.map(T::constant);
        let turn = rotation_vector(&rotation, &X.rotation);
        let from = origin.translation.map(T::constant);
        Motion::new(X.translation - from, rotate(&rotation, &turn))
    }

    /// The wrench in mixed representation, n.
    fn in_mixed(&self, X: &Transform<T>) -> Force<T> {
        let Force { linear, angular } = &self.wrench;
        match self.representation {
            Representation::Mixed => self.wrench,
            Representation::Body => {
                let [linear, angular] = [linear, angular].map_each(|own| rotate(&X.rotation, own));
                Force::new(linear, angular)
            }
            Representation::Inertial => {
                Force::new(*linear, angular - cross(&X.translation, linear))
            }
        }
    }

    /// The row, with the error as the length, and n:  φ̇ = n · V,  b = n · A + ṅ · V.
    fn row(&self, at: &AnchorMotion<T>) -> (ConstraintRow<T>, Force<T>) {
        let (n, V) = (self.in_mixed(&at.X), &at.V);
        let turning = match self.representation {
            Representation::Mixed => T::zero(),
            // A moment that turns with the frame has no power of its own: (ω × m) · ω = 0.
            Representation::Body => dot(&cross(&V.angular, &n.linear), &V.linear),
            Representation::Inertial => -dot(&cross(&V.linear, &n.linear), &V.angular),
        };
        let row = ConstraintRow {
            error: self.length(&at.X).unwrap_or_else(T::zero),
            rate: V.power(&n),
            bias: at.A.power(&n) + turning,
            turning: T::zero(),
            hold: Hold::Spring {
                stiffness: T::zero(),
                damping: T::zero(),
            },
            largest_force: None,
        };
        (row, n)
    }

    /// The row between the world and a body that carries the frame, with the unit forces on both.
    ///
    /// * `X_BA` – pose of the frame on the body
    /// * `world` – acceleration that is added to all bodies
    pub(crate) fn carried<P: Scalar>(
        &self,
        X_BA: &Transform<P>,
        body: &CarrierMotion<T>,
        world: &Motion<T>,
    ) -> CarriedRow<T>
    where
        T: Over<P>,
    {
        let mut at = AnchorMotion::on(X_BA, &body.biased());
        at.A = at.A - *world;
        let (row, n) = self.row(&at);
        CarriedRow {
            row,
            along_seen: at.velocity_under(&body.X_WB, &body.U).power(&n),
            unit_forces: [
                -Force::new(n.linear, n.angular + cross(&at.X.translation, &n.linear)),
                at.force_on(&body.X_WB, &n),
            ],
        }
    }
}

impl<T: Scalar> ConstraintRows<T> {
    /// Computes the rows of axes of frames at a state; does not allocate.
    pub(crate) fn evaluate_axes<'a, P: Scalar>(
        &mut self,
        model: &Model<P>,
        axes: impl Iterator<Item = (&'a Anchor<P>, FrameAxis<T>)>,
        q: &[T],
        v: &[T],
    ) where
        T: Over<P>,
    {
        self.rows.clear();
        self.jacobian.clear();
        for (place, axis) in axes {
            let at = place.motion(model, q, v);
            let (row, n) = axis.row(&at);
            self.rows.push(row);
            self.relative.fill(T::zero());
            place.add_jacobian(model, q, &at, 1.0, &mut self.own, &mut self.relative);
            let n = n.to_array();
            let along = |column: &[T]| {
                let products = column.iter().zip(n);
                products.fold(T::zero(), |sum, (&x, n)| sum + x * n)
            };
            let columns = self.relative.as_slice().chunks_exact(n.len());
            self.jacobian.extend(columns.map(along));
        }
        turn(&mut self.rows, model, &self.jacobian, v);
    }
}
