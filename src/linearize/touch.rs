//! What a point of contact asks and bears, on dual numbers in the few directions that it has.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::autodiff::Dual;
use crate::contact::PointState;
use crate::sim::{Encounter, ROWS, Simulator};
use crate::spatial::linear::{cross, dot, rotate, scale};
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// Pose of the body (a motion of the body, in the body), its velocity (in the body), and mobility; filled up to whole vectors.
const DIRECTIONS: usize = 16;
const MOBILITY: usize = 2 * SPATIAL;

/// A number with its derivatives in these directions.
#[derive(Clone, Copy)]
pub(super) struct Local(Dual<DIRECTIONS>);

impl Local {
    /// Along a motion of the body.
    pub(super) fn by_pose(&self, V: &Motion<f64>) -> f64 {
        sum(&self.0.eps[..SPATIAL], V)
    }

    /// Along a change of its velocity.
    pub(super) fn by_velocity(&self, V: &Motion<f64>) -> f64 {
        sum(&self.0.eps[SPATIAL..MOBILITY], V)
    }

    pub(super) fn by_mobility(&self) -> f64 {
        self.0.eps[MOBILITY]
    }
}

fn sum(slopes: &[f64], V: &Motion<f64>) -> f64 {
    let V = V.to_array();
    slopes.iter().zip(V).map(|(slope, x)| slope * x).sum()
}

/// A point that touches, with its body.
pub(super) struct Touch {
    X_WB: Transform<Dual<DIRECTIONS>>,
    point: PointState<Dual<DIRECTIONS>>,
    axes: [Vector3<Dual<DIRECTIONS>>; ROWS],
}

impl Touch {
    /// A point of a simulator's contacts; its body has a pose in the world, and a velocity in itself.
    pub(super) fn new(
        simulator: &Simulator,
        point: usize,
        (X_WB, V_B): (&Transform<f64>, &Motion<f64>),
    ) -> Self {
        let contacts = simulator.contacts().expect("a point of contact");
        let mut V: Motion<Dual<DIRECTIONS>> = V_B.lift();
        for k in 0..SPATIAL {
            V.coordinate_mut(k).eps[SPATIAL + k] = 1.0;
        }
        let X_WB = moved(X_WB);
        let point = contacts.state(point, &X_WB, &V);
        let axes = point.axes();
        Self { X_WB, point, axes }
    }

    /// y = J ã − w + R f, where the body moves with Ã and forces along the axes are given.
    pub(super) fn rows(
        &self,
        simulator: &Simulator,
        point: usize,
        (seen, mobility): (&Motion<f64>, f64),
        forces: &[f64],
    ) -> [Local; ROWS] {
        let contacts = simulator.contacts().expect("a point of contact");
        let encounter = Encounter {
            point: &self.point,
            axes: &self.axes,
            deflection: None,
            mobility: Dual::variable(mobility, MOBILITY),
            dt: simulator.time_step(),
        };
        let (asked, _) = encounter.ask(contacts, point);
        std::array::from_fn(|row| {
            let give = asked.regularization[row] * forces[row];
            Local(self.along(row, seen).0 - asked.wanted[row] + give)
        })
    }

    /// The velocity of the body at the point along an axis, when it moves with `V_B`.
    pub(super) fn along(&self, row: usize, V_B: &Motion<f64>) -> Local {
        let velocity = self.point.velocity_of(&self.X_WB.rotation, &V_B.lift());
        Local(dot(&self.axes[row], &velocity))
    }

    /// What given forces along the axes are to the body, in the body, coordinate by coordinate.
    pub(super) fn force(&self, forces: &[f64]) -> [Local; SPATIAL] {
        let pushes = self.axes.iter().zip(forces);
        let force = pushes.fold(Vector3::zeros(), |sum, (axis, &f)| {
            sum + scale(axis, Dual::from(f))
        });
        let F = self.point.body_force(&self.X_WB.rotation, &force);
        F.to_array().map(Local)
    }

    /// A unit force along each axis, in the body.
    pub(super) fn unit_forces(&self) -> [Force<f64>; ROWS] {
        self.axes.map(|axis| {
            let F = self.point.body_force(&self.X_WB.rotation, &axis);
            Force::from_array(F.to_array().map(|x| x.re))
        })
    }
}

/// X exp(ξ) to first order in ξ, a motion of B in B: δp = R ξᵥ, δR = R [ξ_ω]×.
fn moved(X: &Transform<f64>) -> Transform<Dual<DIRECTIONS>> {
    let mut out: Transform<Dual<DIRECTIONS>> = X.lift();
    for k in 0..3 {
        let e = Vector3::ith(k, 1.0);
        let shift = rotate(&X.rotation, &e);
        for row in 0..3 {
            out.translation[row].eps[k] = shift[row];
        }
        let turn: Matrix3<f64> = Matrix3::from_columns(&std::array::from_fn::<_, 3, _>(|column| {
            rotate(&X.rotation, &cross(&e, &Vector3::ith(column, 1.0)))
        }));
        let entries = out.rotation.iter_mut().zip(turn.iter());
        entries.for_each(|(x, &dx)| x.eps[3 + k] = dx);
    }
    out
}
