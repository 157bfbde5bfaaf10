//! Rows of constraints at a state: errors, rates and Jacobians.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::anchor::{AnchorMotion, turn_between};
use super::hold::{ForceLaw, Hold, Holds};
use super::joints::joint_position;
use super::weld_angle::WeldAngle;
use super::{Constraint, ConstraintKind};
use crate::model::Model;
use crate::scalar::{Over, Scalar, from_each};
use crate::spatial::linear::{dot, scale};
use crate::spatial::{Force, Motion, SPATIAL};

/// A row at a state, for accelerations ã in which the linear velocity of floating and planar joints is seen from their
/// joint frame, less what turns about the centre of mass: φ̈ = J ã + b.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstraintRow<T> {
    /// φ.
    pub(crate) error: T,
    /// φ̇ = J v.
    pub(crate) rate: T,
    /// b, of second degree in the velocity.
    pub(crate) bias: T,
    /// J (ω × (v + ω × c)) with centres of mass c, by which J ã is more than J v̇.
    pub(crate) turning: T,
    /// Rigid, by a spring and damper, or regularised.
    pub(crate) hold: Hold<T>,
    /// The largest force, N or N·m; `None` for any.
    pub(crate) largest_force: Option<T>,
}

impl<T: Scalar> ConstraintRow<T> {
    /// The row over other numbers.
    pub(crate) fn map<L>(&self, to: impl Fn(T) -> L) -> ConstraintRow<L> {
        ConstraintRow {
            error: to(self.error),
            rate: to(self.rate),
            bias: to(self.bias),
            turning: to(self.turning),
            hold: self.hold.map(&to),
            largest_force: self.largest_force.map(&to),
        }
    }

    /// Stabilised bias of a rigid row at an instant, which J ã has to cancel so that errors decay:  b + (2 / T) φ̇ + φ / T²,  T at least
    /// twice the time step.
    pub(crate) fn at_moment<D: Scalar>(&self, time_constant: T, dt: D) -> T
    where
        T: Over<D>,
    {
        stabilized(self.error, self.rate, self.bias, time_constant, dt)
    }

    /// Stabilised bias of a rigid row over an Euler step, which J ã has to cancel:  ½ (b + b⁺) + (2 / T) (φ̇ − ½ Δt b) + φ /
    /// T²,  with the bias b⁺ at the velocity after the step. A step moves along that velocity, so φ changed by Δt
    /// (φ̇ − ½ Δt b) in the one before.
    pub(crate) fn over_step<D: Scalar>(&self, after: T, time_constant: T, dt: D) -> T
    where
        T: Over<D>,
    {
        let rate = self.rate - self.bias * (dt * 0.5);
        let bias = (self.bias + after) * 0.5;
        stabilized(self.error, rate, bias, time_constant, dt)
    }

    /// Whether it is to be closed, not one of a spring.
    pub(crate) fn is_closed(&self) -> bool {
        !matches!(self.hold, Hold::Spring { .. })
    }

    /// The force of a spring and damper at an instant, within its bound: −k φ − d φ̇; `None` for other rows.
    pub(crate) fn spring_force(&self) -> Option<T> {
        let Hold::Spring { stiffness, damping } = self.hold else {
            return None;
        };
        let force = -(stiffness * self.error + damping * self.rate);
        let bounded = |bound: T| force.max(-bound).min(bound);
        Some(self.largest_force.map_or(force, bounded))
    }
}

/// b + (2 / T) φ̇ + φ / T²
fn stabilized<D: Scalar, T: Over<D>>(error: T, rate: T, bias: T, time_constant: T, dt: D) -> T {
    let often = T::one() / time_constant.max(T::from(dt * 2.0));
    bias + often * (rate * 2.0 + often * error)
}

/// Rows of several constraints.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintRows<T> {
    pub(crate) rows: Vec<ConstraintRow<T>>,
    /// J, row by row, `nv` numbers each.
    pub(crate) jacobian: Vec<T>,
    /// The rows at another velocity.
    after: Vec<ConstraintRow<T>>,
    /// Jacobians of one anchor, and of the second relative to the first, 6 × `nv`.
    pub(super) own: DMatrix<T>,
    pub(super) relative: DMatrix<T>,
}

/// Distances below this have no direction, m.
const NO_DISTANCE: f64 = 1e-9;

impl<T: Scalar> ConstraintRows<T> {
    /// Memory for so many rows.
    pub(crate) fn new(rows: usize, nv: usize) -> Self {
        Self {
            rows: Vec::with_capacity(rows),
            jacobian: Vec::with_capacity(rows * nv),
            after: Vec::with_capacity(rows),
            own: DMatrix::zeros(SPATIAL, nv),
            relative: DMatrix::zeros(SPATIAL, nv),
        }
    }

    /// Computes all rows at a state, in a step of `dt`; does not allocate.
    pub(crate) fn evaluate<P: Scalar>(
        &mut self,
        model: &Model<P>,
        constraints: &[Constraint<P>],
        q: &[T],
        v: &[T],
        dt: T,
    ) where
        T: Over<P>,
    {
        self.rows.clear();
        self.jacobian.clear();
        for constraint in constraints {
            let motions = constraint.kind().motions(model, q, v);
            push_rows(&mut self.rows, model, constraint, &motions, [q, v], dt);
            self.push_jacobian(model, constraint, &motions, q);
        }
        turn(&mut self.rows, model, &self.jacobian, v);
    }

    /// Computes the biases at the velocity after a step, at the configuration of [`evaluate`](Self::evaluate); does not
    /// allocate.
    pub(crate) fn look_ahead<P: Scalar>(
        &mut self,
        model: &Model<P>,
        constraints: &[Constraint<P>],
        q: &[T],
        v: &[T],
    ) where
        T: Over<P>,
    {
        self.after.clear();
        for constraint in constraints {
            let motions = constraint.kind().motions(model, q, v);
            push_rows(
                &mut self.after,
                model,
                constraint,
                &motions,
                [q, v],
                T::one(),
            );
        }
        turn(&mut self.after, model, &self.jacobian, v);
    }

    /// b⁺ of a row, from [`look_ahead`](Self::look_ahead).
    pub(crate) fn bias_after(&self, row: usize) -> T {
        self.after[row].bias
    }

    fn push_jacobian<P: Scalar>(
        &mut self,
        model: &Model<P>,
        constraint: &Constraint<P>,
        motions: &[AnchorMotion<T>; 2],
        q: &[T],
    ) where
        T: Over<P>,
    {
        let kind = constraint.kind();
        self.relative.fill(T::zero());
        for ((anchor, at), sign) in kind.anchors().iter().zip(motions).zip([-1.0, 1.0]) {
            anchor.add_jacobian(model, q, at, sign, &mut self.own, &mut self.relative);
        }
        if let (ConstraintKind::Weld(_), ForceLaw::Soft(_)) = (kind, &constraint.hold) {
            WeldAngle::between(motions).turn(&mut self.relative);
        }
        match kind {
            ConstraintKind::Weld(_) | ConstraintKind::Ball(_) => {
                for row in self.relative.row_iter().take(kind.rows()) {
                    self.jacobian.extend(row.iter());
                }
            }
            ConstraintKind::Distance { .. } => {
                let n = Span::between(motions).n;
                let columns = self.relative.column_iter();
                let along = columns.map(|c| n.x * c[0] + n.y * c[1] + n.z * c[2]);
                self.jacobian.extend(along);
            }
            ConstraintKind::Coupler { .. } | ConstraintKind::Tendon { .. } => {
                let row = self.jacobian.len();
                self.jacobian.resize(row + model.nv(), T::zero());
                for tied in kind.joints() {
                    let body = model.body(tied.body);
                    let [_, slope, ..] = tied.at(joint_position(body, q));
                    self.jacobian[row + body.v] += body.scaled(slope);
                }
            }
        }
    }
}

/// Adds the rows of one constraint, without the effect of rotating joint axes.
fn push_rows<P: Scalar, T: Over<P>>(
    rows: &mut Vec<ConstraintRow<T>>,
    model: &Model<P>,
    constraint: &Constraint<P>,
    motions: &[AnchorMotion<T>; 2],
    [q, v]: [&[T]; 2],
    dt: T,
) {
    rows.extend(constraint.row_of_joints(model, q, v, dt));
    constraint.each_row_of_anchors(motions, dt, |row, _| rows.push(row));
}

impl<P: Scalar> Constraint<P> {
    /// Passes each row between two anchors, whose accelerations `A` are those while ã = 0, with its axis to `each`; constraints that tie joints have
    /// none.
    ///
    /// * `dt` – the step, s, which regularised rows depend on
    #[inline(always)]
    pub(super) fn each_row_of_anchors<T: Over<P>>(
        &self,
        motions: &[AnchorMotion<T>; 2],
        dt: T,
        mut each: impl FnMut(ConstraintRow<T>, RowAxis<T>),
    ) {
        let [from, to] = motions;
        let (V, A) = (to.V - from.V, to.A - from.A);
        let holds = self.hold.at(|| self.squares(motions), dt);
        match self.kind() {
            ConstraintKind::Weld(_) | ConstraintKind::Ball(_) => {
                let error = to.X.translation - from.X.translation;
                for k in 0..3 {
                    let row = self.row([error[k], V.linear[k], A.linear[k]], &holds, false);
                    each(row, RowAxis::Coordinate(k));
                }
            }
            // With d = ‖p‖ and n = p / d:  ḋ = n · ṗ,  d̈ = n · p̈ + (ṗ · ṗ − ḋ²) / d.
            ConstraintKind::Distance { length, .. } => {
                let Span { n, d } = Span::between(motions);
                let rate = dot(&n, &V.linear);
                let across = dot(&V.linear, &V.linear) - rate * rate;
                let bias = dot(&n, &A.linear) + across / d;
                let row = self.row([d - T::from(*length), rate, bias], &holds, false);
                each(row, RowAxis::Along(n));
            }
            ConstraintKind::Coupler { .. } | ConstraintKind::Tendon { .. } => {}
        }
        match (self.kind(), &holds) {
            (ConstraintKind::Weld(_), Holds::Alike(_)) => {
                let turn = turn_between(&from.X, &to.X);
                for k in 0..3 {
                    let row = self.row([turn[k], V.angular[k], A.angular[k]], &holds, true);
                    each(row, RowAxis::Coordinate(3 + k));
                }
            }
            (ConstraintKind::Weld(_), Holds::Soft(_)) => {
                WeldAngle::between(motions).each_row(motions, |numbers, axis| {
                    each(self.row(numbers, &holds, true), RowAxis::About(axis));
                });
            }
            _ => {}
        }
    }

    /// |p|² and |θ|² of the errors between two anchors.
    fn squares<T: Over<P>>(&self, motions: &[AnchorMotion<T>; 2]) -> [T; 2] {
        let p = motions[1].X.translation - motions[0].X.translation;
        let square = dot(&p, &p);
        match self.kind() {
            ConstraintKind::Weld(_) => [square, WeldAngle::between(motions).square()],
            ConstraintKind::Distance { length, .. } => {
                let error = Span::between(motions).d - T::from(*length);
                [error * error, T::zero()]
            }
            _ => [square, T::zero()],
        }
    }

    /// A row from its error, rate and bias.
    ///
    /// * `holds` – the force laws of all rows
    #[inline]
    pub(super) fn row<T: Over<P>>(
        &self,
        [error, rate, bias]: [T; 3],
        holds: &Holds<T>,
        is_angular: bool,
    ) -> ConstraintRow<T> {
        ConstraintRow {
            error,
            rate,
            bias,
            turning: T::zero(),
            hold: holds.row(error, rate, is_angular),
            largest_force: self.largest_force().map(T::from),
        }
    }
}

/// Subtracts the effect of rotating axes of floating and planar joints from the biases, and stores it.
pub(super) fn turn<P: Scalar, T: Over<P>>(
    rows: &mut [ConstraintRow<T>],
    model: &Model<P>,
    jacobian: &[T],
    v: &[T],
) {
    for body in model.independent() {
        body.turning(v, |k, x| {
            let entries = jacobian.iter().skip(k).step_by(v.len());
            for (row, &entry) in rows.iter_mut().zip(entries) {
                row.turning += entry * x;
                row.bias -= entry * x;
            }
        });
    }
}

/// Part of the motion of the second anchor relative to the first, in mixed representation, that a row sees.
pub(super) enum RowAxis<T> {
    Coordinate(usize),
    /// The linear part along a unit vector.
    Along(Vector3<T>),
    /// The angular part along a vector.
    About(Vector3<T>),
}

impl<T: Scalar> RowAxis<T> {
    #[inline(always)]
    pub(super) fn of(&self, V: &Motion<T>) -> T {
        match self {
            Self::Coordinate(k) => V.coordinate(*k),
            Self::Along(n) => dot(n, &V.linear),
            Self::About(n) => dot(n, &V.angular),
        }
    }

    /// The force whose power is that.
    #[inline(always)]
    pub(super) fn unit_force(&self) -> Force<T> {
        match self {
            Self::Coordinate(k) => Force::from_array(from_each(|i| match i == *k {
                true => T::one(),
                false => T::zero(),
            })),
            Self::Along(n) => Force::new(*n, Vector3::zeros()),
            Self::About(n) => Force::new(Vector3::zeros(), *n),
        }
    }
}

/// Vector from the origin of one anchor to that of the other.
struct Span<T> {
    /// Unit vector.
    n: Vector3<T>,
    /// Length, m.
    d: T,
}

impl<T: Scalar> Span<T> {
    fn between([from, to]: &[AnchorMotion<T>; 2]) -> Self {
        let p = to.X.translation - from.X.translation;
        let least = T::constant(NO_DISTANCE * NO_DISTANCE);
        let square = dot(&p, &p);
        let d = square.select_lt(least, least, square).sqrt();
        Self {
            n: scale(&p, T::one() / d),
            d,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::Anchor;
    use crate::model::samples;
    use crate::scalar::Dual;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    fn evaluated<T: Over<f64>>(
        model: &Model,
        constraints: &[Constraint],
        q: &[T],
        v: &[T],
    ) -> ConstraintRows<T> {
        let rows = constraints.iter().map(Constraint::rows).sum();
        let mut out = ConstraintRows::new(rows, model.nv());
        out.evaluate(model, constraints, q, v, T::constant(0.01));
        out
    }

    /// One constraint of each kind; the weld holds at `q`.
    fn every_kind(model: &Model, q: &[f64]) -> Vec<Constraint> {
        let [a, b] = ["link3", "link6"].map(|link| Anchor::frame(model, link).unwrap());
        let far = b.moved([0.7, -0.4, 0.9]);
        vec![
            Constraint::weld([a.brought_to(&b, model, q), b]),
            Constraint::ball([a, far]),
            Constraint::distance([a, far], 0.5),
            Constraint::coupler(model, ["joint0", "joint1"], -0.7, 0.2).unwrap(),
            Constraint::tendon(model, &[("joint1", 0.3), ("joint0", -1.1)], 0.2).unwrap(),
        ]
    }

    // Along q(t) = q ⊕ v t, whose velocity stays, φ̈ is what turns and what the bias has.
    #[test]
    fn rates_and_biases_equal_the_derivatives_of_errors_in_time() {
        for seed in 0..10 {
            let model = samples::random_tree(8, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 2.0);
            let constraints = every_kind(&model, q.as_slice());
            let plain = evaluated(&model, &constraints, q.as_slice(), v.as_slice());
            let lift = |x: &f64| Dual::<f64, 1>::from(*x);
            let start: Vec<_> = q.iter().map(lift).collect();
            let along: Vec<_> = v.iter().map(|&v| Dual::new(0.0, [v])).collect();
            let moving = model.integrate(&start, &along);
            let v_dual: Vec<_> = v.iter().map(lift).collect();
            let duals = evaluated(&model, &constraints, moving.as_slice(), &v_dual);
            let scale = plain
                .rows
                .iter()
                .map(|row| row.bias.abs())
                .fold(1.0, f64::max);
            for (k, (row, dual)) in plain.rows.iter().zip(&duals.rows).enumerate() {
                let rate = (row.rate - dual.error.eps[0]).abs();
                let acceleration = (row.bias + row.turning - dual.rate.eps[0]).abs();
                assert!(
                    rate < SAME_ALGEBRA * scale,
                    "tree {seed}, row {k}: {rate:e}"
                );
                assert!(
                    acceleration < SAME_ALGEBRA * scale,
                    "tree {seed}, row {k}: {acceleration:e}"
                );
            }
        }
    }

    #[test]
    fn jacobian_times_velocity_equals_the_rates() {
        for seed in 0..10 {
            let model = samples::random_tree(8, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 2.0);
            let constraints = every_kind(&model, q.as_slice());
            let rows = evaluated(&model, &constraints, q.as_slice(), v.as_slice());
            for (row, entries) in rows.rows.iter().zip(rows.jacobian.chunks(model.nv())) {
                let rate: f64 = entries.iter().zip(&v).map(|(j, v)| j * v).sum();
                assert!(
                    (rate - row.rate).abs() < SAME_ALGEBRA * rate.abs().max(1.0),
                    "tree {seed}"
                );
            }
        }
    }

    // From the tip p = (0, sin q, −cos q) of a pendulum to (0, 2, 0):  d = √(5 − 4 sin q),  ḋ = −2 cos q q̇ / d,
    // d̈ = (2 sin q q̇² − ḋ²) / d  while q̈ = 0.
    #[test]
    fn rod_from_a_pendulum_to_the_world_equals_the_closed_form() {
        let model = samples::pendulum();
        let tip = Anchor::frame(&model, "rod").unwrap();
        let tip = tip.moved([0.0, 0.0, -1.0]);
        let rod = Constraint::distance([tip, Anchor::world().moved([0.0, 2.0, 0.0])], 1.5);
        let (q, v) = (0.4_f64, -1.7);
        let rows = evaluated(&model, &[rod], &[q], &[v]);
        let (sin, cos) = q.sin_cos();
        let d = (5.0 - 4.0 * sin).sqrt();
        let rate = -2.0 * cos * v / d;
        let row = rows.rows[0];
        assert!((row.error - (d - 1.5)).abs() < ROUNDING);
        assert!((row.rate - rate).abs() < ROUNDING);
        assert!((rows.jacobian[0] - rate / v).abs() < ROUNDING);
        let bias = (2.0 * sin * v * v - rate * rate) / d;
        assert!((row.bias - bias).abs() < 10.0 * ROUNDING);
        assert_eq!(row.turning, 0.0);
    }

    // φ = q₁ − r q₂ − o, linear in the configuration.
    #[test]
    fn coupler_equals_its_linear_equation() {
        let model = samples::double_pendulum();
        let coupler = Constraint::coupler(&model, ["shoulder", "elbow"], 0.5, 0.25).unwrap();
        let rows = evaluated(&model, &[coupler], &[1.0, 2.0], &[3.0, 4.0]);
        let row = rows.rows[0];
        assert_eq!((row.error, row.rate, row.bias), (-0.25, 1.0, 0.0));
        assert_eq!(rows.jacobian, [1.0, -0.5]);
    }

    // T = 0.1 s: b + 20 φ̇ + 100 φ; a step of 0.1 s makes of it T = 0.2 s: b + 10 φ̇ + 25 φ.
    #[test]
    fn stabilised_bias_equals_baumgartes_formula() {
        let row = ConstraintRow {
            error: 0.03,
            rate: 0.2,
            bias: 5.0,
            turning: 0.0,
            hold: Hold::Rigid { time_constant: 0.1 },
            largest_force: None,
        };
        assert!((row.at_moment(0.1, 0.01) - 12.0_f64).abs() < 10.0 * ROUNDING);
        assert!((row.at_moment(0.1, 0.1) - 7.75).abs() < 10.0 * ROUNDING);
        // ½ (5 + 7) + 20 (0.2 − 0.005 · 5) + 100 · 0.03
        assert!((row.over_step(7.0, 0.1, 0.01) - 12.5).abs() < 10.0 * ROUNDING);
        assert_eq!(row.spring_force(), None);
    }

    // −200 · 0.03 − 10 · 0.2 = −8
    #[test]
    fn force_of_a_spring_at_a_moment_stays_within_its_bound() {
        let hold = Hold::Spring {
            stiffness: 200.0,
            damping: 10.0,
        };
        let row = |largest_force| ConstraintRow {
            error: 0.03,
            rate: 0.2,
            bias: 5.0,
            turning: 0.0,
            hold,
            largest_force,
        };
        let force = |bound| row(bound).spring_force().expect("a spring");
        assert!((force(None) + 8.0_f64).abs() < 10.0 * ROUNDING);
        assert!((force(Some(9.0)) + 8.0).abs() < 10.0 * ROUNDING);
        assert_eq!(force(Some(3.0)), -3.0);
    }

    #[test]
    fn biases_after_a_step_equal_those_at_the_velocity_there() {
        let model = samples::random_tree(8, 5);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let q = model.random_configuration(&mut rng);
        let [v, next] = [(); 2].map(|()| model.random_velocity(&mut rng, 2.0));
        let constraints = every_kind(&model, q.as_slice());
        let mut rows = evaluated(&model, &constraints, q.as_slice(), v.as_slice());
        let there = evaluated(&model, &constraints, q.as_slice(), next.as_slice());
        rows.look_ahead(&model, &constraints, q.as_slice(), next.as_slice());
        for (k, row) in there.rows.iter().enumerate() {
            assert_eq!(rows.bias_after(k), row.bias, "row {k}");
        }
    }

    #[test]
    fn rod_without_length_between_its_ends_stays_finite() {
        let model = samples::pendulum();
        let pivot = Anchor::frame(&model, "rod").unwrap();
        let rod = Constraint::distance([pivot, Anchor::world()], 1.0);
        let rows = evaluated(&model, &[rod], &[0.3], &[2.0]);
        let row = rows.rows[0];
        assert!((row.error + 1.0).abs() < 2.0 * NO_DISTANCE);
        assert!(row.rate.is_finite() && row.bias.is_finite() && rows.jacobian[0].is_finite());
    }
}
