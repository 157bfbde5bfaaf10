//! What a degree of freedom and the joints between it and the world do to each other; see [`super::elimination`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::Dual;
use super::elimination::Local;
use super::local::{Direction, Tangent};
use crate::model::{BodyId, Model};
use crate::scalar::Lanes;
use crate::spatial::linear::dot_data;
use crate::spatial::{Force, Transform};

/// Where derivatives in q and v are gathered.
pub(crate) trait Entries {
    /// Adds to an entry of both matrices.
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64);
}

/// The four vectors that a degree of freedom sends to the world: its rows of I and B, its forces in the directions of q and v.
pub(super) type Carried = Force<Lanes<4>>;

#[inline(always)]
pub(super) fn pack(row_I: &Force<f64>, row_B: &Force<f64>, forces: &Force<Lanes<2>>) -> Carried {
    let lanes = |of_I: &Vector3<f64>, of_B: &Vector3<f64>, f: &Vector3<Lanes<2>>| {
        let lane = |k: usize| Lanes([of_I[k], of_B[k], f[k].0[0], f[k].0[1]]);
        Vector3::new(lane(0), lane(1), lane(2))
    };
    Force::new(
        lanes(&row_I.linear, &row_B.linear, &forces.linear),
        lanes(&row_I.angular, &row_B.angular, &forces.angular),
    )
}

/// Carries the vectors of a degree of freedom of body i to the world, past every joint on the way.
#[inline(always)]
pub(super) fn carry<E: Entries>(
    model: &Model,
    (bodies, tangents): (&[Local], &[Tangent]),
    i: usize,
    own: usize,
    mut carried: Carried,
    tangent: &Tangent,
    out: &mut Output<'_, E>,
) {
    let mut body = &model.bodies()[i];
    let mut local = &bodies[i];
    body.project(&carried, |k, x| out.add_column(k, own, x));
    let Some(BodyId(mut p)) = body.parent else {
        return;
    };
    carried = local.X_PB.force(&carried);
    // The parent also sees the subtree's force turn with the joint.
    add_to_lane_2(
        &mut carried,
        &turned_force(&local.X_PB, &tangent.X, &local.F),
    );
    loop {
        (body, local) = (&model.bodies()[p], &bodies[p]);
        body.project(
            &carried,
            #[inline(always)]
            |k, x| {
                let e = &tangents[local.first + k - body.v];
                out.add_column(k, own, x);
                out.add_row(own, k, x, act(&carried, &e.motion));
            },
        );
        match body.parent {
            Some(BodyId(next)) => p = next,
            None => return,
        }
        carried = local.X_PB.force(&carried);
    }
}

/// The derivative of X* F in the entries of X, by dual numbers.
#[inline(always)]
fn turned_force(X: &Transform<f64>, dX: &Transform<f64>, F: &Force<f64>) -> Force<f64> {
    let dual = |x: f64, dx: f64| Dual::new(x, [dx]);
    let X = Transform::new(
        X.rotation.zip_map(&dX.rotation, dual),
        X.translation.zip_map(&dX.translation, dual),
    );
    let F = X.force(&Force::new(
        F.linear.map(|x| Dual::new(x, [0.0])),
        F.angular.map(|x| Dual::new(x, [0.0])),
    ));
    Force::new(F.linear.map(|x| x.eps[0]), F.angular.map(|x| x.eps[0]))
}

#[inline(always)]
fn add_to_lane_2(carried: &mut Carried, F: &Force<f64>) {
    for k in 0..3 {
        carried.linear[k].0[2] += F.linear[k];
        carried.angular[k].0[2] += F.angular[k];
    }
}

/// What the directions in q and v of a joint on the way do to the degree of freedom whose vectors are carried: its row of I times
/// δÂ plus its row of B times δω.
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
pub(super) struct Columns<'a> {
    pub(super) nv: usize,
    pub(super) dq: &'a mut [f64],
    pub(super) dv: &'a mut [f64],
}

impl Entries for Columns<'_> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: f64, by_v: f64) {
        let at = row + self.nv * column;
        self.dq[at] += by_q;
        self.dv[at] += by_v;
    }
}

/// The derivatives, and the mass matrix column by column.
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
        self.mass[row + self.nv * column] += a;
        self.out.add(row, column, q, v);
    }
}
