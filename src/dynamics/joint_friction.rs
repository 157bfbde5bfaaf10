//! Dry friction of joints in the articulated-body algorithm: which of them stick.
//!
//! Over a step Δt the friction τ of a coordinate, of at most b, obeys
//!
//! > v⁺ = 0,  or  τ = −b where v⁺ > 0,  or  τ = b where v⁺ < 0.
//!
//! With the articulated inertia I and bias force F of its body, and the acceleration A that the body has at the acceleration a of the coordinate, stopping
//! it, at −v / Δt, needs
//!
//! > τ = Sᵀ F + Uᵀ A + R a − τ_given + D (−v / Δt − a),  U = I S,  D = Sᵀ U + R.
//!
//! Within ±b it sticks, beyond it slips. The first pass inward guesses as it goes, as if the body did not accelerate. Later passes follow the accelerations of
//! the pass before, and repeat only the part of the tree before the last joint that changes. Where no decision changes, the solution is found; it is unique,
//! since M is positive definite. Motions in which joints stop and break away need one to three passes.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::scalar::Scalar;
use crate::spatial::{Force, Motion};

/// Implicit damping of a sticking joint, kg or kg·m²: the inertia of any robot is negligible beside it. It holds as well as an infinite value, which
/// has no derivatives.
pub(crate) const HELD: f64 = 1e25;
/// Relative tolerance of a force beyond its bound: rounding of much larger forces must not make a joint slide.
pub(crate) const BEYOND: f64 = 1e-9;
/// Most passes inward; 64 random states of robots of up to 35 coordinates need up to 7, mostly 1 or 2.
const MOST_PASSES: usize = 8;

/// Friction of a coordinate over a step, and the piece of its law that holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointFriction<T> {
    /// Acceleration that stops the coordinate, −v / Δt.
    pub(crate) stop: T,
    /// b, N·m or N; negative where there is no friction.
    pub(crate) bound: T,
    /// 0 where it sticks, −1 or 1 where it slips under −b or b.
    pub(crate) piece: T,
}

/// A coordinate as it was eliminated last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eliminated<T> {
    pub(super) U: Force<T>,
    /// Sᵀ F − τ.
    pub(super) bias: T,
    /// Sᵀ U.
    pub(super) inertia: T,
    /// R, without that of sticking.
    pub(super) resistance: T,
    /// The piece that the last pass outward suggests.
    pub(super) next: T,
}

/// Friction of all coordinates, with working memory; empty where no joint has any.
#[derive(Clone, Debug)]
pub(super) struct Frictions<T> {
    pub(super) all: Vec<JointFriction<T>>,
    pub(super) eliminated: Vec<Eliminated<T>>,
    /// Whether pieces are found, otherwise given; whether the next pass inward guesses them.
    decide: bool,
    pub(super) guess: bool,
    /// By how many pieces the last solution differs from those that it suggests.
    pub(super) changes: T,
    /// The last body one of whose pieces differs; none if there is none.
    pub(super) last: Option<usize>,
}

/// Who decides which joints stick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Decision {
    /// The pieces are given.
    Given,
    /// Forward dynamics.
    Own,
}

/// The piece of a bounded force: 0 within ±`bound`, −1 below and 1 above.
#[inline(always)]
pub(crate) fn side_of<T: Scalar>(force: T, bound: T) -> T {
    let (zero, one) = (T::zero(), T::one());
    let below = force.select_lt(-bound, -one, zero);
    bound.select_lt(force, one, below)
}

impl<T: Scalar> JointFriction<T> {
    /// That of a coordinate without friction.
    pub(crate) fn none() -> Self {
        Self {
            stop: T::zero(),
            bound: -T::one(),
            piece: T::one(),
        }
    }

    /// One of two numbers, in each lane.
    fn select(&self, sticking: T, slipping: T) -> T {
        self.piece
            .abs()
            .select_lt(T::constant(0.5), sticking, slipping)
    }

    /// The force at a = 0 and its resistance.
    #[inline(always)]
    pub(super) fn parts(&self) -> [T; 2] {
        let (zero, held) = (T::zero(), T::constant(HELD));
        let slipping = zero.select_lt(self.bound, self.bound, zero) * self.piece;
        let stopping = self.stop * held;
        [self.select(stopping, slipping), self.select(held, zero)]
    }

    /// The piece for the force that stopping needs.
    #[inline(always)]
    pub(super) fn next(&self, needed: T) -> T {
        let (zero, one) = (T::zero(), T::one());
        let next = side_of(needed, self.bound * (1.0 + BEYOND));
        // Without a force both directions are one piece. A negative bound is that of a coordinate without friction, also where a force is no number.
        let next = zero.select_lt(self.bound, next, next.abs());
        self.bound.select_lt(zero, one, next)
    }

    /// The piece of a coordinate with the articulated inertia D if its body did not accelerate.
    ///
    /// * `bias` – Sᵀ F − τ
    #[inline(always)]
    pub(super) fn guess(&self, inertia: T, bias: T) -> T {
        self.next(inertia.mul_add(self.stop, bias))
    }

    /// The piece on the way to another one: from one direction of slip to the other through sticking. Without this halt, decisions of joints on one another
    /// may go in circles.
    #[inline(always)]
    pub(super) fn neighbour(&self, next: T) -> T {
        let (zero, apart) = (T::zero(), (next - self.piece).abs());
        T::constant(1.5).select_lt(apart, zero, next)
    }
}

impl<T: Scalar> Eliminated<T> {
    /// Of a coordinate that has not been eliminated.
    fn none() -> Self {
        Self {
            U: Force::zero(),
            bias: T::zero(),
            inertia: T::zero(),
            resistance: T::zero(),
            next: T::zero(),
        }
    }

    /// The force that stopping needs, under the accelerations of the body and of the coordinate.
    #[inline(always)]
    pub(super) fn needed(&self, A: &Motion<T>, a: T, stop: T) -> T {
        let inertial = A.power(&self.U) + self.bias + self.resistance * a;
        (self.inertia + self.resistance).mul_add(stop - a, inertial)
    }
}

impl<T: Scalar> Frictions<T> {
    pub(super) fn none() -> Self {
        Self {
            all: Vec::new(),
            eliminated: Vec::new(),
            decide: true,
            guess: true,
            changes: T::zero(),
            last: None,
        }
    }

    /// Takes friction of all coordinates, which the caller gets back by the same swap.
    pub(super) fn take(&mut self, all: &mut Vec<JointFriction<T>>, decision: Decision) {
        std::mem::swap(&mut self.all, all);
        self.start(decision == Decision::Own);
    }

    fn start(&mut self, decide: bool) {
        (self.decide, self.guess) = (decide, decide);
        self.changes = T::zero();
        self.eliminated.resize(self.all.len(), Eliminated::none());
    }

    /// Takes friction of a robot in plain numbers, each lane that of the coordinate that `map` names for it.
    #[inline(always)]
    pub(super) fn gather<S: Scalar>(&mut self, map: &[usize], from: &Frictions<S>) {
        self.all.clear();
        if !from.act() {
            return;
        }
        for own in map.chunks_exact(T::LANES) {
            let at = |lane: usize| &from.all[own[lane]];
            self.all.push(JointFriction {
                stop: T::from_values(|lane| at(lane).stop.value(0)),
                bound: T::from_values(|lane| at(lane).bound.value(0)),
                piece: T::from_values(|lane| at(lane).piece.value(0)),
            });
        }
        self.start(from.decide);
    }

    /// Whether there may be any: never for numbers that are more than values, of which forward dynamics knows no friction.
    pub(super) const MAY_ACT: bool = T::HAS_VALUES && T::ORDER == 0;

    /// Whether there is any.
    #[inline(always)]
    pub(super) fn act(&self) -> bool {
        Self::MAY_ACT && !self.all.is_empty()
    }

    /// Takes over the pieces that the last pass suggests.
    #[inline(always)]
    pub(super) fn follow(&mut self) {
        self.guess = false;
        for (friction, own) in self.all.iter_mut().zip(&self.eliminated) {
            friction.piece = own.next;
        }
    }

    /// Whether another pass inward may follow after so many.
    #[inline(always)]
    pub(super) fn may_go_on(&self, passes: usize) -> bool {
        self.decide && passes < MOST_PASSES
    }
}
