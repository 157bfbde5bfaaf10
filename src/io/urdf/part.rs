//! Parts of a robot that remarks are about, and where they are written.

use crate::io::ImportNote;
use crate::io::context::{Context, Node, child};
use crate::io::shapes::Shape;

/// A part of a robot, by the indices of its link, visual or collision, or joint in `urdf_rs::Robot`.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    Robot,
    Inertial(usize),
    Visual(usize, usize),
    VisualShape(usize, usize),
    Material(usize, usize),
    Collision(usize, usize),
    CollisionShape(usize, usize),
    Joint(usize),
    Limit(usize),
    Dynamics(usize),
    Mimic(usize),
}

/// Origin of a robot.
pub(super) enum Source<'a> {
    /// A text, with the elements that its parts are written in.
    Text(Elements<'a>),
    /// A program.
    Typed,
}

/// The elements of a robot, in the order of `urdf_rs::Robot`.
pub(super) struct Elements<'a> {
    pub(super) robot: Node<'a>,
    pub(super) links: Vec<LinkElements<'a>>,
    pub(super) joints: Vec<Node<'a>>,
}

/// The elements of a link.
pub(super) struct LinkElements<'a> {
    pub(super) link: Node<'a>,
    /// The visuals that have a shape.
    pub(super) visuals: Vec<ShapeElements<'a>>,
    /// The collisions that have a shape.
    pub(super) collisions: Vec<ShapeElements<'a>>,
}

/// A visual or collision with the element of its shape.
pub(super) struct ShapeElements<'a> {
    pub(super) node: Node<'a>,
    pub(super) shape: Shape<'a>,
}

impl Source<'_> {
    /// A remark on a part.
    pub(super) fn note(
        &self,
        context: &Context<'_>,
        robot: &urdf_rs::Robot,
        part: Part,
        reason: String,
    ) -> ImportNote {
        match self {
            Self::Text(elements) => context.note(elements.of(part), "", reason),
            Self::Typed => note_of_typed(robot, part, reason),
        }
    }

    /// Whether a material says nothing but its name.
    pub(super) fn only_names(&self, part: Part, material: &urdf_rs::Material) -> bool {
        match self {
            Self::Text(elements) => elements.of(part).first_element_child().is_none(),
            Self::Typed => material.texture.is_none(),
        }
    }
}

impl<'a> Elements<'a> {
    /// The element of a part; where it has none of its own, that around it.
    fn of(&self, part: Part) -> Node<'a> {
        let inside = |node: Node<'a>, name| child(node, name).unwrap_or(node);
        match part {
            Part::Robot => self.robot,
            Part::Inertial(l) => inside(self.links[l].link, "inertial"),
            Part::Visual(l, k) => self.links[l].visuals[k].node,
            Part::VisualShape(l, k) => self.links[l].visuals[k].shape.node,
            Part::Material(l, k) => inside(self.links[l].visuals[k].node, "material"),
            Part::Collision(l, k) => self.links[l].collisions[k].node,
            Part::CollisionShape(l, k) => self.links[l].collisions[k].shape.node,
            Part::Joint(j) => self.joints[j],
            Part::Limit(j) => inside(self.joints[j], "limit"),
            Part::Dynamics(j) => inside(self.joints[j], "dynamics"),
            Part::Mimic(j) => inside(self.joints[j], "mimic"),
        }
    }
}

/// A remark on a part of a robot that is no text: the path that the part would have in one.
pub(super) fn note_of_typed(robot: &urdf_rs::Robot, part: Part, reason: String) -> ImportNote {
    let (path, name) = match part {
        Part::Robot => ("robot", &robot.name),
        Part::Inertial(l) => ("robot/link/inertial", &robot.links[l].name),
        Part::Visual(l, _) => ("robot/link/visual", &robot.links[l].name),
        Part::VisualShape(l, _) => ("robot/link/visual/geometry", &robot.links[l].name),
        Part::Material(l, _) => ("robot/link/visual/material", &robot.links[l].name),
        Part::Collision(l, _) => ("robot/link/collision", &robot.links[l].name),
        Part::CollisionShape(l, _) => ("robot/link/collision/geometry", &robot.links[l].name),
        Part::Joint(j) => ("robot/joint", &robot.joints[j].name),
        Part::Limit(j) => ("robot/joint/limit", &robot.joints[j].name),
        Part::Dynamics(j) => ("robot/joint/dynamics", &robot.joints[j].name),
        Part::Mimic(j) => ("robot/joint/mimic", &robot.joints[j].name),
    };
    ImportNote {
        path: path.into(),
        name: name.clone(),
        line: 0,
        reason,
    }
}
