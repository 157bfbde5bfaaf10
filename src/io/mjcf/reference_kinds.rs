//! Attributes that refer to other elements.

use super::tree::Node;
use crate::error::LoadError;
use crate::nested::IntoNested;

/// Kinds of elements that others name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Actuator,
    Body,
    Camera,
    Flex,
    Geom,
    Joint,
    Material,
    Mesh,
    Site,
    Tendon,
}

impl Kind {
    /// The kind of elements of a section and tag, or of a type of objects.
    pub(super) fn of(section: &str, tag: &str) -> Option<Self> {
        Some(match (section, tag) {
            ("actuator", _) => Self::Actuator,
            ("tendon", _) => Self::Tendon,
            (_, "body" | "xbody") => Self::Body,
            (_, "camera") => Self::Camera,
            (_, "geom") => Self::Geom,
            (_, "joint" | "freejoint") => Self::Joint,
            (_, "site") => Self::Site,
            _ => return None,
        })
    }

    /// The kind that an attribute of an element names.
    fn named(node: Node<'_>, attribute: &str) -> Option<Self> {
        let of_type = |name: &str| match node.peek(name)? {
            "actuator" => Some(Self::Actuator),
            "tendon" => Some(Self::Tendon),
            tag => Self::of("", tag),
        };
        Some(match attribute {
            "actuator" => Self::Actuator,
            "body" | "body1" | "body2" | "subtree1" | "subtree2" | "target" => Self::Body,
            "camera" => Self::Camera,
            "flex" => Self::Flex,
            "geom" | "geom1" | "geom2" => Self::Geom,
            "joint" | "joint1" | "joint2" | "jointinparent" => Self::Joint,
            "material" => Self::Material,
            "mesh" => Self::Mesh,
            "site" | "site1" | "site2" | "refsite" | "cranksite" | "slidersite" | "sidesite" => {
                Self::Site
            }
            "tendon" | "tendon1" | "tendon2" => Self::Tendon,
            "objname" => return of_type("objtype"),
            "refname" => return of_type("reftype"),
            _ => return None,
        })
    }

    fn word(self) -> &'static str {
        match self {
            Self::Actuator => "actuator",
            Self::Body => "body",
            Self::Camera => "camera",
            Self::Flex => "flex",
            Self::Geom => "geom",
            Self::Joint => "joint",
            Self::Material => "material",
            Self::Mesh => "mesh",
            Self::Site => "site",
            Self::Tendon => "tendon",
        }
    }
}

/// A name in an element, or in a child of it.
#[derive(Clone, Copy)]
pub(super) struct Reference<'t> {
    node: Node<'t>,
    pub(super) attribute: &'t str,
    pub(super) kind: Kind,
    pub(super) name: &'t str,
}

impl Reference<'_> {
    pub(super) fn unknown(&self) -> LoadError {
        let reason = format!("there is no {} of that name", self.kind.word());
        let place = self.node.place();
        place.malformed(self.attribute, self.name, reason)
    }
}

/// The names in an element and its children.
pub(super) fn references(node: Node<'_>) -> impl Iterator<Item = Reference<'_>> {
    let all = std::iter::once(node).chain(node.children());
    all.nested(|node| {
        let own = node.element().attributes.iter();
        own.filter_map(move |own| {
            let name = own.value.trim();
            let kind = Kind::named(node, &own.name).filter(|_| !name.is_empty())?;
            Some(Reference {
                node,
                attribute: &own.name,
                kind,
                name,
            })
        })
    })
}
