//! Report on contact and constraints at an instant, for display and analysis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::evaluation_point::EvaluationPoint;
use super::integrators::AccelerationScratch;
use super::signals::Signals;
use super::simulator::Simulator;
use super::state::State;
use super::terms::Contact;
use crate::cone::{Certificate, Mode};
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::{AttachedFrame, Contacts, PointState};
use crate::dynamics::{Calls, Kinematics, forward_kinematics};
use crate::model::{FrameId, Model};
use crate::scalar::{Over, Scalar, compiled_over_f64};
use crate::spatial::linear::dot;
use crate::spatial::{Force, Representation, SPATIAL, Transform};

/// Report on the contact points, and on constraints, at an instant.
#[derive(Clone, Debug, Default)]
pub struct ContactReport<T: Scalar = f64> {
    /// Positions, depths and velocities of the contact points with the ground.
    pub points: Vec<PointState<T>>,
    /// The force of the ground on each, in the world, N.
    pub forces: Vec<Vector3<T>>,
    /// The force of the ground and of other bodies on each link, in the frame of the link (N, N·m about its origin), in the order of
    /// [`Model::links`](crate::Model::links).
    pub links: Vec<Force<T>>,
    /// Whether each link is in contact with the ground or with another link, in the order of [`Model::links`](crate::Model::links); in the first lane.
    pub touching: Vec<bool>,
    /// Mode of each point in rigid contact (stick, slip, separated), in the first lane. Points that took no part are separated.
    pub modes: Vec<Mode>,
    /// Behaviour of each point, which explains why a derivative is zero or not.
    pub reasons: Vec<ContactReason>,
    /// Points at which bodies are near each other.
    pub pairs: Vec<PairReport<T>>,
    /// The forces of kinematic constraints, row by row as in [`Simulator::constraint_errors`]: N, N·m, on the second attachment frame (and the
    /// opposite on the first), in the direction in which the error grows.
    pub constraints: Vec<T>,
    /// Residuals of the laws of rigid contact and constraints for the computed forces.
    pub certificate: Certificate,
}

/// A point at which two links are near each other.
#[derive(Clone, Debug)]
pub struct PairReport<T: Scalar = f64> {
    /// The links.
    pub links: [FrameId; 2],
    /// The midpoint between both links. The normal points out of the second link; the velocity is that of the first link minus that of the second.
    pub point: PointState<T>,
    /// The force on the first link, in the world, N; the force on the second link is opposite.
    pub force: Vector3<T>,
    /// Mode of the point (stick, slip, separated), in the first lane.
    pub mode: Mode,
    /// Its behaviour, which explains why a derivative is zero or not.
    pub reason: ContactReason,
}

impl<T: Scalar> ContactReport<T> {
    /// Whether two links touch, in either order: whether a point between them is in contact, in the first lane.
    pub fn are_touching(&self, links: [FrameId; 2]) -> bool {
        let mut between = self.between(links);
        between.any(|(pair, _)| pair.is_touching())
    }

    /// Computes the force of the second link on the first, summed over their points, in the world, N.
    pub fn force_between(&self, links: [FrameId; 2]) -> Vector3<T> {
        let zero = Vector3::from_element(T::zero());
        let between = self.between(links);
        between.fold(zero, |sum, (pair, is_turned)| match is_turned {
            false => sum + pair.force,
            true => sum - pair.force,
        })
    }

    /// Computes the Jacobian of each point between bodies, 6 × `nv`, rows `[linear; angular]` in the world's axes, in the order of
    /// [`pairs`](Self::pairs). Allocates.
    ///
    /// It is that of the velocity of the first link relative to the second at the point: J q̇ is the velocity of the [`point`](PairReport::point) and the
    /// difference of the angular velocities. A force there acts on the joints by the transpose of the first three rows.
    ///
    /// * `q` – configuration of the report, length `nq`
    ///
    /// # Panics
    /// If `q` has the wrong length, or the report is one of another robot.
    pub fn pair_jacobians<P: Scalar>(&self, model: &Model<P>, q: &[T]) -> Vec<DMatrix<T>>
    where
        T: Over<P>,
    {
        let kinematics = forward_kinematics(model, q, &vec![T::zero(); model.nv()]);
        let pairs = self.pairs.iter();
        pairs.map(|p| p.jacobian_at(model, &kinematics)).collect()
    }

    /// Computes the rates of the [Jacobians](Self::pair_jacobians) of points that are fixed to their links:  J v̇ + J̇ v is the acceleration of the first
    /// point minus that of the second. Allocates.
    ///
    /// * `q`, `v` – configuration and velocity of the report, lengths `nq` and `nv`
    ///
    /// # Panics
    /// If a slice has the wrong length, or the report is one of another robot.
    pub fn pair_jacobian_derivatives<P: Scalar>(
        &self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
    ) -> Vec<DMatrix<T>>
    where
        T: Over<P>,
    {
        let kinematics = forward_kinematics(model, q, v);
        let pairs = self.pairs.iter();
        pairs.map(|p| p.rate_at(model, &kinematics)).collect()
    }

    /// The points between two links, and whether the links are in the opposite order there.
    fn between(&self, links: [FrameId; 2]) -> impl Iterator<Item = (&PairReport<T>, bool)> {
        let turned = [links[1], links[0]];
        let pairs = self.pairs.iter();
        pairs.filter_map(move |pair| match pair.links {
            own if own == links => Some((pair, false)),
            own if own == turned => Some((pair, true)),
            _ => None,
        })
    }
}

impl<T: Scalar> PairReport<T> {
    /// Returns the frame C of the contact, `X_WC`: its origin at the point, z along the normal, x and y across it.
    pub fn frame(&self) -> Transform<T> {
        let [z, x, y] = self.point.axes_of_any_normal();
        Transform::new(Matrix3::from_columns(&[x, y, z]), self.point.position)
    }

    fn jacobian_at<P: Scalar>(&self, model: &Model<P>, at: &Kinematics<T>) -> DMatrix<T>
    where
        T: Over<P>,
    {
        self.relative(model, |frame, out| {
            frame.jacobian_into(model, at, Representation::Mixed, out);
        })
    }

    fn rate_at<P: Scalar>(&self, model: &Model<P>, at: &Kinematics<T>) -> DMatrix<T>
    where
        T: Over<P>,
    {
        self.relative(model, |frame, out| {
            frame.jacobian_derivative_into(model, at, Representation::Mixed, out);
        })
    }

    /// A matrix of the point on the first link less that of the point on the second one.
    fn relative<P: Scalar>(
        &self,
        model: &Model<P>,
        of: impl Fn(&AttachedFrame<T>, &mut DMatrix<T>),
    ) -> DMatrix<T>
    where
        T: Over<P>,
    {
        let frames = model.frames();
        assert!(
            self.links.iter().all(|link| link.0 < frames.len()),
            "the report is one of another robot than \"{}\"",
            model.name()
        );
        let [first, second] = self.links.map(|link| {
            let mut out = DMatrix::zeros(SPATIAL, model.nv());
            let frame = AttachedFrame {
                body: frames[link.0].body,
                X_WC: Transform::from_translation(self.point.position),
            };
            of(&frame, &mut out);
            out
        });
        first - second
    }

    /// Whether the point is in contact: whether the solver of rigid contact holds it, or soft contact pushes it; in the first lane.
    pub fn is_touching(&self) -> bool {
        acts(self.mode, &self.force)
    }
}

/// Whether a point is in contact, in the first lane: in the solver of rigid contact, or with a force of soft contact.
fn acts<T: Scalar>(mode: Mode, force: &Vector3<T>) -> bool {
    mode != Mode::Separated || force.iter().any(|x| x.value(0) != 0.0)
}

impl<P: Scalar> Simulator<P> {
    /// Reports on the contact points, and on constraints, at a state with the input `u` (length `nu`; N·m or N). Allocates.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    pub fn contact_report<T: Over<P>>(&self, state: &State<T>, u: &[T]) -> ContactReport<T> {
        let simulator = self;
        compiled_over_f64!(
            [P, T] Simulator::report, simulator: &Simulator, state: &State, u: &[f64] => ContactReport as ContactReport<T>
        )
    }

    fn report<T: Over<P>>(&self, state: &State<T>, u: &[T]) -> ContactReport<T> {
        self.check(state);
        let mut scratch = AccelerationScratch::new(self, Calls::One);
        if let Some(balance) = &mut scratch.balance {
            balance.measure();
        }
        let mut signals = Signals::default();
        let at = EvaluationPoint::of_step(self, state, signals.find(self, state, u));
        self.accelerate(&at, &mut scratch);
        let contact = &scratch.terms.contact;
        let n = self.contacts().map_or(0, |c| c.points().len());
        let mut out = ContactReport {
            points: contact.points[..n].to_vec(),
            forces: contact.forces[..n].to_vec(),
            links: vec![Force::zero(); self.model().links().len()],
            touching: vec![false; self.model().links().len()],
            modes: vec![Mode::Separated; contact.points.len()],
            reasons: Vec::with_capacity(n),
            pairs: Vec::new(),
            constraints: Vec::new(),
            certificate: Certificate::default(),
        };
        if let Some(balance) = &scratch.balance {
            let modes = contact.modes(balance);
            modes.for_each(|(i, mode)| out.modes[i] = mode);
            let solved = balance.rows().first_forces(self.bilateral_rows());
            out.constraints = scratch.terms.constraints.forces(&at, solved);
            out.certificate = balance.certificate();
        }
        if let Some(contacts) = self.contacts() {
            self.report_points(contacts, contact, &mut out);
        }
        out.modes.truncate(n);
        out
    }

    /// Adds what each point does, and the forces on links.
    fn report_points<T: Over<P>>(
        &self,
        contacts: &Contacts<P>,
        contact: &Contact<T>,
        out: &mut ContactReport<T>,
    ) {
        let dt = self.time_step().value(0);
        let (is_smoothed, n) = (contacts.smoothing().is_some(), out.points.len());
        for (i, (&mode, state)) in out.modes.iter().zip(&contact.points).enumerate() {
            let force = contact.forces[i];
            let (law, links) = contact.law_and_links(contacts, i);
            if acts(mode, &force) {
                let own = self.model().links().iter().zip(&mut out.touching);
                own.for_each(|(link, touching)| *touching |= links.contains(&link.frame));
            }
            let reason = law.reason(&PointOutcome {
                state,
                normal_force: dot(&state.normal, &force),
                mode,
                dt,
                is_smoothed,
            });
            match links {
                _ if i < n => out.reasons.push(reason),
                links => out.pairs.push(PairReport {
                    links,
                    point: *state,
                    force,
                    mode,
                    reason,
                }),
            }
        }
        for (link, out) in self.model().links().iter().zip(&mut out.links) {
            let X_BL = self.model().frames()[link.frame.0].placement.lift::<T>();
            contact.each_force_on(contacts, link.frame, |F| *out += X_BL.force_inverse(&F));
        }
    }
}
