//! Distances of links from each other and from obstacles.

use std::sync::Arc;

use crate::contact::{LinkShapes, Nearest, NearestError};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::{FrameId, Model};
use crate::scalar::Scalar;
use crate::trajopt::activation::Activation;
use crate::trajopt::constraint::Constraint;
use crate::trajopt::residual::{Dependence, Node, Residual, ResidualJacobian, compiled_here};

/// Distances of pairs of links by their collision shapes, m: for collision and self-collision avoidance.
///
/// An obstacle is also a link, for example of a fixed object of a [`World`](crate::World). If links overlap, the distance is negative, so a solver
/// can separate them. There is one entry per pair, in the order of the pairs; with [samples between nodes](Self::with_samples_between) the same
/// number again for each sample. NaN if a coordinate is not finite. Evaluation allocates.
///
/// The derivative is exact while the nearest features stay the same. Where they change, it is that of one side, for example where a corner passes over an edge. Shapes with
/// [smoothing](LinkShapes::with_smoothing) have continuous derivatives of all orders there.
///
/// # Examples
/// ```
/// use dualbody::contact::LinkShapes;
/// use dualbody::model::{Mass, Object, World};
/// use dualbody::trajopt::LinkDistances;
/// use dualbody::{Simulator, spatial::Transform};
///
/// let mut world = World::default();
/// world.add_sphere("ball", 0.1, &Object::free(Mass::Kilograms(1.0)))?;
/// let at = Transform::from_translation([1.0, 0.0, 0.0].into());
/// world.add_box("wall", [0.1, 1.0, 1.0], &Object::fixed().at(at))?;
/// let simulator = Simulator::new(world.build()?);
/// let shapes = LinkShapes::without_meshes(simulator.model());
/// let clear = LinkDistances::new(simulator.model(), shapes, &[["ball", "wall"]])?;
/// let clear = clear.with_samples_between(3).at_least(0.05); // for Problem::with_constraint
/// # let _ = clear;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LinkDistances {
    shapes: Arc<LinkShapes>,
    pairs: Vec<[FrameId; 2]>,
    between: usize,
}

impl LinkDistances {
    /// Makes the distances of pairs of links, by name.
    ///
    /// # Errors
    /// If the model has no such link, or one has no collision shape, or one that is [missing](LinkShapes::missing).
    ///
    /// # Panics
    /// If the shapes are those of another robot.
    pub fn new(
        model: &Model,
        shapes: impl Into<Arc<LinkShapes>>,
        pairs: &[[&str; 2]],
    ) -> Result<Self, NearestError> {
        let shapes = shapes.into();
        let pairs = pairs
            .iter()
            .map(|[first, second]| shapes.find_pair(model, first, second));
        Ok(Self {
            pairs: pairs.collect::<Result<_, _>>()?,
            shapes,
            between: 0,
        })
    }

    /// Makes the distances of all pairs of links that [may touch](LinkShapes::may_touch); [`LinkShapes::exclude`] removes pairs.
    pub fn all(shapes: impl Into<Arc<LinkShapes>>) -> Self {
        let shapes = shapes.into();
        let mut pairs = Vec::new();
        for (j, second) in shapes.shapes().iter().enumerate() {
            for (i, first) in shapes.shapes()[..j].iter().enumerate() {
                let pair = [first.link, second.link];
                if shapes.may_touch(i, j) && !pairs.contains(&pair) {
                    pairs.push(pair);
                }
            }
        }
        Self {
            shapes,
            pairs,
            between: 0,
        }
    }

    /// Adds `samples` configurations between a node and the previous one, evenly spaced: q ⊕ (−s v) with the velocity of the node and s up to its
    /// time step. So the interval before the last node needs its own constraint at the end of the horizon. With joints of one axis and semi-implicit
    /// Euler or implicit velocity, the samples are exactly on the path from node to node; for other integrators, and for rotating free bodies, they
    /// deviate by about ½ a dt². At stage 0 there is no previous node, and all samples equal the start.
    ///
    /// Between two samples a distance can be smaller than at both, by at most half the relative path of the links' points between them: ½ ‖v‖ dt /
    /// (samples + 1) with the maximum relative speed ‖v‖. If this is added to the bound, the links are clear throughout.
    #[must_use]
    pub fn with_samples_between(mut self, samples: usize) -> Self {
        self.between = samples;
        self
    }

    /// The constraint that all distances are at least `distance`, m; see [`Problem::with_constraint`](crate::trajopt::Problem::with_constraint).
    ///
    /// # Panics
    /// If `distance` is NaN.
    pub fn at_least(self, distance: f64) -> Constraint {
        let (lower, upper) = self.bounds(distance);
        Constraint::within(self, &lower, &upper)
    }

    /// The soft form of [`at_least`](Self::at_least): ½ the sum of squared shortfalls, for [`Cost::with`](crate::trajopt::Cost::with).
    ///
    /// # Panics
    /// If `distance` is NaN.
    pub fn barrier(self, distance: f64) -> (Activation, Self) {
        let (lower, upper) = self.bounds(distance);
        (Activation::barrier(&lower, &upper), self)
    }

    fn entries(&self) -> usize {
        self.pairs.len() * (self.between + 1)
    }

    fn bounds(&self, distance: f64) -> (Vec<f64>, Vec<f64>) {
        let n = self.entries();
        (vec![distance; n], vec![f64::INFINITY; n])
    }

    /// Passes the configurations of a node to `each(number, s, kinematics)`: that at s = 0, then those before it.
    fn each_configuration<T: Scalar>(
        &self,
        node: &Node<'_, T>,
        x: &[T],
        mut each: impl FnMut(usize, f64, &Kinematics<T>),
    ) {
        let model = node.model();
        let (q, v) = (&x[..model.nq()], &x[model.nq()..]);
        let (mut dv, mut before) = (vec![T::zero(); model.nv()], q.to_vec());
        let at_rest = dv.clone();
        let mut kinematics = Kinematics::new(model);
        for k in 0..=self.between {
            let s = self.time_before(node, k);
            if k > 0 {
                let back = dv.iter_mut().zip(v);
                back.for_each(|(dv, &v)| *dv = v * -s);
                model.integrate_into(q, &dv, &mut before);
            }
            forward_kinematics_into(model, &before, &at_rest, &mut kinematics);
            each(k, s, &kinematics);
        }
    }

    /// Time of a sample before its node, s.
    fn time_before<T: Scalar>(&self, node: &Node<'_, T>, sample: usize) -> f64 {
        match node.stage {
            0 => 0.0,
            _ => node.dynamics.time_step() * sample as f64 / (self.between + 1) as f64,
        }
    }
}

/// # Panics
/// If the shapes are those of another robot, or on a scalar that [records](crate::scalar::Traced): which features are nearest is decided on values.
impl Residual for LinkDistances {
    compiled_here!();

    fn dim(&self, _: &Node<'_>) -> usize {
        self.entries()
    }

    fn depends_on(&self) -> Dependence {
        match self.between {
            0 => Dependence::Configuration,
            _ => Dependence::State,
        }
    }

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        assert!(
            T::HAS_VALUES && T::LANES == 1,
            "distances of links cannot be recorded: which features are nearest is decided on values"
        );
        self.shapes.check(node.model());
        self.each_configuration(node, x, |k, _, kinematics| {
            let rows = r.iter_mut().skip(k * self.pairs.len());
            for (r, &pair) in rows.zip(&self.pairs) {
                let distance = self.shapes.distance(kinematics, pair);
                *r = distance.unwrap_or(T::constant(f64::NAN));
            }
        });
    }

    /// n · (J₂ − J₁), without dual numbers where the joints turn or slide about one axis.
    fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        if self.between > 0 && !node.dynamics.is_vector_space() {
            out.fill_by_duals(self, node, x, u);
            return;
        }
        let model = node.model();
        let (nv, mut near) = (model.nv(), Nearest::new(model));
        self.each_configuration(node, x, |k, s, kinematics| {
            for (i, &pair) in self.pairs.iter().enumerate() {
                let entry = k * self.pairs.len() + i;
                let found = self.shapes.nearest_into(model, kinematics, pair, &mut near);
                out.values[entry] = if found { near.distance } else { f64::NAN };
                let (by_q, rest) = out.row_mut(entry).split_at_mut(nv);
                by_q.copy_from_slice(near.gradient.as_slice());
                if s > 0.0 {
                    let by_v = rest.iter_mut().zip(&near.gradient);
                    by_v.for_each(|(out, g)| *out = -s * g);
                }
            }
        });
    }
}
