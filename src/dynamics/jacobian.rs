//! Frame Jacobians.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::passes::from_frame;
use crate::model::{FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Representation, SPATIAL, Transform};

/// Computes the Jacobian J of a frame, 6 × `nv`:  `V_WF = J v`, rows `[linear; angular]`.
///
/// The columns are tangent directions: those of a floating base are its velocity in the base frame. Allocates its
/// result.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::frame_jacobian, model::samples, spatial::Representation};
///
/// let cartpole = samples::cartpole();
/// let cart = cartpole.find_frame("cart")?;
/// let jacobian = frame_jacobian(&cartpole, &[0.3, 0.0], cart, Representation::Mixed);
/// assert_eq!((jacobian[(1, 0)], jacobian[(1, 1)]), (1.0, 0.0)); // the rail leads along y
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
///
/// # References
/// [Featherstone 2008, section 4.1].
pub fn frame_jacobian<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: FrameId,
    representation: Representation,
) -> DMatrix<T> {
    let mut out = DMatrix::zeros(SPATIAL, model.nv());
    frame_jacobian_into(model, q, frame, representation, &mut out);
    out
}

/// [`frame_jacobian`] without allocation.
///
/// * `out` – output, 6 × `nv`
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn frame_jacobian_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: FrameId,
    representation: Representation,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    assert_eq!(
        out.shape(),
        (SPATIAL, model.nv()),
        "a frame Jacobian of \"{}\" is 6 × nv",
        model.name()
    );
    out.fill(T::zero());
    let X_WF = fill_in_body_axes(model, q, frame, out);
    for column in spatial_columns(out) {
        let V_F = Motion::from_array(*column);
        *column = representation.velocity_from_body(&X_WF, &V_F).to_array();
    }
}

/// Walks from the frame to the world: a column is the joint's motion subspace, seen from the frame. Returns `X_WF`.
fn fill_in_body_axes<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: FrameId,
    out: &mut DMatrix<T>,
) -> Transform<T> {
    from_frame(model, q, frame, |body, X_BF| {
        for (k, S) in body.columns() {
            add_to_column(out, k, X_BF.motion_inverse(&S).to_array());
        }
    })
}

/// Adds to a column of a matrix of six rows: several joints may share a coordinate.
pub(super) fn add_to_column<T: Scalar>(out: &mut DMatrix<T>, k: usize, entries: [T; SPATIAL]) {
    let column = &mut spatial_columns(out)[k];
    for i in 0..SPATIAL {
        column[i] += entries[i];
    }
}

/// The columns of a matrix of six rows.
pub(super) fn spatial_columns<T: Scalar>(matrix: &mut DMatrix<T>) -> &mut [[T; SPATIAL]] {
    matrix.as_mut_slice().as_chunks_mut().0
}
