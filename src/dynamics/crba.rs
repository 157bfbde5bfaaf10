//! Composite-rigid-body algorithm: the joint-space mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use nalgebra::DMatrix;

use super::columns::{Columns, Payload};
use crate::joint::{Axis, Joint, with_joint};
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Inertia, Transform};

/// Working memory of [`mass_matrix_into`].
#[derive(Clone, Debug)]
pub struct CrbaScratch<T> {
    sin_cos: Vec<(T, T)>,
    X_PB: Vec<Transform<T>>,
    composite: Vec<Inertia<T>>,
    columns: Columns<T>,
    /// Coordinates of each tree of joints.
    trees: Vec<Range<usize>>,
}

impl<T: Scalar> CrbaScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            X_PB: vec![Transform::identity(); n],
            composite: vec![Inertia::zero(); n],
            columns: Columns::new(model),
            trees: trees(model),
        }
    }
}

/// Coordinates of each tree of joints on the world; with mimic joints all form one tree.
fn trees<P: Scalar>(model: &Model<P>) -> Vec<Range<usize>> {
    let roots = model.bodies().iter().filter(|body| body.parent.is_none());
    let mut starts: Vec<usize> = roots.map(|body| body.v).collect();
    if model.has_coupling() {
        starts.truncate(1);
    }
    let ends = starts.iter().copied().skip(1).chain([model.nv()]);
    starts
        .iter()
        .zip(ends)
        .map(|(&start, end)| start..end)
        .collect()
}

/// Computes the mass matrix M(q), `nv` × `nv`, symmetric:  T = ½ vᵀ M v.
///
/// Allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::mass_matrix, model::samples};
///
/// // A rod of 1 kg and 1 m about its end: J = 1/3 kg·m²
/// assert!((mass_matrix(&samples::pendulum(), &[0.4])[(0, 0)] - 1.0 / 3.0).abs() < 1e-15);
/// ```
///
/// # References
/// [Featherstone 2008, table 6.2].
pub fn mass_matrix<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DMatrix<T> {
    let mut out = DMatrix::zeros(model.nv(), model.nv());
    mass_matrix_into(model, q, &mut CrbaScratch::new(model), &mut out);
    out
}

/// [`mass_matrix`] without allocation.
///
/// * `out` – output, `nv` × `nv`
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn mass_matrix_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut CrbaScratch<T>,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    assert_eq!(
        out.shape(),
        (model.nv(), model.nv()),
        "the mass matrix of \"{}\" is nv × nv",
        model.name()
    );
    assert_eq!(
        scratch.X_PB.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    out.as_mut_slice().fill(T::zero());
    let CrbaScratch {
        sin_cos,
        X_PB,
        composite,
        columns,
        ..
    } = scratch;
    T::vectorized(
        #[inline(always)]
        || {
            T::sin_cos_each(q, sin_cos);
            for (X, body) in X_PB.iter_mut().zip(model.bodies()) {
                *X = body.place_turned(q, sin_cos);
            }
            inward(model, X_PB, composite, columns, out);
        },
    );
    add_armature(model, out);
}

/// [`mass_matrix_into`] where the pose of each body in its parent is known.
///
/// * `out` – output, zero where a row and a column belong to different trees
pub(crate) fn mass_matrix_of_placed_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    scratch: &mut CrbaScratch<T>,
    out: &mut DMatrix<T>,
) {
    let CrbaScratch {
        composite,
        columns,
        trees,
        ..
    } = scratch;
    let nv = model.nv();
    // Entries between trees stay zero.
    for tree in trees {
        for column in out.as_mut_slice()[nv * tree.start..nv * tree.end].chunks_exact_mut(nv) {
            column[tree.clone()].fill(T::zero());
        }
    }
    T::vectorized(
        #[inline(always)]
        || inward(model, X_PB, composite, columns, out),
    );
    add_armature(model, out);
}

/// Rotors rotate with their own coordinate only.
pub(crate) fn add_armature<P: Scalar, T: Over<P>>(model: &Model<P>, mass: &mut DMatrix<T>) {
    let diagonal = mass.as_mut_slice().iter_mut().step_by(model.nv() + 1);
    for (entry, &armature) in diagonal.zip(model.armature()) {
        *entry = *entry + armature;
    }
}

/// Each composite starts as its own body. From the tips: the columns of each joint, then the parent's composite inertia grows by X* Iⱼ X⁻¹.
#[inline(always)]
fn inward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    composite: &mut [Inertia<T>],
    columns: &mut Columns<T>,
    out: &mut DMatrix<T>,
) {
    for (I, body) in composite.iter_mut().zip(model.bodies()) {
        *I = body.inertia.lift();
    }
    columns.number(model.bodies());
    for (j, body) in model.bodies().iter().enumerate().rev() {
        let (X, I) = (&X_PB[j], &composite[j]);
        let at = At {
            i: j,
            body,
            X_PB: body.parent.map(|_| X),
        };
        with_joint!(body.joint, joint => pass(at, joint, I, columns, out),
            else pass_rare(at, I, columns, out));
        if let Some(p) = body.parent {
            let I_P = X.inertia(I);
            composite[p.0] = composite[p.0] + I_P;
        }
    }
}

/// The place of a joint.
#[derive(Clone, Copy)]
struct At<'a, P, T> {
    /// Index of its body.
    i: usize,
    body: &'a Body<P>,
    /// Pose of the body in its parent; `None` if that is the world.
    X_PB: Option<&'a Transform<T>>,
}

#[inline(always)]
fn pass<P: Scalar, T: Over<P>, J: Joint>(
    at: At<'_, P, T>,
    joint: J,
    I: &Inertia<T>,
    columns: &mut Columns<T>,
    out: &mut DMatrix<T>,
) {
    let (body, nv) = (at.body, out.nrows());
    let out = out.as_mut_slice();
    let mut entries = Entries { body, I, nv, out };
    columns.propagate::<P, T, J>(at.i, body, joint, at.X_PB, &mut entries);
}

#[inline(never)]
fn pass_rare<P: Scalar, T: Over<P>>(
    at: At<'_, P, T>,
    I: &Inertia<T>,
    columns: &mut Columns<T>,
    out: &mut DMatrix<T>,
) {
    T::vectorized(
        #[inline(always)]
        || with_joint!(rare at.body.joint, joint => pass(at, joint, I, columns, out)),
    );
}

/// A column is the force that the unit acceleration of its degree of freedom asks of the body that the sweep has come to; its parts along
/// the axes are entries of M.
struct Entries<'a, P, T> {
    body: &'a Body<P>,
    I: &'a Inertia<T>,
    nv: usize,
    out: &'a mut [T],
}

impl<P: Scalar, T: Over<P>> Payload<T> for Entries<'_, P, T> {
    #[inline(always)]
    fn start(&self, _: usize, axis: Axis) -> Force<T> {
        let F = axis.column(
            #[inline(always)]
            |k| self.I.column(k),
        );
        self.body.scaled_force(F)
    }

    #[inline(always)]
    fn own(&mut self, row: usize, column: usize, entry: T) {
        self.out[row + self.nv * column] += self.body.scaled(entry);
    }

    #[inline(always)]
    fn carried(&mut self, _: usize, row: usize, column: usize, entry: T, _: &Force<T>) {
        let entry = self.body.scaled(entry);
        self.out[row + self.nv * column] += entry;
        self.out[column + self.nv * row] += entry;
    }

    #[inline(always)]
    fn leave(&self, _: usize, _: &mut Force<T>) {}
}
