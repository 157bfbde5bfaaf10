//! Contacts in a step: kind of solution, active points, and their rows.

use super::activation::ActivationMargin;
use super::contacts::Contacts;
use super::laws::{ContactLaw, ContactRow, LawKind, PointKinematics, ROWS};
use super::moments::Turning;
use super::shape_pairs::TURNING_NUMBERS;
use super::turning::TurningFriction;
use crate::cone::Law;
use crate::scalar::{MapEach, Over, Scalar};

/// Rows of a contact point in the solver's problem: normal, tangent, tangent.
pub(crate) struct PointRows<T> {
    pub(crate) rows: [ContactRow<T>; ROWS],
    /// μ, finite.
    pub(crate) friction: T,
}

impl<P: Scalar> Contacts<P> {
    fn has(&self, property: impl Fn(&LawKind) -> bool) -> bool {
        self.point_laws().kind().is_some_and(property)
    }

    /// Whether the solver finds the forces in a step whose contact forces are those of its start, or of an instant.
    pub(crate) fn are_solved_explicitly(&self) -> bool {
        self.has(|kind| kind.solved_explicitly)
    }

    /// Whether the solver finds the forces in a step whose contact forces are those of its end.
    pub(crate) fn are_solved_implicitly(&self) -> bool {
        self.has(|kind| kind.solved_implicitly)
    }

    /// Whether a working set of points is used.
    pub(crate) fn use_working_set(&self) -> bool {
        self.smoothing().is_none() && self.has(|kind| kind.working_set)
    }

    /// Whether points have bristles.
    pub(crate) fn have_bristles(&self) -> bool {
        self.has(|kind| kind.bristle)
    }

    /// Whether a point has a bristle: one with the ground may, between bodies there is none.
    pub(crate) fn has_bristle(&self, point: usize) -> bool {
        self.have_bristles() && point < self.points().len()
    }

    /// Torsional and rolling friction of a point with the ground; `None` without.
    pub(crate) fn turning(&self, point: usize) -> Option<TurningFriction<P>> {
        let some = self.point_laws().have_turning();
        some.then(|| self.point_turning(point))
            .filter(TurningFriction::acts)
    }

    /// Torsional and rolling friction of a pair of shapes; `None` without.
    pub(crate) fn turning_between(&self, shapes: [usize; 2]) -> Option<TurningFriction<P>> {
        let some = self.shape_pairs().has.turning;
        some.then(|| self.pair_turning(shapes))
            .filter(TurningFriction::acts)
    }

    /// Numbers of parameters of each point after those of its law: torsional and rolling friction, margin.
    pub(crate) fn counts_beside_law(&self) -> [usize; 2] {
        let laws = self.point_laws();
        let turning = if laws.have_turning() {
            TURNING_NUMBERS
        } else {
            0
        };
        [turning, usize::from(laws.have_margins())]
    }

    /// Height above the ground at which contact of a point begins, m.
    pub(crate) fn margin(&self, point: usize) -> P {
        self.point_laws().margin(point).unwrap_or_else(P::zero)
    }

    /// Whether some points may have torsional or rolling friction.
    pub(crate) fn have_turning(&self) -> bool {
        self.point_laws().have_turning() || self.shape_pairs().has.turning
    }

    /// Whether some points between bodies may have torsional or rolling friction.
    pub(crate) fn have_turning_between(&self) -> bool {
        self.shape_pairs().has.turning
    }

    /// The most rows of a point.
    pub(crate) fn rows_of_each(&self) -> usize {
        if self.have_turning() { 2 * ROWS } else { ROWS }
    }

    /// Rows of the moments of a point about its axes.
    ///
    /// * `across` – a row of the point across its normal
    pub(crate) fn turning_rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        law: &ContactLaw<P>,
        at: &PointKinematics<'_, D, T>,
        turning: &Turning<P, T>,
        across: &ContactRow<T>,
    ) -> [ContactRow<T>; ROWS] {
        let own = law.turning(T::from(at.dt), across.compliance);
        turning.rows(at.axes, own)
    }

    /// Whether rows depend on the Delassus diagonal.
    pub(crate) fn read_delassus(&self) -> bool {
        self.has(|kind| kind.reads_delassus)
    }

    /// Name of the law, if its forces act over a step and are none of an instant.
    pub(crate) fn acting_over_step(&self) -> Option<&'static str> {
        let kind = self.point_laws().kind().filter(|kind| kind.acts_over_step);
        kind.map(|kind| kind.name)
    }

    /// Whether some impact may leave a part of its speed, by a law that is not smoothed.
    pub(crate) fn may_bounce(&self) -> bool {
        let laws = self.point_laws().as_slice().iter();
        self.smoothing().is_none() && { laws }.any(|law| law.restitution().is_some())
    }

    /// Friction law of the cones.
    pub(crate) fn cone(&self) -> Law {
        self.point_laws()
            .kind()
            .map_or(Law::Coulomb, |kind| kind.cone)
    }

    /// Region about the ground in which points take part in a step of `dt` (s): that of their law, or of its smoothing.
    pub(crate) fn activation_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D> {
        let law = self.point_laws().first();
        ActivationMargin {
            reach: self.smoothing().map_or(0.0, |s| s.reach()),
            ..law.map_or_else(ActivationMargin::surface, |law| law.activation_margin(dt))
        }
    }

    /// [`activation_margin`](Self::activation_margin) about the shapes of bodies: where contact is speculative, all that could arrive within the step.
    pub(crate) fn pair_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D> {
        let own = self.activation_margin(dt);
        if self.shape_pairs().speculative {
            return ActivationMargin {
                reach: own.reach,
                ..ActivationMargin::over_step(dt)
            };
        }
        own
    }

    /// κ for the forces and accelerations of a step of `dt` (s), N·m/s²; `None` for the exact law.
    pub(crate) fn kappa_over_step<D: Scalar>(&self, dt: D) -> Option<D> {
        self.smoothing().map(|s| D::constant(s.kappa()) / dt)
    }

    /// Rows of a point by its law. In a lane in which a smoothed law does not reach it, it takes no part.
    pub(crate) fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        law: &ContactLaw<P>,
        at: &PointKinematics<'_, D, T>,
    ) -> PointRows<T> {
        let mut rows = law.rows(at);
        if at.kappa.is_some() {
            let inside = self.activation_margin(at.dt).distance_inside(at.state);
            rows = rows.map_each(|row| row.within(inside));
        }
        PointRows {
            rows,
            friction: law.friction_at(at.state.depth, at.speculative),
        }
    }
}

impl<T: Scalar> PointRows<T> {
    /// These rows where a margin is positive, elsewhere those of a point that takes no part.
    pub(crate) fn within(self, margin: T) -> Self {
        Self {
            rows: self.rows.map_each(|row| row.within(margin)),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use crate::contact::{PointState, RelaxedRigid, Rigid, Smoothing, SoftContact, Terrain};
    use nalgebra::Vector3;

    fn contacts(law: ContactLaw) -> Contacts {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
        let model = Model::from_urdf_file(path).expect("an asset");
        Contacts::new(&model, Terrain::flat(0.0), law)
    }

    fn height_that_takes_part(contacts: &Contacts, velocity: f64, dt: f64) -> f64 {
        let point = PointState {
            velocity: Vector3::z() * velocity,
            ..PointState::zero()
        };
        contacts.activation_margin(dt).distance_inside(&point)
    }

    // In 10 ms at 2 m/s: rigid points may gain 10 m/s more, soft ones are met within the step, relaxed ones in the ground.
    #[test]
    fn margins_are_those_of_the_laws_or_of_their_smoothing() {
        let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
        let [rigid, relaxed, soft] = [
            ContactLaw::Rigid(Rigid::default()),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            soft,
        ]
        .map(contacts);
        let smoothed = |contacts: &Contacts, reach| {
            contacts
                .clone()
                .with_smoothing(Smoothing::new(1.0).with_reach(reach))
        };
        for (contacts, expected) in [
            (&rigid, 0.12),
            (&relaxed, 0.0),
            (&soft, 0.02),
            (&smoothed(&rigid, 0.3), 0.3),
            (&smoothed(&rigid, 0.05), 0.12),
            (&smoothed(&relaxed, 0.05), 0.05),
        ] {
            let found = height_that_takes_part(contacts, -2.0, 0.01);
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        assert!(rigid.use_working_set() && !smoothed(&rigid, 0.1).use_working_set());
        let kappa = smoothed(&rigid, 0.1).kappa_over_step(0.01);
        assert!((kappa.unwrap_or_default() - 100.0).abs() < 1e-12);
    }

    // Beyond its reach a smoothed law has no force.
    #[test]
    fn smoothed_rows_are_inactive_out_of_reach() {
        let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
        let contacts = contacts(law).with_smoothing(Smoothing::new(1.0).with_reach(0.05));
        let compliance = |depth: f64| {
            let state = PointState {
                depth,
                ..PointState::zero()
            };
            let rows = contacts.rows(
                &contacts.laws()[0],
                &PointKinematics {
                    state: &state,
                    axes: &state.axes(),
                    deflection: None,
                    delassus: 1.0,
                    dt: 0.01,
                    kappa: contacts.kappa_over_step(0.01),
                    speculative: false,
                },
            );
            rows.rows[0].compliance
        };
        assert!(compliance(-0.049).is_finite());
        assert_eq!(compliance(-0.051), f64::INFINITY);
    }
}
