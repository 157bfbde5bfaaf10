//! Jacobians of a step with the base velocity in another representation.

use super::Linearization;
use crate::dynamics::{deviation_to_representation, gradient_to_representation};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::sim::State;
use crate::spatial::Representation;

impl<T: Scalar> Linearization<T> {
    /// Converts the Jacobians to states with the base in another representation: A' = S(x⁺) A S(x)⁻¹, B' = S(x⁺) B, with S as in
    /// [`BaseQuantity::Deviation`](crate::dynamics::BaseQuantity), which also defines the tangent of the configuration there. Inputs are unchanged.
    /// Allocates.
    ///
    /// * `state`, `next` – the states before and after the step, in the representation of this crate
    ///
    /// # Panics
    /// If a size differs from that of the model.
    pub fn to_representation<P: Scalar>(
        &self,
        model: &Model<P>,
        state: &State<T>,
        next: &State<T>,
        to: Representation,
    ) -> Self
    where
        T: Over<P>,
    {
        let mut out = self.clone();
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        for mut row in out.a.row_iter_mut() {
            let own: Vec<T> = row.iter().copied().collect();
            row.copy_from(&gradient_to_representation(model, q, v, &own, to).transpose());
        }
        let (q, v) = (next.q.as_slice(), next.v.as_slice());
        let columns = out.a.column_iter_mut().chain(out.b.column_iter_mut());
        for mut column in columns {
            let moved = deviation_to_representation(model, q, v, column.as_slice(), to);
            column.copy_from(&moved);
        }
        out
    }
}
