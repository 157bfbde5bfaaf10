//! Coupling of each degree of freedom with its ancestors, by propagation to the root; see [`super::inverse_dynamics`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::composite::Composite;
use super::joint::Direction;
use crate::dynamics::columns::{Columns, Payload};
use crate::joint::{Axis, Joint};
use crate::model::Body;
use crate::scalar::{Differentiable, Over, Pack, Scalar};
use crate::spatial::Force;
use crate::spatial::linear::{dot_data, zero};

/// Sink of derivatives in q and v.
pub(crate) trait Entries<T> {
    /// Adds to an entry of both matrices.
    fn add(&mut self, row: usize, column: usize, by_q: T, by_v: T);
}

/// The four vectors that a degree of freedom sends to the world: its rows of I and B, its forces in the directions of q and v.
type Carried<T> = Force<Pack<T, 4>>;

#[inline(always)]
fn pack<T: Scalar>(row_I: &Force<T>, row_B: &Force<T>, forces: &Force<Pack<T, 2>>) -> Carried<T> {
    let packs = |of_I: &Vector3<T>, of_B: &Vector3<T>, f: &Vector3<Pack<T, 2>>| {
        let pack = |k: usize| Pack([of_I[k], of_B[k], f[k].0[0], f[k].0[1]]);
        Vector3::new(pack(0), pack(1), pack(2))
    };
    Force::new(
        packs(&row_I.linear, &row_B.linear, &forces.linear),
        packs(&row_I.angular, &row_B.angular, &forces.angular),
    )
}

/// At a joint: what its degrees of freedom and those that they carry do to each other; then all go on to the parent.
#[inline(always)]
pub(super) fn pass<P: Scalar, T: Differentiable + Over<P>, E: Entries<T>, J: Joint>(
    i: usize,
    body: &Body<P>,
    joint: J,
    local: &Composite<T>,
    turned: impl FnOnce() -> J::PerDof<Force<T>>,
    directions: &[Direction<T>],
    columns: &mut Columns<Pack<T, 4>>,
    out: &mut Output<'_, T, E>,
) {
    let X_PB = body.parent.map(|_| local.X_PB);
    let turned = X_PB.map(|_| turned());
    let mut coupling = Coupled {
        body,
        local,
        directions: &directions[columns.first[i]..columns.first[i + 1]],
        turned: turned.as_ref().map(AsRef::as_ref),
        out,
    };
    columns.propagate::<P, T, J>(i, body, joint, X_PB.as_ref(), &mut coupling);
}

/// The columns of derivatives at a joint.
struct Coupled<'a, 'o, P, T, E> {
    body: &'a Body<P>,
    local: &'a Composite<T>,
    /// Of the joint's degrees of freedom.
    directions: &'a [Direction<T>],
    /// Derivative of the subtree's force in each of them, where a parent sees it turn with the joint.
    turned: Option<&'a [Force<T>]>,
    out: &'a mut Output<'o, T, E>,
}

impl<P: Scalar, T: Over<P>, E: Entries<T>> Payload<Pack<T, 4>> for Coupled<'_, '_, P, T, E> {
    #[inline(always)]
    fn start(&self, k: usize, axis: Axis) -> Carried<T> {
        own_column(self.body, self.local, &self.directions[k], axis)
    }

    #[inline(always)]
    fn own(&mut self, row: usize, column: usize, entry: Pack<T, 4>) {
        let entry = scaled(self.body, entry);
        self.out.add_column(row, column, entry);
    }

    #[inline(always)]
    fn carried(&mut self, k: usize, row: usize, column: usize, entry: Pack<T, 4>, F: &Carried<T>) {
        let entry = scaled(self.body, entry);
        self.out.add_column(row, column, entry);
        self.out
            .add_row(column, row, entry, act(F, &self.directions[k]));
    }

    #[inline(always)]
    fn leave(&self, k: usize, F: &mut Carried<T>) {
        if let Some(turned) = self.turned {
            add_turned(F, &turned[k]);
        }
    }
}

/// The vectors that a degree of freedom of a body along an axis starts with.
#[inline(always)]
fn own_column<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    local: &Composite<T>,
    direction: &Direction<T>,
    axis: Axis,
) -> Carried<T> {
    let (I, B) = (&local.I, &local.B);
    let row_I = axis.column(
        #[inline(always)]
        |k| I.column(k),
    );
    let row_B = axis.column(
        #[inline(always)]
        |k| Force::new(zero(), B.row(k)),
    );
    pack(
        &body.scaled_force(row_I),
        &body.scaled_force(row_B),
        &(I.times(&direction.A) + B.times(&direction.omega)),
    )
}

/// [`Body::scaled`] for what is carried.
#[inline(always)]
fn scaled<P: Scalar, T: Over<P>>(body: &Body<P>, x: Pack<T, 4>) -> Pack<T, 4> {
    match body.coupling {
        None => x,
        Some(coupling) => x * T::from(coupling.ratio),
    }
}

/// The parent also sees the subtree's force turn with the joint.
#[inline(always)]
fn add_turned<T: Scalar>(carried: &mut Carried<T>, F: &Force<T>) {
    for k in 0..3 {
        carried.linear[k].0[2] += F.linear[k];
        carried.angular[k].0[2] += F.angular[k];
    }
}

/// Change of the force along a degree of freedom when an ancestor moves, in q and in v (the two of a pack): the row of I of the former
/// times δÂ of the latter plus its row of B times δω.
#[inline(always)]
fn act<T: Scalar>(on: &Carried<T>, direction: &Direction<T>) -> Pack<T, 2> {
    let row_I = Force::new(on.linear.map(|x| x.0[0]), on.angular.map(|x| x.0[0]));
    let row_B = on.angular.map(|x| x.0[1]);
    let A = &direction.A;
    dot_data(&A.linear, &row_I.linear)
        + dot_data(&A.angular, &row_I.angular)
        + dot_data(&direction.omega, &row_B)
}

/// Two square matrices, column by column.
pub(super) struct Matrices<'a, T> {
    pub(super) nv: usize,
    pub(super) dq: &'a mut [T],
    pub(super) dv: &'a mut [T],
}

impl<T: Scalar> Entries<T> for Matrices<'_, T> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: T, by_v: T) {
        let at = row + self.nv * column;
        self.dq[at] += by_q;
        self.dv[at] += by_v;
    }
}

/// The derivatives, and the upper triangle of the mass matrix column by column; entries below the diagonal are undefined.
pub(super) struct Output<'a, T, E> {
    pub(super) nv: usize,
    pub(super) mass: &'a mut [T],
    pub(super) out: &'a mut E,
}

impl<T: Scalar, E: Entries<T>> Output<'_, T, E> {
    #[inline(always)]
    fn add_column(&mut self, row: usize, column: usize, Pack([a, _, q, v]): Pack<T, 4>) {
        self.mass[row + self.nv * column] += a;
        self.out.add(row, column, q, v);
    }

    #[inline(always)]
    fn add_row(
        &mut self,
        row: usize,
        column: usize,
        Pack([a, ..]): Pack<T, 4>,
        Pack([q, v]): Pack<T, 2>,
    ) {
        // Of the mass matrix the upper triangle is enough, where mimic joints may put both.
        if row <= column {
            self.mass[row + self.nv * column] += a;
        }
        self.out.add(row, column, q, v);
    }
}
