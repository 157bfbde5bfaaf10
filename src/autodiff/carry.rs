//! Coupling of each degree of freedom with its ancestors, by propagation to the root; see [`super::elimination`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::elimination::Local;
use super::local::{Direction, moved, turned_by_several, turned_force};
use crate::dynamics::Columns;
use crate::model::Body;
use crate::scalar::Lanes;
use crate::spatial::Force;
use crate::spatial::linear::dot_data;

/// Where derivatives in q and v are gathered.
pub(crate) trait Entries {
    /// Adds to an entry of both matrices.
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64);
}

/// The four vectors that a degree of freedom sends to the world: its rows of I and B, its forces in the directions of q and v.
type Carried = Force<Lanes<4>>;

#[inline(always)]
fn pack(row_I: &Force<f64>, row_B: &Force<f64>, forces: &Force<Lanes<2>>) -> Carried {
    let lanes = |of_I: &Vector3<f64>, of_B: &Vector3<f64>, f: &Vector3<Lanes<2>>| {
        let lane = |k: usize| Lanes([of_I[k], of_B[k], f[k].0[0], f[k].0[1]]);
        Vector3::new(lane(0), lane(1), lane(2))
    };
    Force::new(
        lanes(&row_I.linear, &row_B.linear, &forces.linear),
        lanes(&row_I.angular, &row_B.angular, &forces.angular),
    )
}

/// At a joint with one axis: what its degree of freedom and those that it carries do to each other; then all go on to the parent.
#[inline(always)]
pub(super) fn pass<E: Entries, const AXIS: usize>(
    (i, body): (usize, &Body<f64>),
    local: &Local,
    directions: &[Direction],
    columns: &mut Columns<Lanes<4>>,
    out: &mut Output<'_, E>,
) {
    let (own, end) = (columns.first[i], columns.first[body.subtree_end]);
    let (direction, X) = (&directions[own], body.parent.map(|_| local.X_PB));
    let mut F = own_column(body, local, direction, AXIS);
    out.add_column(body.v, body.v, body.scaled(F.coordinate(AXIS)));
    if let Some(X) = &X {
        let [turned] = turned_force(body.joint, &[moved(body)], &local.F);
        add_turned(&mut F, &turned);
        columns.F[own] = X.force(&F);
    }
    let carried = columns.F[own + 1..end].iter_mut();
    for (F, &k) in carried.zip(&columns.v[own + 1..end]) {
        let x = body.scaled(F.coordinate(AXIS));
        out.add_column(body.v, k, x);
        out.add_row(k, body.v, x, act(F, direction));
        if let Some(X) = &X {
            *F = X.force(F);
        }
    }
}

/// At a joint with none or several axes: couples its degrees of freedom with each other and with those of the subtree; then
/// propagates all columns to the parent.
#[inline(always)]
pub(super) fn pass_several<E: Entries>(
    (i, body): (usize, &Body<f64>),
    local: &Local,
    directions: &[Direction],
    columns: &mut Columns<Lanes<4>>,
    out: &mut Output<'_, E>,
) {
    let (first, end) = (columns.first[i], columns.first[body.subtree_end]);
    let carried = columns.first[i + 1];
    let own = &directions[first..carried];
    for (F, &k) in columns.F[carried..end]
        .iter_mut()
        .zip(&columns.v[carried..end])
    {
        let entries = F.to_array();
        for ((row, axis), direction) in body.axes().zip(own) {
            let x = entries[axis];
            out.add_column(row, k, x);
            out.add_row(k, row, x, act(F, direction));
        }
        if body.parent.is_some() {
            *F = local.X_PB.force(F);
        }
    }
    let turned = body.parent.map(|_| turned_by_several(body.joint, &local.F));
    for (n, ((k, axis), direction)) in body.axes().zip(own).enumerate() {
        let mut F = own_column(body, local, direction, axis);
        body.project(&F, |row, x| out.add_column(row, k, x));
        if let Some(turned) = &turned {
            add_turned(&mut F, &turned[n]);
            columns.F[first + n] = local.X_PB.force(&F);
        }
    }
}

/// The vectors that a degree of freedom of a body along an axis starts with.
#[inline(always)]
fn own_column(body: &Body<f64>, local: &Local, direction: &Direction, axis: usize) -> Carried {
    let (I, B) = (&local.I, &local.B);
    pack(
        &body.scaled_force(I.column(axis)),
        &body.scaled_force(Force::new(Vector3::zeros(), B.row(axis))),
        &(I.times(&direction.A) + B.times(&direction.omega)),
    )
}

/// The parent also sees the subtree's force turn with the joint.
#[inline(always)]
fn add_turned(carried: &mut Carried, F: &Force<f64>) {
    for k in 0..3 {
        carried.linear[k].0[2] += F.linear[k];
        carried.angular[k].0[2] += F.angular[k];
    }
}

/// Change of the force along a degree of freedom when an ancestor moves, in q and in v (the two lanes): the row of I of the former
/// times δÂ of the latter plus its row of B times δω.
#[inline(always)]
fn act(on: &Carried, direction: &Direction) -> Lanes<2> {
    let row_I = Force::new(on.linear.map(|x| x.0[0]), on.angular.map(|x| x.0[0]));
    let row_B = on.angular.map(|x| x.0[1]);
    let A = &direction.A;
    dot_data(&A.linear, &row_I.linear)
        + dot_data(&A.angular, &row_I.angular)
        + dot_data(&direction.omega, &row_B)
}

/// Two square matrices, column by column.
pub(super) struct Matrices<'a> {
    pub(super) nv: usize,
    pub(super) dq: &'a mut [f64],
    pub(super) dv: &'a mut [f64],
}

impl Entries for Matrices<'_> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64) {
        let at = row + self.nv * column;
        self.dq[at] += by_q;
        self.dv[at] += by_v;
    }
}

/// The derivatives, and the upper triangle of the mass matrix column by column; what is below the diagonal is of no use.
pub(super) struct Output<'a, E> {
    pub(super) nv: usize,
    pub(super) mass: &'a mut [f64],
    pub(super) out: &'a mut E,
}

impl<E: Entries> Output<'_, E> {
    #[inline(always)]
    fn add_column(&mut self, row: usize, column: usize, Lanes([a, _, q, v]): Lanes<4>) {
        self.mass[row + self.nv * column] += a;
        self.out.add(row, column, q, v);
    }

    #[inline(always)]
    fn add_row(
        &mut self,
        row: usize,
        column: usize,
        Lanes([a, ..]): Lanes<4>,
        Lanes([q, v]): Lanes<2>,
    ) {
        // Of the mass matrix the upper triangle is enough, where followers may put both.
        if row <= column {
            self.mass[row + self.nv * column] += a;
        }
        self.out.add(row, column, q, v);
    }
}
