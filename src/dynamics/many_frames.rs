//! Jacobians of many frames, for example of all links, and their rates.

use nalgebra::DMatrix;

use super::acceleration::frame_jacobian_derivative_into;
use super::jacobian::frame_jacobian_into;
use crate::model::{FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Representation, SPATIAL};

/// Computes the Jacobians of several frames, 6 × `nv` each, as [`frame_jacobian`](super::frame_jacobian) computes one.
///
/// O(sum of the depths of the frames). Allocates its result.
///
/// * `q` – configuration, length `nq`
/// * `frames` – the frames; [`Model::link_frames`] for all links
///
/// # Panics
/// If a slice has the wrong length, or an id is not one of the model.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::frame_jacobians, model::samples, spatial::Representation};
///
/// let cartpole = samples::cartpole();
/// let all = frame_jacobians(&cartpole, &[0.3, 0.0], &cartpole.link_frames(), Representation::Mixed);
/// let cart = cartpole.link_names().iter().position(|name| *name == "cart").unwrap();
/// assert_eq!(all[cart][(1, 0)], 1.0); // the rail leads along y
/// ```
pub fn frame_jacobians<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frames: &[FrameId],
    representation: Representation,
) -> Vec<DMatrix<T>> {
    let mut out = vec![DMatrix::zeros(SPATIAL, model.nv()); frames.len()];
    for (&frame, out) in frames.iter().zip(&mut out) {
        frame_jacobian_into(model, q, frame, representation, out);
    }
    out
}

/// Computes the rates J̇ of the Jacobians of several frames, 6 × `nv` each, as
/// [`frame_jacobian_derivative`](super::frame_jacobian_derivative) computes one. Allocates its result.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length, or an id is not one of the model.
pub fn frame_jacobian_derivatives<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frames: &[FrameId],
    representation: Representation,
) -> Vec<DMatrix<T>> {
    let mut out = vec![DMatrix::zeros(SPATIAL, model.nv()); frames.len()];
    for (&frame, out) in frames.iter().zip(&mut out) {
        frame_jacobian_derivative_into(model, q, v, frame, representation, out);
    }
    out
}
