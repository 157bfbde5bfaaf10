//! The inverse of the mass matrix by direct recursion, without forming or factorising the matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::aba::{ALL, Working, accelerations, inward, outward};
use super::coupled::CoupledScratch;
use super::passes::to_world;
use super::tree::Bodies;
use crate::model::manifold::v_range;
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

/// Working memory of [`mass_matrix_inverse_into`].
#[derive(Clone, Debug)]
pub struct MassMatrixInverseScratch<T> {
    working: Working<T>,
    /// Memory for robots whose joints follow one another.
    coupled: Option<Box<CoupledScratch<T>>>,
    /// Zeros in place of velocities and joint forces.
    rest: Vec<T>,
}

impl<T: Scalar> MassMatrixInverseScratch<T> {
    /// Makes memory for a model.
    ///
    /// # Panics
    /// If its mass matrix is singular, with the message of [`Model::check_mass_matrix`].
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        model.assert_mass_matrix();
        Self {
            working: Working::new(model.n_bodies(), model.nq(), model.nv()),
            coupled: CoupledScratch::new(model),
            rest: vec![T::zero(); model.nv()],
        }
    }
}

/// Computes M(q)⁻¹, `nv` × `nv`, symmetric: column k is the acceleration due to a unit force on coordinate k.
///
/// O(n²); allocates its result and working memory. To solve with M for a few right-hand sides,
/// [`MassMatrixFactor`](super::MassMatrixFactor) is cheaper.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length, or the mass matrix is singular: [`Model::check_mass_matrix`] checks this beforehand.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::mass_matrix_inverse, model::samples};
///
/// let inverse = mass_matrix_inverse(&samples::pendulum(), &[0.4]);
/// assert!((inverse[(0, 0)] - 3.0).abs() < 1e-14); // 1 / (m l² / 3)
/// ```
///
/// # References
/// [Carpentier 2018], on the articulated inertias of [Featherstone 2008, section 7.3].
pub fn mass_matrix_inverse<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DMatrix<T> {
    let mut scratch = MassMatrixInverseScratch::new(model);
    let mut out = DMatrix::zeros(model.nv(), model.nv());
    mass_matrix_inverse_into(model, q, &mut scratch, &mut out);
    out
}

/// [`mass_matrix_inverse`] without allocation.
///
/// * `out` – output, `nv` × `nv`
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn mass_matrix_inverse_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut MassMatrixInverseScratch<T>,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    assert_eq!(
        out.shape(),
        (model.nv(), model.nv()),
        "the inverse mass matrix of \"{}\" is nv × nv",
        model.name()
    );
    assert_eq!(
        scratch.working.A.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    if let Some(coupled) = &mut scratch.coupled {
        return coupled.inverse(model, q, out);
    }
    // The factors, from a robot at rest.
    let tree = Bodies::all(model);
    outward(&tree, q, &scratch.rest, &[], &mut scratch.working);
    scratch.working.resist(model.armature(), &[]);
    let rest = Motion::zero();
    inward(&tree, &scratch.rest, &rest, ALL, &mut scratch.working);
    for (i, body) in model.bodies().iter().enumerate() {
        for k in v_range(body) {
            push(model, BodyId(i), k, &mut scratch.working);
            let mut a = out.column_mut(k);
            accelerations(&tree, &rest, &mut scratch.working, a.as_mut_slice());
        }
    }
}

/// Passes inward, from the body that is pushed to the world:  u = −Sᵀ F,  `F_P = X* F + W u`.
fn push<P: Scalar, T: Over<P>>(model: &Model<P>, pushed: BodyId, k: usize, s: &mut Working<T>) {
    s.pushed.fill(T::zero());
    s.pushed[k] = T::one();
    let mut F = Force::zero();
    for (id, body) in to_world(model, Some(pushed)) {
        body.project(&F, |k, x| s.pushed[k] -= x);
        F = s
            .factor
            .handed_on(id.0, body, &mut s.pushed[v_range(body)], &F);
    }
}
