//! Assembles the tree from named parts: finds the root, traverses the tree depth first, and merges fixed links.
//!
//! Everything is iterative, so that a chain of any length fits an ordinary stack.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::axes::{body_frame, unit, unit_axis};
use super::body::Body;
use super::builder::{JointSpec, LinkSpec, ModelBuilder};
use super::graph::{Graph, Start};
use super::numbers::Numbers;
use super::parts::{Frame, Joint, Link, SecondAxis, Spring};
use super::structure::fingerprint;
use super::weightless::Weightless;
use super::{BodyId, FrameId, Generation, Model, checks, coordinates};
use crate::error::LoadError;
use crate::joint::JointKind;
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Transform};

/// Checks the parts, then builds the tree.
pub(super) fn build(builder: &ModelBuilder) -> Result<Model, LoadError> {
    let model = build_over(builder, &Numbers::of(builder))?;
    checks::check_sums(builder, &model)?;
    Ok(model)
}

/// Builds the tree of a description with numbers over any scalar in the place of its own.
pub(super) fn build_over<T: Scalar>(
    builder: &ModelBuilder,
    numbers: &Numbers<T>,
) -> Result<Model<T>, LoadError> {
    checks::check(builder)?;
    let graph = Graph::new(builder)?;
    let start = graph.start(builder)?;
    let mut tree = Tree::new(builder, numbers);
    tree.grow(&graph, start);
    graph.check_reached(builder, &tree.seen)?;
    let mut model = tree.finish()?;
    model.apply_overrides(&builder.overrides);
    Ok(model)
}

/// Attachment of a link: the body (or the world) and the pose of the link in it.
#[derive(Clone, Copy)]
struct Attachment<T> {
    body: Option<BodyId>,
    X_BL: Transform<T>,
}

impl<T: Scalar> Attachment<T> {
    fn world() -> Self {
        Self {
            body: None,
            X_BL: Transform::identity(),
        }
    }
}

/// Links of a body by whether gravity acts on them.
struct Weights<T> {
    /// Inertia of those that it does not act on, in the body.
    weightless: Inertia<T>,
    /// Whether there are links with inertia that it does not act on, and that it acts on.
    any: [bool; 2],
}

impl<T: Scalar> Weights<T> {
    fn none() -> Self {
        Self {
            weightless: Inertia::zero(),
            any: [false; 2],
        }
    }

    fn add(&mut self, link: &LinkSpec, own: Inertia<T>) {
        if link.inertia == Inertia::zero() {
            return;
        }
        self.any[usize::from(link.has_gravity)] = true;
        if !link.has_gravity {
            self.weightless = self.weightless + own;
        }
    }

    /// The part that gravity does not act on of a body with an inertia.
    fn part(&self, body: BodyId, all: &Inertia<T>) -> Option<Weightless<T>> {
        match self.any {
            [false, _] => None,
            [true, false] => Some(Weightless::whole(body)),
            [true, true] => Some(Weightless::part_of(body, all, &self.weightless)),
        }
    }
}

/// The tree while it grows.
struct Tree<'a, T> {
    builder: &'a ModelBuilder,
    numbers: &'a Numbers<T>,
    bodies: Vec<Body<T>>,
    /// Of each body, the inertia of the links that gravity does not act on, and the masses with and without gravity, kg.
    weights: Vec<Weights<T>>,
    frames: Vec<Frame<T>>,
    links: Vec<Link>,
    joints: Vec<Joint>,
    /// Specification that each joint was built from.
    specs: Vec<&'a JointSpec>,
    /// Universal joints by name, with the joint frame on the first of their two bodies.
    crosses: Vec<(&'a str, Attachment<T>)>,
    seen: Vec<bool>,
}

impl<'a, T: Scalar> Tree<'a, T> {
    fn new(builder: &'a ModelBuilder, numbers: &'a Numbers<T>) -> Self {
        Self {
            builder,
            numbers,
            bodies: Vec::new(),
            weights: Vec::new(),
            frames: Vec::new(),
            links: Vec::new(),
            joints: Vec::new(),
            specs: Vec::new(),
            crosses: Vec::new(),
            seen: vec![false; builder.links.len()],
        }
    }

    /// Depth first with an explicit stack; children in the order of the description.
    fn grow(&mut self, graph: &Graph, start: Start) {
        if let Some(world) = start.world {
            self.place_link(world, Attachment::world());
        }
        let mut at = Attachment::world();
        if start.floating {
            at = self.add_body(JointKind::Floating, at, Matrix3::identity());
            let placed = start.joint.map(|joint| self.numbers.placements[joint]);
            at.X_BL = placed.unwrap_or_else(Transform::identity);
        }
        self.place_link(start.link, at);
        let mut open: Vec<(usize, Attachment<T>)> = Vec::new();
        push_children(&mut open, graph, start.link, at);
        while let Some((joint, parent)) = open.pop() {
            let link = graph.child[joint];
            let at = self.attach(joint, parent);
            self.place_link(link, at);
            push_children(&mut open, graph, link, at);
        }
    }

    /// Follows a joint from its parent link: a fixed one stays on the body, any other starts a new body.
    fn attach(&mut self, index: usize, parent: Attachment<T>) -> Attachment<T> {
        let joint = &self.builder.joints[index];
        let at = Attachment {
            body: parent.body,
            X_BL: parent.X_BL * self.numbers.placements[index],
        };
        if joint.kind == JointKind::Fixed {
            return at;
        }
        let axis = unit_axis(joint);
        let second = joint.second.clone().map(|second| SecondAxis {
            axis: unit(&second.axis),
            ..second
        });
        let kind = joint.kind.of_body();
        let mut at = self.add_body(kind, at, body_frame(kind, &axis));
        if let Some(second) = &second {
            self.crosses.push((&joint.name, at));
            at = self.add_body(kind, at, body_frame(kind, &second.axis));
        }
        self.joints.push(Joint {
            name: joint.name.clone(),
            body: BodyId(self.bodies.len() - 1),
            kind: joint.kind,
            axis,
            limits: joint.limits,
            friction: joint.friction,
            second,
            mimic: joint.mimic.clone(),
            is_passive: joint.is_passive,
        });
        self.specs.push(joint);
        at
    }

    /// Adds a body whose frame is turned by `R_LB` against that of its link; returns where the link is on it.
    fn add_body(
        &mut self,
        kind: JointKind,
        at: Attachment<T>,
        R_LB: Matrix3<f64>,
    ) -> Attachment<T> {
        let id = BodyId(self.bodies.len());
        let X_LB = Transform::new(R_LB.map(T::constant), Vector3::zeros());
        self.bodies.push(Body {
            parent: at.body,
            joint: kind,
            placement: at.X_BL * X_LB,
            inertia: Inertia::zero(),
            q: 0,
            v: 0,
            coupling: None,
            subtree_end: id.0 + 1,
        });
        self.weights.push(Weights::none());
        Attachment {
            body: Some(id),
            X_BL: X_LB.inverse(),
        }
    }

    /// Merges a link into its body and keeps its frame.
    fn place_link(&mut self, index: usize, at: Attachment<T>) {
        let link = &self.builder.links[index];
        self.seen[index] = true;
        if let Some(id) = at.body {
            let body = &mut self.bodies[id.0];
            let own = at.X_BL.inertia(&self.numbers.inertias[index]);
            body.inertia = body.inertia + own;
            self.weights[id.0].add(link, own);
        }
        self.links.push(Link {
            frame: FrameId(self.frames.len()),
            visuals: link.visuals.clone(),
            collisions: link.collisions.clone(),
            collide_bitmasks: link.collide_bitmasks.clone(),
        });
        self.frames.push(Frame {
            name: link.name.clone(),
            body: at.body,
            placement: at.X_BL,
        });
    }

    fn finish(mut self) -> Result<Model<T>, LoadError> {
        self.add_frames()?;
        let coordinates =
            coordinates::assign(self.builder, &mut self.bodies, &self.joints, &self.specs)?;
        for i in (0..self.bodies.len()).rev() {
            if let Some(parent) = self.bodies[i].parent {
                let end = self.bodies[i].subtree_end;
                let parent = &mut self.bodies[parent.0];
                parent.subtree_end = parent.subtree_end.max(end);
            }
        }
        let weights = self.weights.iter().zip(&self.bodies).enumerate();
        let weightless =
            weights.filter_map(|(i, (weights, body))| weights.part(BodyId(i), &body.inertia));
        Ok(Model {
            name: self.builder.name.clone(),
            gravity: self.builder.gravity.map(T::constant),
            generation: Generation::next(),
            structure: fingerprint(&self.bodies, &self.joints, &self.frames),
            weightless: weightless.collect(),
            bodies: self.bodies,
            frames: self.frames,
            damping: constants(&coordinates.damping),
            armature: constants(&coordinates.armature),
            springs: coordinates.springs.iter().map(constant).collect(),
            joints: self.joints,
            links: self.links,
            nq: coordinates.nq,
            description: Arc::new(self.builder.clone()),
            remarks: Arc::default(),
        })
    }

    fn add_frames(&mut self) -> Result<(), LoadError> {
        let of_link: HashMap<String, usize> = self
            .frames
            .iter()
            .enumerate()
            .map(|(i, f)| (f.name.clone(), i))
            .collect();
        for (frame, placement) in self.builder.frames.iter().zip(&self.numbers.frames) {
            let Some(&link) = of_link.get(&frame.link) else {
                let (at, name, link) = (
                    self.builder.position("frame", &frame.name),
                    frame.name.clone(),
                    frame.link.clone(),
                );
                return Err(LoadError::UnknownParent {
                    at,
                    element: "frame".into(),
                    name,
                    link,
                });
            };
            let (body, X_BL) = (self.frames[link].body, self.frames[link].placement);
            self.frames.push(Frame {
                name: frame.name.clone(),
                body,
                placement: X_BL * *placement,
            });
        }
        self.add_crosses();
        Ok(())
    }
}

impl<T: Scalar> Tree<'_, T> {
    /// Adds a frame on the first body of each universal joint, which no link is on, so that it has a name: `NAME::cross`.
    fn add_crosses(&mut self) {
        let taken: HashSet<String> = self.frames.iter().map(|frame| frame.name.clone()).collect();
        for &(joint, at) in &self.crosses {
            let mut name = format!("{joint}::cross");
            while taken.contains(&name) {
                name.push('_');
            }
            self.frames.push(Frame {
                name,
                body: at.body,
                placement: at.X_BL,
            });
        }
    }
}

fn constants<T: Scalar>(numbers: &[f64]) -> Vec<T> {
    numbers.iter().map(|&x| T::constant(x)).collect()
}

fn constant<T: Scalar>(spring: &Spring<f64>) -> Spring<T> {
    Spring {
        stiffness: T::constant(spring.stiffness),
        rest: T::constant(spring.rest),
    }
}

fn push_children<T: Scalar>(
    open: &mut Vec<(usize, Attachment<T>)>,
    graph: &Graph,
    link: usize,
    at: Attachment<T>,
) {
    open.extend(graph.carried[link].iter().rev().map(|&joint| (joint, at)));
}

impl ModelBuilder {
    /// Checks everything and builds the model, in time linear in the number of links (names are hashed).
    ///
    /// # Errors
    /// See [`LoadError`]: names that are missing, empty or duplicate, loops, several roots, zero axes, values that are not finite or beyond ±10¹⁰⁰,
    /// negative masses, limits in the wrong order. Moving links without inertia are allowed here: [`Model::check_mass_matrix`] finds them.
    pub fn build(&self) -> Result<Model, LoadError> {
        build(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{frame_pose, mass_matrix};
    use crate::model::{Base, LinkSpec};
    use crate::spatial::Quaternion;
    use crate::tests::ROUNDING;

    // A free-flyer at the link `world` moves that link, with the same robot on it as when the base is fixed.
    #[test]
    fn floating_base_over_a_turned_fixed_joint_equals_a_free_flyer_at_the_world() {
        let X_WL = Transform::new(
            Quaternion::exp(&Vector3::new(-1.57, 0.0, 0.3)).to_matrix(),
            Vector3::new(0.1, 0.2, 0.3),
        );
        let robot = |root: &str, base: Base| {
            let mut builder = ModelBuilder::new("robot").with_base(base);
            let solid =
                |name: &str| LinkSpec::new(name).with_mass(1.0, [0.1, 0.0, 0.2], [0.1, 0.2, 0.25]);
            builder
                .add_link(LinkSpec::new(root))
                .add_link(solid("base"))
                .add_link(solid("arm"));
            let weld = JointSpec::new("weld", JointKind::Fixed, root, "base");
            builder.add_joint(weld.with_placement(X_WL));
            builder.add_joint(JointSpec::new(
                "elbow",
                JointKind::Continuous,
                "base",
                "arm",
            ));
            builder.build().unwrap()
        };
        let (floating, flyer) = (
            robot("world", Base::Floating),
            robot("root", Base::Floating),
        );
        let (fixed, mut q) = (robot("world", Base::Fixed), floating.neutral());
        q[7] = 0.4;
        for link in ["base", "arm"] {
            let pose = |model: &Model, q: &[f64]| frame_pose(model, q, model.frame(link).unwrap());
            assert_eq!(
                pose(&floating, q.as_slice()),
                pose(&flyer, q.as_slice()),
                "{link}"
            );
            let difference = pose(&floating, q.as_slice()).rotation - pose(&fixed, &[0.4]).rotation;
            assert!(difference.amax() < ROUNDING, "{link}");
        }
        q[0] = 0.7;
        assert_eq!(
            mass_matrix(&floating, q.as_slice()),
            mass_matrix(&flyer, q.as_slice())
        );
        let world = floating.frame("world").unwrap();
        assert_eq!(
            frame_pose(&floating, q.as_slice(), world),
            Transform::identity()
        );
    }
}
