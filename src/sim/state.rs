//! The state of a robot.

use std::ops::Range;

use nalgebra::DVector;
use rand::Rng;

use crate::error::InvalidState;
use crate::joint::JointKind;
use crate::model::manifold::{q_range, v_range};
use crate::model::{BodyId, Model};
use crate::scalar::{Cast, Over, Scalar};

/// Configuration, velocity, the state of soft contact, the activations of inputs, and what sleeps.
///
/// A state carries no model identity; functions check lengths only, so the state of another robot with the same number of coordinates is not refused.
/// [`Rollout`](super::Rollout) and [`BatchStates`](super::BatchStates) know their robot.
#[derive(Clone, Debug, PartialEq)]
pub struct State<T: Scalar = f64> {
    /// Configuration, length `nq`.
    pub q: DVector<T>,
    /// Velocity in tangent coordinates, length `nv`. That of a floating base is `[linear; angular]` in the axes of the base, not of the world.
    pub v: DVector<T>,
    /// The contact state: for [soft contact](crate::contact::SoftContact) the bristle deflection of each point in the world, m, three values per
    /// point; otherwise empty. It is a vector space.
    pub contact: DVector<T>,
    /// The [activations](super::Activation) of inputs, in the order in which they were set. Each has its delayed inputs, the oldest first, then the state
    /// of its dynamics. Empty without activations. It is a vector space.
    pub activation: DVector<T>,
    /// Which trees of joints [sleep](super::Sleeping), as two numbers for each tree. Everything is awake if all are zero, or if it is empty. Tangents and
    /// derivatives ignore it.
    pub sleep: DVector<T>,
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl<T: Scalar> State<T> {
    /// From slices, without a contact state and without activations.
    ///
    /// # Examples
    /// ```
    /// use dualbody::State;
    ///
    /// let state = State::new(&[0.5, -0.7], &[0.0, 0.0]);
    /// assert_eq!(state.q[1], -0.7);
    /// ```
    pub fn new(q: &[T], v: &[T]) -> Self {
        Self {
            q: DVector::from_column_slice(q),
            v: DVector::from_column_slice(v),
            contact: DVector::zeros(0),
            activation: DVector::zeros(0),
            sleep: DVector::zeros(0),
        }
    }

    /// Replaces the contact state. For a simulator with contacts, [`Simulator::state`](super::Simulator::state)
    /// makes a state whose bristles are straight.
    #[must_use]
    pub fn with_contact(mut self, contact: DVector<T>) -> Self {
        self.contact = contact;
        self
    }

    /// Replaces the activations of inputs. For a simulator that has some, [`Simulator::state`](super::Simulator::state) makes a state in which they are 0.
    #[must_use]
    pub fn with_activation(mut self, activation: DVector<T>) -> Self {
        self.activation = activation;
        self
    }

    /// The numbers beside q: v, the state of contact, activations.
    pub(crate) fn beside_q(&self) -> impl Iterator<Item = &T> + Clone {
        self.v.iter().chain(&self.contact).chain(&self.activation)
    }

    /// [`beside_q`](Self::beside_q), to be changed.
    pub(crate) fn beside_q_mut(&mut self) -> impl Iterator<Item = &mut T> {
        let (v, contact) = (self.v.iter_mut(), self.contact.iter_mut());
        v.chain(contact).chain(&mut self.activation)
    }

    /// Takes the numbers of another state of the same robot; does not allocate.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.q.copy_from(&other.q);
        self.v.copy_from(&other.v);
        self.contact.copy_from(&other.contact);
        self.activation.copy_from(&other.activation);
        self.copy_sleep_from(other);
    }

    /// Takes what sleeps from another state of the same robot; does not allocate where both know it.
    pub(crate) fn copy_sleep_from(&mut self, other: &Self) {
        if self.sleep.len() == other.sleep.len() {
            self.sleep.copy_from(&other.sleep);
        } else {
            self.sleep.clone_from(&other.sleep);
        }
    }

    /// The neutral configuration at rest.
    pub fn neutral<P: Scalar>(model: &Model<P>) -> Self {
        Self {
            q: model.neutral().map(T::constant),
            v: DVector::zeros(model.nv()),
            contact: DVector::zeros(0),
            activation: DVector::zeros(0),
            sleep: DVector::zeros(0),
        }
    }

    /// The deviation δx = (q ⊖ q₀, v − v₀, m − m₀, w − w₀) from a reference state in tangent coordinates, length 2 `nv`, the state of
    /// contact m and activations w: what a linear controller designed at the reference acts on. Allocates.
    ///
    /// # Panics
    /// If a state has the wrong length.
    pub fn deviation<P: Scalar>(&self, model: &Model<P>, reference: &Self) -> DVector<T> {
        let nv = model.nv();
        model.check_v(self.v.as_slice());
        model.check_v(reference.v.as_slice());
        assert_eq!(
            self.contact.len(),
            reference.contact.len(),
            "lengths of the contact states: the two states belong to different simulators"
        );
        assert_eq!(
            self.activation.len(),
            reference.activation.len(),
            "lengths of the activations: the two states belong to different simulators"
        );
        let mut out = DVector::zeros(nv + self.beside_q().count());
        let (dq, rest) = out.as_mut_slice().split_at_mut(nv);
        model.difference_into(reference.q.as_slice(), self.q.as_slice(), dq);
        let both = self.beside_q().zip(reference.beside_q());
        for (out, (&x, &x0)) in rest.iter_mut().zip(both) {
            *out = x - x0;
        }
        out
    }

    /// The state x ⊕ δx to which a tangent δx = (δq, δv, δm, δw) leads, whose [deviation](Self::deviation) from here is δx. Allocates.
    ///
    /// # Panics
    /// If the state or the tangent has the wrong length.
    pub fn integrate<P: Scalar>(&self, model: &Model<P>, dx: &[T]) -> Self {
        let mut out = self.clone();
        self.integrate_into(model, dx, &mut out);
        out
    }

    /// [`integrate`](Self::integrate) without allocation.
    ///
    /// # Panics
    /// If a state or the tangent has the wrong length.
    pub(crate) fn integrate_into<P: Scalar>(&self, model: &Model<P>, dx: &[T], out: &mut Self) {
        let (dq, rest) = dx.split_at(model.nv());
        model.integrate_into(self.q.as_slice(), dq, out.q.as_mut_slice());
        let numbers = self.beside_q();
        assert_eq!(
            rest.len(),
            numbers.clone().count(),
            "the tangent of a state"
        );
        for (out, (&x, &dx)) in out.beside_q_mut().zip(numbers.zip(rest)) {
            *out = x + dx;
        }
        out.copy_sleep_from(self);
    }

    /// All numbers: q, then v, then the contact state, then activations, then what sleeps.
    pub fn numbers(&self) -> impl Iterator<Item = &T> {
        self.q.iter().chain(self.beside_q()).chain(&self.sleep)
    }

    /// All numbers, to be changed: q, then v, then the contact state, then activations, then what sleeps.
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut T> {
        let (v, contact) = (self.v.iter_mut(), self.contact.iter_mut());
        let others = v.chain(contact).chain(&mut self.activation);
        self.q.iter_mut().chain(others).chain(&mut self.sleep)
    }

    /// Number of entries of q, v, the contact state, activations and what sleeps.
    pub fn len(&self) -> usize {
        let beside = self.contact.len() + self.activation.len() + self.sleep.len();
        self.q.len() + self.v.len() + beside
    }

    /// Takes over all numbers from a slice (q, v, contact state, activations, what sleeps).
    ///
    /// # Panics
    /// If there are not as many.
    pub fn copy_from_slice(&mut self, numbers: &[T]) {
        assert_eq!(numbers.len(), self.len(), "the numbers of a state");
        self.numbers_mut()
            .zip(numbers)
            .for_each(|(own, &given)| *own = given);
    }

    /// Writes all numbers to a slice (q, v, contact state, activations, what sleeps).
    ///
    /// # Panics
    /// If there are not as many.
    pub fn copy_to_slice(&self, numbers: &mut [T]) {
        assert_eq!(numbers.len(), self.len(), "the numbers of a state");
        numbers
            .iter_mut()
            .zip(self.numbers())
            .for_each(|(out, &own)| *out = own);
    }
}

impl<P: Scalar> Cast<P> for State<P> {
    type To<Q: Scalar> = State<Q>;

    fn cast<Q: Over<P>>(&self) -> State<Q> {
        State {
            q: self.q.map(<Q as From<P>>::from),
            v: self.v.map(<Q as From<P>>::from),
            contact: self.contact.map(<Q as From<P>>::from),
            activation: self.activation.map(<Q as From<P>>::from),
            sleep: self.sleep.map(<Q as From<P>>::from),
        }
    }
}

impl State<f64> {
    /// `true` if all entries are finite.
    pub fn is_finite(&self) -> bool {
        self.numbers().all(|x| x.is_finite())
    }

    /// Checks that the state is valid for the robot: correct lengths, all entries finite, quaternions of unit norm (to 1e-6, which single precision
    /// satisfies). For states from files, networks and other engines. Joint limits are not checked.
    ///
    /// # Errors
    /// The first defect, with its joint.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::samples};
    ///
    /// let error = State::new(&[0.0, f64::NAN], &[0.0; 2]).check(&samples::cartpole()).unwrap_err();
    /// assert_eq!(error.to_string(), "q[1], of joint \"pivot\", is NaN");
    /// ```
    pub fn check<P: Scalar>(&self, model: &Model<P>) -> Result<(), InvalidState> {
        check_length(model, "q", &self.q, model.nq())?;
        check_length(model, "v", &self.v, model.nv())?;
        for (id, body) in model.independent_with_ids() {
            let joint = || joint_of(model, id);
            check_finite("q", &self.q, q_range(body), joint)?;
            check_finite("v", &self.v, v_range(body), joint)?;
            check_quaternion(body.joint, &self.q, q_range(body), joint)?;
        }
        let first = |x: &DVector<f64>| x.iter().position(|x| !x.is_finite());
        if let Some(index) = first(&self.contact) {
            let value = self.contact[index];
            return Err(InvalidState::NonFiniteContact { index, value });
        }
        match first(&self.activation) {
            None => Ok(()),
            Some(index) => Err(InvalidState::NonFiniteActivation {
                index,
                value: self.activation[index],
            }),
        }
    }
}

/// Tolerance on the norm of a quaternion, as a distance from one: above the rounding of single precision, below a slip of the pen.
const NORM_TOLERANCE: f64 = 1e-6;

fn check_length<P: Scalar>(
    model: &Model<P>,
    vector: &'static str,
    x: &DVector<f64>,
    expected: usize,
) -> Result<(), InvalidState> {
    let given = x.len();
    if given == expected {
        return Ok(());
    }
    Err(InvalidState::WrongLength {
        model: model.name().into(),
        vector,
        expected,
        given,
    })
}

fn check_finite(
    vector: &'static str,
    x: &DVector<f64>,
    mut range: Range<usize>,
    joint: impl Fn() -> String,
) -> Result<(), InvalidState> {
    let Some(index) = range.find(|&i| !x[i].is_finite()) else {
        return Ok(());
    };
    Err(InvalidState::NonFinite {
        vector,
        index,
        joint: joint(),
        value: x[index],
    })
}

/// Checks that a quaternion, of joints that have one, is that of a rotation.
fn check_quaternion(
    kind: JointKind,
    q: &DVector<f64>,
    range: Range<usize>,
    joint: impl Fn() -> String,
) -> Result<(), InvalidState> {
    let Some(first) = kind.quaternion() else {
        return Ok(());
    };
    let index = range.start + first;
    let norm = q.rows(index, 4).norm();
    if (norm - 1.0).abs() <= NORM_TOLERANCE {
        return Ok(());
    }
    Err(InvalidState::QuaternionNorm {
        index,
        joint: joint(),
        norm,
    })
}

/// The joint of a body, for a person.
fn joint_of<P: Scalar>(model: &Model<P>, body: BodyId) -> String {
    match model.body_joint(body) {
        None => "the floating base".into(),
        Some(joint) => format!("joint \"{}\"", model.joints()[joint.0].name),
    }
}

impl State<f64> {
    /// A random state: the configuration as in [`Model::random_configuration`], the velocity as in [`Model::random_velocity`].
    ///
    /// # Panics
    /// If `speed` is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::samples};
    /// use rand::{SeedableRng, rngs::Xoshiro256PlusPlus};
    ///
    /// let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    /// let state = State::random(&samples::cartpole(), &mut rng, 0.5);
    /// assert!(state.q[0].abs() < 2.4 && state.v.amax() < 0.5);
    /// ```
    pub fn random<R: Rng + ?Sized>(model: &Model, rng: &mut R, speed: f64) -> Self {
        Self {
            q: model.random_configuration(rng),
            v: model.random_velocity(rng, speed),
            contact: DVector::zeros(0),
            activation: DVector::zeros(0),
            sleep: DVector::zeros(0),
        }
    }
}
