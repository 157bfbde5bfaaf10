//! Linearised contact kinematics: rows and forces of a point, on dual numbers in the few directions that it has.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::contact::{
    BodyMotion, BristleLoad, ContactRow, Contacts, PointKinematics, PointState, ROWS, body_force,
};
use crate::scalar::{Dual, vectorized};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::spatial::linear::{cross, dot, rotate, scale};
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// Directions: pose of the body (a motion of the body, in the body), its velocity (in the body), the Delassus diagonal of the point's normal,
/// and the bristle (in the world).
const DIRECTIONS: usize = 2 * SPATIAL + 1 + ROWS;
const DELASSUS: usize = 2 * SPATIAL;
const BRISTLE: usize = DELASSUS + 1;

/// A number with its derivatives in these directions.
type Number = Dual<f64, DIRECTIONS>;

/// A number of a point with its derivatives in pose and velocity of its body, its Delassus diagonal, and its bristle.
#[derive(Clone, Copy)]
pub(super) struct PointDual(Number);

/// Force that a law gives by itself, and what its bristle does over the step.
pub(super) struct LinearizedForce {
    /// Spatial force on the body, in the body, coordinate by coordinate.
    pub(super) force: [PointDual; SPATIAL],
    /// m⁺ − m, or ṁ at an instant, in the world.
    pub(super) bristle_step: [PointDual; ROWS],
}

/// A bristle's step at given forces of the solver.
pub(super) struct LinearizedBristle {
    /// m⁺ − m, in the world.
    pub(super) step: [PointDual; ROWS],
    /// Its derivative in the forces across.
    pub(super) by_friction: [Vector3<f64>; 2],
}

impl PointDual {
    /// Along a motion of the body.
    pub(super) fn by_pose(&self, V: &Motion<f64>) -> f64 {
        sum(&self.0.eps[..SPATIAL], V)
    }

    /// Along a change of its velocity.
    pub(super) fn by_velocity(&self, V: &Motion<f64>) -> f64 {
        sum(&self.0.eps[SPATIAL..DELASSUS], V)
    }

    pub(super) fn by_delassus(&self) -> f64 {
        self.0.eps[DELASSUS]
    }

    /// In the world, along each axis.
    pub(super) fn by_bristle(&self) -> [f64; ROWS] {
        std::array::from_fn(|k| self.0.eps[BRISTLE + k])
    }
}

fn sum(slopes: &[f64], V: &Motion<f64>) -> f64 {
    let V = V.to_array();
    slopes.iter().zip(V).map(|(slope, x)| slope * x).sum()
}

/// Contact kinematics of a point on dual numbers.
pub(super) struct LinearizedPoint<'a> {
    contacts: &'a Contacts,
    index: usize,
    dt: f64,
    X_WB: Transform<Number>,
    point: PointState<Number>,
    axes: [Vector3<Number>; ROWS],
    /// Of its bristle, in the world; zero where the law has none.
    deflection: Vector3<Number>,
}

impl<'a> LinearizedPoint<'a> {
    /// A point of a simulator's contacts at a state; its body has a pose in the world, and a velocity in itself.
    pub(super) fn new(
        simulator: &'a Simulator,
        state: &State,
        index: usize,
        X_WB: &Transform<f64>,
        V_B: &Motion<f64>,
    ) -> Self {
        let contacts = simulator.contacts().expect("a point of contact");
        let mut V: Motion<Number> = V_B.lift();
        for k in 0..SPATIAL {
            V.coordinate_mut(k).eps[SPATIAL + k] = 1.0;
        }
        let X_WB = moved(X_WB);
        let point = vectorized(
            #[inline(always)]
            || {
                let body = BodyMotion {
                    X_WB: &X_WB,
                    V_B: &V,
                    duration: simulator.contact_duration(),
                };
                contacts.state(index, &body)
            },
        );
        let bristles = state.contact.as_slice().as_chunks::<ROWS>().0;
        let deflection = bristles.get(index).copied().unwrap_or_default();
        let along = |k| Dual::variable(deflection[k], BRISTLE + k);
        Self {
            contacts,
            index,
            dt: simulator.time_step(),
            axes: point.axes(),
            deflection: Vector3::from_fn(|k, _| along(k)),
            X_WB,
            point,
        }
    }

    /// y = J ã − reference + R f, where the body moves with Ã and forces along the axes are given.
    ///
    /// * `delassus` – entry of J M⁻¹ Jᵀ on the diagonal of the normal, 1/kg
    pub(super) fn rows(
        &self,
        A_B: &Motion<f64>,
        delassus: f64,
        forces: &[f64],
    ) -> [PointDual; ROWS] {
        let kinematics = PointKinematics {
            state: &self.point,
            axes: &self.axes,
            deflection: Some(self.deflection),
            delassus: Dual::variable(delassus, DELASSUS),
            dt: self.dt,
            kappa: self.contacts.kappa_over_step(self.dt),
        };
        let own = self.contacts.rows(self.index, &kinematics).rows;
        let acceleration = self.velocity(A_B);
        std::array::from_fn(|row| {
            let ContactRow {
                reference,
                compliance,
            } = own[row];
            if compliance.re == f64::INFINITY {
                return PointDual(Dual::from(0.0)); // no force, whatever the reference is
            }
            let along = dot(&self.axes[row], &acceleration);
            PointDual(along - reference + compliance * forces[row])
        })
    }

    /// By how much the bristle moves over a step at whose end forces along the axes are given, and how forces across change that.
    pub(super) fn bristle_step(&self, forces: &[f64]) -> LinearizedBristle {
        let across = self.axes[1..].iter().zip(&forces[1..]);
        let friction = across.fold(Vector3::zeros(), |sum, (axis, &f)| {
            sum + scale(axis, Dual::from(f))
        });
        let law = &self.contacts.laws()[self.index];
        let separation = dot(&self.point.normal, &self.point.velocity);
        let step = law.bristle_step(&BristleLoad {
            depth: self.point.depth,
            separation,
            friction: &friction,
            deflection: &self.deflection,
            dt: self.dt,
        });
        // It is linear in the forces.
        let of_unit = |axis: &Vector3<Number>| {
            law.bristle_step(&BristleLoad {
                depth: self.point.depth.re,
                separation: separation.re,
                friction: &axis.map(|x| x.re),
                deflection: &Vector3::zeros(),
                dt: self.dt,
            })
        };
        LinearizedBristle {
            step: [step.x, step.y, step.z].map(PointDual),
            by_friction: [of_unit(&self.axes[1]), of_unit(&self.axes[2])],
        }
    }

    /// The force that the law gives by itself at the start of a step on the body, in the body, and by how much the bristle moves over the
    /// step, or its rate at an instant; `None` where only a solver finds it.
    pub(super) fn explicit_force(&self, is_instant: bool) -> Option<LinearizedForce> {
        let law = &self.contacts.laws()[self.index];
        let own = law.explicit_force(&self.point, &self.deflection)?;
        let step = if is_instant {
            own.bristle.deflection
        } else {
            own.bristle.step(self.dt)
        };
        Some(LinearizedForce {
            force: self.force_of(&own.force),
            bristle_step: [step.x, step.y, step.z].map(PointDual),
        })
    }

    /// The velocity of the body at the point along the normal, when it moves with `V_B`.
    pub(super) fn along_normal(&self, V_B: &Motion<f64>) -> PointDual {
        PointDual(dot(&self.axes[0], &self.velocity(V_B)))
    }

    fn velocity(&self, V_B: &Motion<f64>) -> Vector3<Number> {
        vectorized(
            #[inline(always)]
            || self.point.velocity_of(&self.X_WB.rotation, &V_B.lift()),
        )
    }

    /// Spatial force on the body of given forces along the axes, in the body, coordinate by coordinate.
    pub(super) fn force(&self, forces: &[f64]) -> [PointDual; SPATIAL] {
        let pushes = self.axes.iter().zip(forces);
        let force = pushes.fold(Vector3::zeros(), |sum, (axis, &f)| {
            sum + scale(axis, Dual::from(f))
        });
        self.force_of(&force)
    }

    fn force_of(&self, force: &Vector3<Number>) -> [PointDual; SPATIAL] {
        let F = vectorized(
            #[inline(always)]
            || body_force(&self.X_WB.rotation, &self.point.in_body, force),
        );
        F.to_array().map(PointDual)
    }

    /// A unit force along each axis, in the body.
    pub(super) fn unit_forces(&self) -> [Force<f64>; ROWS] {
        let rotation = self.X_WB.rotation.map(|x| x.re);
        let in_body = self.point.in_body.map(|x| x.re);
        self.axes
            .map(|axis| body_force(&rotation, &in_body, &axis.map(|x| x.re)))
    }
}

/// X exp(ξ) to first order in ξ, a motion of B in B, along the first six directions: δp = R ξᵥ, δR = R `[ξ_ω]×`.
pub(crate) fn moved<const N: usize>(X: &Transform<f64>) -> Transform<Dual<f64, N>> {
    let mut out: Transform<Dual<f64, N>> = X.lift();
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
