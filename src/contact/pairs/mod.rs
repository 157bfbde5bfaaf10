//! Contact between bodies: the shapes that can touch each other, and where they do.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod choice;
mod finder;
mod recorded;

use nalgebra::Vector3;

pub use choice::CollisionOptions;
pub(super) use finder::plain_pose;
pub(crate) use finder::{FoundPairs, PairFinder, PairPoint};

use super::contacts::Contacts;
use super::laws::ContactLaw;
use super::link_shapes::LinkShape;
use super::material::Material;
use super::part::MaterialOf;
use super::point::velocity_at;
use super::point_state::PointState;
use super::shape_pairs::{BodyShape, MATERIAL_NUMBERS, TURNING_NUMBERS};
use super::turning::TurningFriction;
use crate::collision::{BroadPhase, PairFeature, Shape, Witness, recorded_witness, witness};
use crate::model::{BodyId, FrameId};
use crate::numbers::Numbers;
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::linear::rotate;
use crate::spatial::{Motion, Transform};

/// The triangles of surfaces, fixed to the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceTriangles<'a> {
    /// Their boxes, in the world.
    pub(crate) tree: &'a BroadPhase,
    triangles: &'a [LinkShape],
}

impl SurfaceTriangles<'_> {
    /// The corners of a triangle in the world, by the index of its box.
    pub(crate) fn corners(&self, index: usize) -> [Vector3<f64>; 3] {
        let own = &self.triangles[index];
        match &own.shape {
            Shape::Triangle { vertices } => vertices.map_each(|v| own.placement.point(&v)),
            _ => [own.placement.translation; 3],
        }
    }
}

/// A point between bodies in motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairState<T> {
    /// As a point of the first body; its normal points out of the second one, and its velocity is that of the first body less that of the second.
    pub(crate) point: PointState<T>,
    /// Position in the second body, m.
    pub(crate) in_second: Vector3<T>,
}

impl<P: Scalar> Contacts<P> {
    /// Whether bodies can touch each other.
    pub(crate) fn have_pairs(&self) -> bool {
        self.shape_pairs().plain.is_some()
    }

    /// Whether shapes that would arrive at each other within a step are met by a law that else meets overlap only.
    pub(crate) fn are_pairs_speculative(&self) -> bool {
        self.shape_pairs().speculative
    }

    /// Number of shapes that can touch each other.
    pub(crate) fn n_shapes(&self) -> usize {
        self.shape_pairs().shapes.len()
    }

    /// The triangles of surfaces; `None` without surfaces.
    pub(crate) fn surface_triangles(&self) -> Option<SurfaceTriangles<'_>> {
        let pairs = self.shape_pairs();
        let plain = pairs.plain.as_ref()?;
        let triangles = plain.shapes().get(pairs.surfaces.first..)?;
        (!triangles.is_empty()).then_some(SurfaceTriangles {
            tree: &pairs.surfaces.tree,
            triangles,
        })
    }

    /// Link of a shape that can touch others.
    pub(crate) fn shape_link(&self, shape: usize) -> FrameId {
        let plain = self.shape_pairs().plain.as_ref();
        plain.map_or(FrameId(0), |plain| plain.shapes()[shape].link)
    }

    /// The owner of the material that a pair of shapes has by one of both, whose numbers are parameters; that of the pair itself counts as by its first.
    pub(crate) fn material_by_side(&self, shapes: [usize; 2], side: usize) -> Option<MaterialOf> {
        let pairs = self.shape_pairs();
        if let Some(k) = pairs.given_place(shapes) {
            return (side == 0).then_some(MaterialOf::Pair(k));
        }
        let shape = shapes[side];
        let own = Some(MaterialOf::Shape(shape));
        own.filter(|own| self.material_counts(*own)[0] > 0)
    }

    /// Numbers of parameters of a material: friction with restitution and margin, torsional and rolling friction, compliance.
    pub(crate) fn material_counts(&self, of: MaterialOf) -> [usize; 3] {
        let pairs = self.shape_pairs();
        let material = match of {
            MaterialOf::Shape(k) => {
                let shape = &pairs.shapes[k];
                shape.material.filter(|_| shape.has_parameters())
            }
            MaterialOf::Pair(k) => Some(pairs.given[k]),
        };
        material.map_or([0; 3], |own| {
            let mut compliance = 0;
            (own.compliance.clone()).each_number(&mut |_, _| compliance += 1);
            let turning = if pairs.has.turning {
                TURNING_NUMBERS
            } else {
                0
            };
            let without = usize::from(!pairs.has.margin);
            [MATERIAL_NUMBERS - without, turning, compliance]
        })
    }

    /// Number of pairs whose materials are given.
    pub(crate) fn n_pair_materials(&self) -> usize {
        self.shape_pairs().given.len()
    }

    /// Whether some materials have a compliance.
    pub(crate) fn have_compliance(&self) -> bool {
        let pairs = self.shape_pairs();
        let materials = pairs.shapes.iter().filter_map(|own| own.material.as_ref());
        let mut all = materials.chain(&pairs.given);
        all.any(|own| own.compliance.is_some())
    }

    /// Whether the material of a pair of shapes has a compliance.
    pub(crate) fn yield_by_material(&self, shapes: [usize; 2]) -> bool {
        let pairs = self.shape_pairs();
        let material = match pairs.given_place(shapes) {
            Some(k) => return pairs.given[k].compliance.is_some(),
            None => |shape: usize| pairs.shapes[shape].material,
        };
        (shapes.into_iter().filter_map(material)).any(|own| own.compliance.is_some())
    }

    /// The given material of a pair of shapes.
    fn given_material(&self, shapes: [usize; 2]) -> Option<&Material<P>> {
        let pairs = self.shape_pairs();
        pairs.given_place(shapes).map(|k| &pairs.given[k])
    }

    /// The bodies of a pair of shapes; `None` is the world.
    pub(crate) fn pair_bodies(&self, shapes: [usize; 2]) -> [Option<BodyId>; 2] {
        shapes.map_each(|shape| self.shape_pairs().body(shape))
    }

    /// The law of a pair of shapes: that of all pairs, with the friction and restitution of their materials, if they have some.
    pub(crate) fn pair_law(&self, shapes: [usize; 2]) -> ContactLaw<P> {
        let sides = shapes.map_each(|shape| &self.shape_pairs().shapes[shape]);
        law_of_shapes(self.law_of_pairs(), sides, self.given_material(shapes))
    }

    /// [`pair_law`](Self::pair_law) with derivatives in the material of one of both shapes alone, where numbers have them.
    pub(crate) fn pair_law_by_side(&self, shapes: [usize; 2], side: usize) -> ContactLaw<P> {
        let [a, b] = self.in_one(shapes, side);
        law_of_shapes(self.law_of_pairs(), [&a, &b], self.given_material(shapes))
    }

    /// Torsional and rolling friction of a pair of shapes: that of their materials, or of all pairs.
    pub(super) fn pair_turning(&self, shapes: [usize; 2]) -> TurningFriction<P> {
        let sides = shapes.map_each(|shape| &self.shape_pairs().shapes[shape]);
        let given = self.given_material(shapes);
        turning_of_shapes(self.turning_of_pairs(), sides, given)
    }

    /// [`pair_turning`](Self::pair_turning) with derivatives in the material of one of both shapes alone, where numbers have them.
    pub(crate) fn pair_turning_by_side(
        &self,
        shapes: [usize; 2],
        side: usize,
    ) -> TurningFriction<P> {
        let [a, b] = self.in_one(shapes, side);
        let given = self.given_material(shapes);
        turning_of_shapes(self.turning_of_pairs(), [&a, &b], given)
    }

    /// Two shapes, with derivatives in numbers of one of them alone.
    fn in_one(&self, shapes: [usize; 2], side: usize) -> [BodyShape<P>; 2] {
        let mut shapes = shapes.map(|shape| self.shape_pairs().shapes[shape].clone());
        let other = &mut shapes[1 - side];
        other.shape = other.shape.map_numbers(&mut |x| x.detached());
        other.material = other.material.map_numbers(&mut |x| x.detached());
        shapes
    }

    /// Computes position and motion of a point between bodies: the midpoint of the nearest points of both shapes, where equal and opposite forces
    /// conserve angular momentum.
    ///
    /// * `X`, `V` – poses of both bodies in the world and velocities in themselves
    pub(crate) fn pair_state<T: Over<P>>(
        &self,
        point: &PairPoint,
        X: &[Transform<T>; 2],
        V: &[Motion<T>; 2],
    ) -> PairState<T> {
        let shapes = point
            .shapes
            .map_each(|shape| &self.shape_pairs().shapes[shape]);
        let state = state_of_shapes(&point.feature, shapes, X, V);
        self.with_margin_of(state, point, shapes)
    }

    /// [`pair_state`](Self::pair_state) with derivatives in sizes and material of one of both shapes alone, where numbers have them.
    pub(crate) fn pair_state_by_sizes<T: Over<P>>(
        &self,
        point: &PairPoint,
        side: usize,
        X: &[Transform<T>; 2],
        V: &[Motion<T>; 2],
    ) -> PairState<T> {
        let [a, b] = self.in_one(point.shapes, side);
        let state = state_of_shapes(&point.feature, [&a, &b], X, V);
        self.with_margin_of(state, point, [&a, &b])
    }

    /// The depth of a point from the margin of its pair on.
    fn with_margin_of<T: Over<P>>(
        &self,
        mut state: PairState<T>,
        point: &PairPoint,
        shapes: [&BodyShape<P>; 2],
    ) -> PairState<T> {
        if self.shape_pairs().has.margin {
            let given = self.given_material(point.shapes);
            let margin = |own: &BodyShape<P>| own.material.map_or(P::zero(), |own| own.margin);
            let of_both = || margin(shapes[0]) + margin(shapes[1]);
            state.point.depth += T::from(given.map_or_else(of_both, |own| own.margin));
        }
        state
    }
}

/// The law of two shapes, by a given material or by their own. Where only one has a material, the law is that of the other.
fn law_of_shapes<P: Scalar>(
    law: &ContactLaw<P>,
    [a, b]: [&BodyShape<P>; 2],
    given: Option<&Material<P>>,
) -> ContactLaw<P> {
    let mut own = *law;
    if let Some(given) = given {
        own.set_material(*given);
    } else if a.material.is_some() || b.material.is_some() {
        let [a, b] = [a, b].map_each(|shape| shape.material.unwrap_or_else(|| law.material()));
        own.set_material(a.between(&b));
    }
    own
}

/// Torsional and rolling friction of two shapes, by a given material or by their own. A shape without material has that of all pairs.
fn turning_of_shapes<P: Scalar>(
    of_pairs: TurningFriction<P>,
    shapes: [&BodyShape<P>; 2],
    given: Option<&Material<P>>,
) -> TurningFriction<P> {
    if let Some(given) = given {
        return given.turning;
    }
    let [a, b] = shapes.map_each(|shape| shape.material.map_or(of_pairs, |own| own.turning));
    a.between(&b)
}

fn state_of_shapes<P: Scalar, T: Over<P>>(
    feature: &PairFeature,
    [a, b]: [&BodyShape<P>; 2],
    X: &[Transform<T>; 2],
    V: &[Motion<T>; 2],
) -> PairState<T> {
    let (X_WA, X_WB) = (on(&X[0], &a.X_BS.lift()), on(&X[1], &b.X_BS.lift()));
    let found = if const { T::HAS_VALUES } {
        witness(feature, &a.shape, &X_WA, &b.shape, &X_WB)
    } else {
        let [first, second] = [a, b].map(|own| own.shape.lift());
        recorded_witness(feature, [&first, &second], [&X_WA, &X_WB])
    };
    state_of_witness(&found, X, V)
}

/// A pose on a body. A function of its own: over wide dual numbers a product of poses is 10 kB of machine code.
fn on<T: Scalar>(X_WB: &Transform<T>, X_BS: &Transform<T>) -> Transform<T> {
    *X_WB * *X_BS
}

fn state_of_witness<T: Scalar>(
    found: &Witness<T>,
    X: &[Transform<T>; 2],
    V: &[Motion<T>; 2],
) -> PairState<T> {
    let position = (found.points[0] + found.points[1]) * T::constant(0.5);
    let (in_first, first) = motion_of(&position, &X[0], &V[0]);
    let (in_second, second) = motion_of(&position, &X[1], &V[1]);
    PairState {
        point: PointState {
            position,
            velocity: first - second,
            normal: -found.normal,
            depth: -found.distance,
            in_body: in_first,
        },
        in_second,
    }
}

/// A point of the world as one of a body: its position there, and its velocity along the axes of the world.
fn motion_of<T: Scalar>(
    position: &Vector3<T>,
    X: &Transform<T>,
    V: &Motion<T>,
) -> (Vector3<T>, Vector3<T>) {
    let at = X.inverse().point(position);
    (at, rotate(&X.rotation, &velocity_at(V, &at)))
}
