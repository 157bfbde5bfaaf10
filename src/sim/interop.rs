//! States, tangent vectors, Jacobians and mass matrices in the coordinates of other engines.
//!
//! Configurations differ in the order of joints and in the format of angles and quaternions. Rates differ in order and in the axes of some linear and
//! angular parts, so an orthogonal matrix relates them, `v' = T(q) v`. As T is orthogonal, forces, gradients and displacements transform like
//! velocities; Jacobians by `J' = J Tᵀ`, mass matrices by `M' = T M Tᵀ`, accelerations by `a' = T a + Ṫ v`.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Vector3};

use super::free_body::is_free;
use super::free_body::write_pose;
use super::state::State;
use crate::error::UnknownName;
use crate::joint::{Joint, JointKind};
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, BodyId, JointId, Model};
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// The engine whose coordinates are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Engine {
    /// Quaternions (x, y, z, w); continuous joints and the angle of planar joints as (cos, sin); velocities as in this library.
    Pinocchio,
    /// Quaternions (w, x, y, z); the linear velocity of a floating base in the world, its angular velocity in the base. The configuration of a
    /// floating joint on the world is its pose in the world, not relative to the placement of the joint. A planar joint is two slides and a hinge.
    MuJoCo,
    /// Quaternions (w, x, y, z); base velocity in the mixed representation, linear first.
    JaxSim,
}

/// Conversion between the coordinates of this library and those of another engine, for one robot.
///
/// Functions named `…_to` convert from the coordinates of this library, `…_from` from those of the engine. An argument `q` beside the converted value
/// is always a configuration of this library ([`configuration_from`](Self::configuration_from) computes it). All functions allocate.
///
/// # Limitations
/// Mimic joints have no coordinates, as in this library (and in Pinocchio with `mimic=True`); engines that model them as joints with a constraint
/// have more coordinates. The contact state of a [`Simulator`](crate::Simulator) is not converted.
///
/// # Examples
/// ```
/// use dualbody::sim::{Engine, EngineCoordinates};
/// use dualbody::{dynamics, model::samples};
///
/// let model = samples::cartpole();
/// let theirs = EngineCoordinates::new(&model, Engine::Pinocchio)
///     .with_joint_order(&["universe", "pivot", "linear"])?; // pin_model.names
/// let q = [0.3, 0.5];
/// let (ours, T) = (dynamics::mass_matrix(&model, &q), theirs.tangent_map(&q));
/// let M = &T * &ours * T.transpose();
/// assert_eq!((M[(0, 0)], M[(1, 1)]), (ours[(1, 1)], ours[(0, 0)]));
/// assert_eq!(theirs.configuration_to(&q).len(), 3); // cos and sin of the pivot, then the slide
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug)]
pub struct EngineCoordinates<'m> {
    model: &'m Model,
    engine: Engine,
    /// The bodies whose joints have coordinates, in the order of the engine.
    order: Vec<BodyId>,
}

impl<'m> EngineCoordinates<'m> {
    /// The coordinates of an engine, with joints in the order of the model.
    pub fn new(model: &'m Model, engine: Engine) -> Self {
        Self {
            model,
            engine,
            order: model.independent_with_ids().map(|(id, _)| id).collect(),
        }
    }

    /// Puts joints in the engine's order; a floating base comes first.
    ///
    /// * `names` – names of joints in the order of the engine (`model.names` of Pinocchio); mimic joints, and names that this model does not have,
    ///   such as an engine's own base, are skipped
    ///
    /// # Errors
    /// If a joint with coordinates is missing in the names.
    pub fn with_joint_order<S: AsRef<str>>(mut self, names: &[S]) -> Result<Self, UnknownName> {
        let position: HashMap<&str, usize> = (names.iter().enumerate().rev())
            .map(|(i, name)| (name.as_ref(), i))
            .collect();
        let mut placed = Vec::with_capacity(self.order.len());
        for &body in &self.order {
            let place = match self.model.body_joint(body) {
                None => None,
                Some(joint) => Some(find(
                    &position,
                    &self.model.joints()[joint.0].name,
                    self.engine,
                )?),
            };
            placed.push((place, body));
        }
        // The base has no index; it comes before all joints.
        placed.sort_by_key(|&(place, _)| place);
        self.order = placed.into_iter().map(|(_, body)| body).collect();
        Ok(self)
    }

    /// Number of the engine's configuration coordinates.
    pub fn nq(&self) -> usize {
        self.bodies()
            .map(|body| width(self.engine, body.joint))
            .sum()
    }

    /// Range of a joint's coordinates in the engine's configuration; for a mimic joint those of its leader.
    ///
    /// # Panics
    /// If the id is not one of the model.
    pub fn joint_q(&self, joint: JointId) -> Range<usize> {
        self.place(joint, |body| width(self.engine, body.joint))
    }

    /// Range of a joint's coordinates in the engine's tangent vectors; for a mimic joint those of its leader.
    ///
    /// # Panics
    /// If the id is not one of the model.
    pub fn joint_v(&self, joint: JointId) -> Range<usize> {
        self.place(joint, |body| body.joint.nv())
    }

    /// Converts a configuration to the engine's coordinates, length [`nq`](Self::nq).
    ///
    /// # Panics
    /// If `q` has the wrong length.
    pub fn configuration_to(&self, q: &[f64]) -> DVector<f64> {
        self.model.check_q(q);
        let own = self.bodies().nested(|body| {
            let q = &q[q_range(body)];
            let moved = self.placed(body).map(|X_WJ| moved(X_WJ, q));
            configuration_to(self.engine, body.joint, moved.as_deref().unwrap_or(q))
        });
        DVector::from_vec(own.collect())
    }

    /// Converts a configuration from the engine's coordinates. Angles given as (cos, sin) become angles in (−π, π].
    ///
    /// # Panics
    /// If `q` does not have length [`nq`](Self::nq).
    pub fn configuration_from(&self, q: &[f64]) -> DVector<f64> {
        let (name, nq) = (self.model.name(), self.nq());
        assert_eq!(
            q.len(),
            nq,
            "{:?} has {nq} configuration coordinates for \"{name}\"",
            self.engine
        );
        let (mut out, mut rest) = (self.model.neutral(), q);
        for body in self.bodies() {
            let own;
            (own, rest) = rest.split_at(width(self.engine, body.joint));
            let mut own = configuration_from(self.engine, body.joint, own);
            if let Some(X_WJ) = self.placed(body) {
                own = moved(&X_WJ.inverse(), &own);
            }
            out.as_mut_slice()[q_range(body)].copy_from_slice(&own);
        }
        out
    }

    /// Configuration and velocity in the engine's coordinates.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn state_to(&self, state: &State<f64>) -> (DVector<f64>, DVector<f64>) {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        (self.configuration_to(q), self.tangent_to(q, v))
    }

    /// The state of the engine's configuration and velocity.
    ///
    /// # Panics
    /// If `q` does not have length [`nq`](Self::nq), or `v` not the length `nv`.
    pub fn state_from(&self, q: &[f64], v: &[f64]) -> State<f64> {
        let q = self.configuration_from(q);
        let v = self.tangent_from(q.as_slice(), v);
        State::new(q.as_slice(), v.as_slice())
    }

    /// A velocity, force, gradient or small displacement in the engine's coordinates:  v' = T v.
    ///
    /// # Panics
    /// If `q` or `v` have the wrong length.
    pub fn tangent_to(&self, q: &[f64], v: &[f64]) -> DVector<f64> {
        self.model.check_v(v);
        self.tangent_map(q) * DVector::from_column_slice(v)
    }

    /// A velocity, force, gradient or small displacement from the engine's coordinates:  v = Tᵀ v'.
    ///
    /// # Panics
    /// If `q` or `v` have the wrong length.
    pub fn tangent_from(&self, q: &[f64], v: &[f64]) -> DVector<f64> {
        self.model.check_v(v);
        self.tangent_map(q).tr_mul(&DVector::from_column_slice(v))
    }

    /// An acceleration in the engine's coordinates, the rate of the velocity there:  a' = T a + Ṫ v.
    ///
    /// * `v`, `a` – velocity and acceleration in this library's coordinates
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn acceleration_to(&self, q: &[f64], v: &[f64], a: &[f64]) -> DVector<f64> {
        self.model.check_v(a);
        self.tangent_to(
            q,
            (DVector::from_column_slice(a) + self.turning(v)).as_slice(),
        )
    }

    /// An acceleration from the engine's coordinates.
    ///
    /// * `v` – velocity in this library's coordinates
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn acceleration_from(&self, q: &[f64], v: &[f64], a: &[f64]) -> DVector<f64> {
        self.tangent_from(q, a) - self.turning(v)
    }

    /// Where a floating joint is placed on the world, for an engine whose free joints have the pose in the world.
    fn placed(&self, body: &'m Body<f64>) -> Option<&'m Transform<f64>> {
        let moves = self.engine == Engine::MuJoCo
            && is_free(body)
            && body.placement != Transform::identity();
        moves.then_some(&body.placement)
    }

    /// The bodies with coordinates, in the engine's order.
    fn bodies(&self) -> impl Iterator<Item = &'m Body<f64>> {
        self.order.iter().map(|&body| self.model.body(body))
    }

    fn place(&self, joint: JointId, width: impl Fn(&Body<f64>) -> usize) -> Range<usize> {
        let v = self.model.joint_v(joint);
        let before = self.bodies().take_while(|body| !v.contains(&body.v));
        let start = before.map(&width).sum();
        let own = self.bodies().filter(|body| v.contains(&body.v));
        start..start + own.map(width).sum::<usize>()
    }

    /// The orthogonal matrix T from tangent vectors of this library to those of the engine, v' = T v, for matrices: a Jacobian is J' = J Tᵀ, a mass
    /// matrix or its inverse M' = T M Tᵀ. Allocates.
    ///
    /// # Panics
    /// If `q` has the wrong length.
    pub fn tangent_map(&self, q: &[f64]) -> DMatrix<f64> {
        self.model.check_q(q);
        let nv = self.model.nv();
        let (mut T, mut row) = (DMatrix::zeros(nv, nv), 0);
        for body in self.bodies() {
            let n = body.joint.nv();
            let q = &q[q_range(body)];
            let moved = self.placed(body).map(|X_WJ| moved(X_WJ, q));
            let axes = axes(self.engine, body.joint, moved.as_deref().unwrap_or(q));
            T.view_mut((row, body.v), (n, n)).copy_from(&axes);
            row += n;
        }
        T
    }

    /// Tᵀ Ṫ v: for linear velocities in axes that do not rotate with the body, ω × v.
    fn turning(&self, v: &[f64]) -> DVector<f64> {
        self.model.check_v(v);
        let mut out = DVector::zeros(v.len());
        if self.engine == Engine::Pinocchio {
            return out;
        }
        for body in self.bodies() {
            let own = &v[v_range(body)];
            let turn = |k, x| out[body.v + k] = x;
            body.joint.turning(&Vector3::zeros(), own, turn);
        }
        out
    }
}

/// Position of a name in an engine's list.
fn find(position: &HashMap<&str, usize>, name: &str, engine: Engine) -> Result<usize, UnknownName> {
    position.get(name).copied().ok_or_else(|| {
        let mut known: Vec<(usize, &str)> = position.iter().map(|(name, &i)| (i, *name)).collect();
        known.sort_unstable();
        UnknownName {
            model: format!("of {engine:?}"),
            element: "joint".into(),
            name: name.into(),
            known: known.into_iter().map(|(_, name)| name.to_owned()).collect(),
        }
    })
}

/// The configuration of a floating joint moved by a pose before it.
fn moved(X_WJ: &Transform<f64>, q: &[f64]) -> Vec<f64> {
    let mut out = q.to_vec();
    write_pose(&mut out, &(*X_WJ * JointKind::Floating.transform(q)));
    out
}

/// Number of configuration coordinates that the engine has for a joint.
fn width(engine: Engine, joint: JointKind) -> usize {
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous | JointKind::Planar) => joint.nq() + 1,
        _ => joint.nq(),
    }
}

fn configuration_to(engine: Engine, joint: JointKind, q: &[f64]) -> Vec<f64> {
    let split = |at: usize| [&q[..at], &[q[at].cos(), q[at].sin()]].concat();
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous) => split(0),
        (Engine::Pinocchio, JointKind::Planar) => split(2),
        (Engine::Pinocchio, _) => with_quaternion(joint, q, |quaternion| quaternion.rotate_left(1)),
        _ => q.to_vec(),
    }
}

fn configuration_from(engine: Engine, joint: JointKind, q: &[f64]) -> Vec<f64> {
    let join = |at: usize| [&q[..at], &[q[at + 1].atan2(q[at])]].concat();
    match (engine, joint) {
        (Engine::Pinocchio, JointKind::Continuous) => join(0),
        (Engine::Pinocchio, JointKind::Planar) => join(2),
        (Engine::Pinocchio, _) => {
            with_quaternion(joint, q, |quaternion| quaternion.rotate_right(1))
        }
        _ => q.to_vec(),
    }
}

/// A configuration with its quaternion, if it has one, in another order.
fn with_quaternion(joint: JointKind, q: &[f64], order: impl Fn(&mut [f64])) -> Vec<f64> {
    let mut out = q.to_vec();
    if let Some(first) = joint.quaternion() {
        order(&mut out[first..first + 4]);
    }
    out
}

/// The matrix that takes the rates of a joint to those of the engine, some of which are given in the axes of the parent (for a floating base: of
/// the world).
fn axes(engine: Engine, joint: JointKind, q: &[f64]) -> DMatrix<f64> {
    let mut T = DMatrix::identity(joint.nv(), joint.nv());
    if engine == Engine::Pinocchio || !joint.turns_with_body() {
        return T;
    }
    let R = joint.transform(q).rotation;
    let n = joint.axes().filter(|axis| !axis.is_angular()).count();
    T.view_mut((0, 0), (n, n))
        .copy_from(&R.view((0, 0), (n, n)));
    if engine == Engine::JaxSim && joint == JointKind::Floating {
        T.view_mut((3, 3), (3, 3)).copy_from(&R);
    }
    T
}

#[cfg(test)]
mod literals;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{inverse_dynamics, mass_matrix};
    use crate::model::samples;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    const ENGINES: [Engine; 3] = [Engine::Pinocchio, Engine::MuJoCo, Engine::JaxSim];

    fn models() -> Vec<Model> {
        let mut models: Vec<Model> = (0..4).map(|seed| samples::random_tree(9, seed)).collect();
        models.push(samples::random_tree_of(
            &[JointKind::Planar, JointKind::Floating],
            4,
            1,
        ));
        models.push(Model::from_urdf_file("assets/quadruped.urdf").unwrap());
        models.push(Model::from_urdf_file("assets/panda.urdf").unwrap());
        models
    }

    /// Coordinates with the joints of a model backwards.
    fn reversed(model: &Model, engine: Engine) -> EngineCoordinates<'_> {
        let mut names = model.joint_names();
        names.reverse();
        EngineCoordinates::new(model, engine)
            .with_joint_order(&names)
            .unwrap()
    }

    fn each(mut check: impl FnMut(&Model, &EngineCoordinates<'_>, [DVector<f64>; 3], &str)) {
        for model in &models() {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
            for engine in ENGINES {
                let at = [
                    model.random_configuration(&mut rng),
                    model.random_velocity(&mut rng, 1.0),
                    model.random_velocity(&mut rng, 1.0),
                ];
                check(
                    model,
                    &reversed(model, engine),
                    at,
                    &format!("{} for {engine:?}", model.name()),
                );
            }
        }
    }

    // Power τᵀ v, energy vᵀ M v and J v are the same in all coordinates.
    #[test]
    fn power_energy_and_outputs_equal_those_in_the_engines_coordinates() {
        each(|model, theirs, [q, v, a], name| {
            let (q, M) = (q.as_slice(), mass_matrix(model, q.as_slice()));
            let tau = inverse_dynamics(model, q, v.as_slice(), a.as_slice());
            let to = |x: &DVector<f64>| theirs.tangent_to(q, x.as_slice());
            let power = to(&tau).dot(&to(&v)) - tau.dot(&v);
            let T = theirs.tangent_map(q);
            let M_there = &T * &M * T.transpose();
            let energy = to(&v).dot(&(M_there * to(&v))) - v.dot(&(&M * &v));
            let J = DMatrix::from_fn(2, model.nv(), |i, k| (i as f64 + 1.3 * k as f64).sin());
            let output = &J * T.transpose() * to(&v) - &J * &v;
            let scale = 1e-12 * (M.amax() + tau.amax()) * model.nv() as f64;
            assert!(
                power.abs() < scale && energy.abs() < scale && output.amax() < scale,
                "{name}"
            );
        });
    }

    #[test]
    fn way_back_inverts_the_way_there() {
        each(|model, theirs, [q, v, a], name| {
            let state = State::new(q.as_slice(), v.as_slice());
            let (their_q, their_v) = theirs.state_to(&state);
            assert_eq!(their_q.len(), theirs.nq());
            let back = theirs.state_from(their_q.as_slice(), their_v.as_slice());
            assert!(
                model.difference(back.q.as_slice(), q.as_slice()).amax() < 1e-14,
                "{name}"
            );
            assert!((back.v - &v).amax() < 1e-14, "{name}");
            let (q, v) = (q.as_slice(), v.as_slice());
            let there = theirs.acceleration_to(q, v, a.as_slice());
            assert!(
                (theirs.acceleration_from(q, v, there.as_slice()) - &a).amax() < 1e-13,
                "{name}"
            );
            let T = theirs.tangent_map(q);
            let one = DMatrix::identity(model.nv(), model.nv());
            assert!((T.tr_mul(&T) - one).amax() < 1e-13, "{name}");
        });
    }

    // a' = d(T(q) v) / dt along q̇ = v, v̇ = a, by central differences.
    #[test]
    fn acceleration_equals_the_rate_of_the_velocity() {
        const H: f64 = 1e-5;
        each(|model, theirs, [q, v, a], name| {
            let at = |t: f64| {
                let q = model.integrate(q.as_slice(), (&v * t + &a * (0.5 * t * t)).as_slice());
                theirs.tangent_to(q.as_slice(), (&v + &a * t).as_slice())
            };
            let rate = (at(H) - at(-H)) / (2.0 * H);
            let found = theirs.acceleration_to(q.as_slice(), v.as_slice(), a.as_slice());
            assert!((&found - &rate).amax() < 1e-8, "{name}: {found} {rate}");
        });
    }

    #[test]
    fn joints_stand_where_the_given_order_puts_them() {
        let model = samples::cartpole();
        let theirs = EngineCoordinates::new(&model, Engine::Pinocchio);
        let linear = model.joint("linear").unwrap();
        assert_eq!(
            (theirs.joint_q(linear), theirs.joint_v(linear)),
            (0..1, 0..1)
        );
        let theirs = theirs
            .with_joint_order(&["universe", "pivot", "linear"])
            .unwrap();
        assert_eq!(
            (theirs.joint_q(linear), theirs.joint_v(linear)),
            (2..3, 1..2)
        );
        assert_eq!(
            theirs.tangent_to(&[0.1, 0.2], &[1.0, 2.0]).as_slice(),
            [2.0, 1.0]
        );
        let error = theirs.with_joint_order(&["pivot", "slide"]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "model \"of Pinocchio\" has no joint \"linear\"; it has: pivot, slide"
        );
    }
}
