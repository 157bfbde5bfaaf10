//! Distances of links as a soft minimum over near features, smooth where these switch.

use super::link_shapes::{LinkShape, LinkShapes};
use super::nearest::Nearest;
use super::pairs::plain_pose;
use crate::collision::{NOTHING, PairFeature, Witness, each_rounded, excess};
use crate::dynamics::Kinematics;
use crate::model::{FrameId, Model};
use crate::numbers::Domain;
use crate::scalar::{MapEach, Scalar};

/// Least and largest width, m: squares of both, and of their inverses, are finite.
const LEAST: f64 = 1e-100;
const LARGEST: f64 = 1e100;

impl LinkShapes {
    /// Makes distances smooth where nearest features switch: a soft minimum of width w (m) over the vertices, edges and faces that are near, and over the
    /// shapes of both links. Distances, gradients and Hessians of [`nearest`](Self::nearest), [`nearest_into`](Self::nearest_into) and
    /// [`LinkDistances`](crate::trajopt::LinkDistances) are then continuous, for example where a corner passes over an edge. 0 is the exact distance.
    ///
    /// Of N pairs of shapes with distances dᵢ the distance is −w ln Σ exp(−dᵢ / w), at most w ln N below the smallest. Each shape is rounded by the same rule,
    /// with the support function w ln Σ exp(n · vₖ / w) over its vertices vₖ. So the distance never exceeds the exact one, and is lower by at most w times the sum of
    ///
    /// | part | widths |
    /// |---|---|
    /// | N pairs of shapes | ln N |
    /// | each box, mesh of n vertices | ln 8, ln n |
    /// | each capsule, cylinder, ellipsoid | ln 2, 1 + ln 2, 1 |
    /// | sphere, half-space | 0 |
    /// | [distance field](crate::collision::Shape::Field) against n points of the other shape | ln n, in place of that shape |
    ///
    /// Where two shapes overlap, the distance is that of the separating translation of the rounded shapes which continues the shortest one. If the shortest one switches to
    /// another face, as at the centre of a box, value and gradient still jump, the value by at most the bound above. Contact forces do not use this width.
    ///
    /// Rounded shapes have no closed form: a distance takes some steps of Newton's method. A width below 1e-100 m counts as 0, one above 1e100 m as that.
    ///
    /// # Panics
    /// If the width is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, contact::LinkShapes};
    ///
    /// // Over the middle of a table: two edges of the box are equally near.
    /// let model = Model::from_urdf_str(r#"<robot name="flap">
    ///   <link name="world"><collision><origin xyz="0 0 -0.6"/><geometry><box size="2 2 0.2"/></geometry></collision></link>
    ///   <link name="box"><collision><geometry><box size="0.4 0.2 0.2"/></geometry></collision>
    ///     <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ///   <joint name="turn" type="continuous"><parent link="world"/><child link="box"/><axis xyz="0 1 0"/></joint></robot>"#)?;
    /// let exact = LinkShapes::without_meshes(&model);
    /// let soft = exact.clone().with_smoothing(1e-3);
    /// let gradient = |shapes: &LinkShapes, q: f64| shapes.nearest(&model, &[q], "world", "box").map(|near| near.gradient[0]);
    /// assert!((gradient(&exact, 1e-6)? - gradient(&exact, -1e-6)?).abs() > 0.39); // first one edge, then the other
    /// assert!((gradient(&soft, 1e-6)? - gradient(&soft, -1e-6)?).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_smoothing(mut self, width: f64) -> Self {
        Domain::NotNegative.hold(format_args!("a width of {width} m"), width);
        self.smoothing = match width < LEAST {
            true => 0.0,
            false => width.min(LARGEST),
        };
        self
    }

    /// Passes the pairs of rounded shapes that count in the soft minimum to `each`, with their nearest features.
    ///
    /// * `least` – distance of the two nearest shapes, m
    fn each_near<T: Scalar>(
        &self,
        kinematics: &Kinematics<T>,
        links: [FrameId; 2],
        least: f64,
        mut each: impl FnMut([usize; 2], PairFeature, Witness<T>),
    ) {
        let plain = |own: &LinkShape| plain_pose(&kinematics.pose(own.body), 0) * own.placement;
        self.each_distance(links, plain, |shapes, feature, found| {
            let [a, b] = shapes.map_each(|k| &self.shapes()[k]);
            let reach = NOTHING + excess(&a.shape) + excess(&b.shape);
            if found.distance - least > reach * self.smoothing {
                return;
            }
            let both = [&a.shape, &b.shape];
            let poses = [a, b].map_each(|own| kinematics.pose(own.body) * own.placement.lift());
            let near = (feature, found);
            each_rounded(
                &near,
                both,
                &[plain(a), plain(b)],
                &poses,
                self.smoothing,
                |found| {
                    each(shapes, feature, found);
                },
            );
        });
    }

    /// The soft minimum over the scalar.
    #[cfg(feature = "trajopt")]
    pub(super) fn soft_distance<T: Scalar>(
        &self,
        kinematics: &Kinematics<T>,
        links: [FrameId; 2],
        least: f64,
    ) -> T {
        let mut soft = SoftMinimum::new(self.smoothing);
        self.each_near(kinematics, links, least, |_, _, found| {
            soft.add(found.distance);
        });
        soft.value()
    }

    /// The soft minimum with its gradient, Σ sᵢ ∇dᵢ with the shares sᵢ, and points and normal of the two shapes with the largest one.
    pub(super) fn smooth_into(
        &self,
        model: &Model,
        kinematics: &Kinematics<f64>,
        links: [FrameId; 2],
        least: f64,
        out: &mut Nearest,
    ) {
        let mut soft = SoftMinimum::<f64>::new(self.smoothing);
        self.each_near(kinematics, links, least, |shapes, feature, found| {
            if found.distance < soft.least {
                out.take(shapes, feature, &found);
            }
            let (kept, share) = soft.add(found.distance);
            out.gradient *= kept;
            self.add_gradient(
                model,
                kinematics,
                (shapes, &found),
                share,
                &mut out.gradient,
            );
        });
        out.gradient /= soft.sum;
        out.distance = soft.value();
    }
}

/// −w ln Σ exp(−dᵢ / w), from the smallest distance on, so that no exponential overflows.
struct SoftMinimum<T> {
    /// w, m.
    width: f64,
    /// The smallest distance, m, without derivatives.
    least: f64,
    /// Σ exp((least − dᵢ) / w).
    sum: T,
}

impl<T: Scalar> SoftMinimum<T> {
    fn new(width: f64) -> Self {
        Self {
            width,
            least: f64::INFINITY,
            sum: T::zero(),
        }
    }

    /// Adds a distance; returns the factor by which earlier shares shrink, and its share.
    fn add(&mut self, distance: T) -> (f64, T) {
        let mut kept = 1.0;
        if distance.value(0) < self.least {
            kept = ((distance.value(0) - self.least) / self.width).exp();
            self.least = distance.value(0);
        }
        let share = ((-distance + self.least) / self.width).exp();
        self.sum = self.sum * kept + share;
        (kept, share)
    }

    fn value(&self) -> T {
        -(self.sum.ln() * self.width) + self.least
    }
}
