//! Composite-rigid-body algorithm: the joint-space mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::columns::{Columns, Payload};
use super::tree_matrix::{Block, TreeMatrix};
use crate::joint::{Axis, with_joint};
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar, pairs};
use crate::spatial::{Force, Inertia, Transform};

/// Working memory of [`mass_matrix_into`].
#[derive(Clone, Debug)]
pub struct CrbaScratch<T> {
    sin_cos: Vec<(T, T)>,
    X_PB: Vec<Transform<T>>,
    composite: Vec<Inertia<T>>,
    columns: Columns<T>,
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
        }
    }
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
    let size = model.nv();
    let all = |_| Block { size, offset: 0 };
    fill(model, q, scratch, (out.as_mut_slice(), all));
}

/// [`mass_matrix_into`] of the trees alone.
pub(super) fn mass_matrix_of_trees_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut CrbaScratch<T>,
    out: &mut TreeMatrix<T>,
) {
    fill(model, q, scratch, out.parts_mut());
}

/// [`mass_matrix_of_trees_into`] where the pose of each body in its parent is known.
pub(crate) fn mass_matrix_of_placed_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    scratch: &mut CrbaScratch<T>,
    out: &mut TreeMatrix<T>,
) {
    let CrbaScratch {
        composite, columns, ..
    } = scratch;
    T::vectorized(
        #[inline(always)]
        || inward(model, X_PB, composite, columns, out.parts_mut()),
    );
}

/// Places the bodies and writes the matrix.
fn fill<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut CrbaScratch<T>,
    out: (&mut [T], impl Fn(usize) -> Block),
) {
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
            for (X, body) in pairs(&mut *X_PB, model.bodies()) {
                *X = body.place_turned(q, sin_cos);
            }
            inward(model, X_PB, composite, columns, out);
        },
    );
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
    (out, block): (&mut [T], impl Fn(usize) -> Block),
) {
    out.fill(T::zero());
    for (I, body) in pairs(&mut *composite, model.bodies()) {
        *I = body.inertia.lift();
    }
    columns.number(model.bodies());
    for (j, body) in model.bodies().iter().enumerate().rev() {
        let (X, I) = (&X_PB[j], &composite[j]);
        let in_parent = body.parent.map(|_| X);
        // A joint without coordinates has no entries.
        let block = (body.joint.nv() > 0).then(|| block(body.v));
        let mut entries = Entries {
            body,
            I,
            out: &mut *out,
            block: block.unwrap_or(Block { size: 0, offset: 0 }),
        };
        with_joint!(body.joint, joint => columns.propagate::<P, T, _>(j, body, joint, in_parent, &mut entries),
            else pass_rare(j, in_parent, columns, &mut entries));
        if let Some(p) = body.parent {
            let I_P = X.inertia(I);
            composite[p.0] = composite[p.0] + I_P;
        }
    }
    // Rotors rotate with their own coordinate only.
    let (armature, mut first) = (model.armature(), 0);
    while first < armature.len() {
        let block = block(first);
        let diagonal = out[block.index(first, first)..].iter_mut();
        let own = &armature[first..first + block.size];
        for (entry, &armature) in pairs(diagonal.step_by(block.size + 1), own) {
            *entry = *entry + armature;
        }
        first += block.size;
    }
}

#[inline(never)]
fn pass_rare<P: Scalar, T: Over<P>>(
    j: usize,
    X_PB: Option<&Transform<T>>,
    columns: &mut Columns<T>,
    entries: &mut Entries<'_, P, T>,
) {
    let body = entries.body;
    T::vectorized(
        #[inline(always)]
        || with_joint!(rare body.joint, joint => columns.propagate::<P, T, _>(j, body, joint, X_PB, entries)),
    );
}

/// A column is the force that the unit acceleration of its degree of freedom asks of the body that the sweep has come to; its parts along
/// the axes are entries of M.
struct Entries<'a, P, T> {
    body: &'a Body<P>,
    I: &'a Inertia<T>,
    out: &'a mut [T],
    block: Block,
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
        self.out[self.block.index(row, column)] += self.body.scaled(entry);
    }

    #[inline(always)]
    fn carried(&mut self, _: usize, row: usize, column: usize, entry: T, _: &Force<T>) {
        let entry = self.body.scaled(entry);
        self.out[self.block.index(row, column)] += entry;
        self.out[self.block.index(column, row)] += entry;
    }

    #[inline(always)]
    fn leave(&self, _: usize, _: &mut Force<T>) {}
}
