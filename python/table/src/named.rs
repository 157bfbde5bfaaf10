//! Arguments given by name: frames, representations, frames of momentum.

use dualbody::dynamics::MomentumFrame;
use dualbody::error::UnknownName;
use dualbody::model::FrameId;
use dualbody::spatial::Representation;
use dualbody::{Model, Scalar};

/// A name that means nothing.
#[derive(Debug)]
pub enum Unknown {
    /// No element of the robot has it.
    Element(UnknownName),
    /// It is none of the choices: the argument, the name, and these.
    Choice(&'static str, String, &'static [&'static str]),
}

/// Something that an argument gives by its name.
pub trait Named: Copy + Send + Sync + 'static {
    /// Finds the item of a name.
    ///
    /// # Errors
    /// If the name is unknown.
    fn find<P: Scalar>(model: &Model<P>, name: &str) -> Result<Self, Unknown>;
}

impl Named for FrameId {
    fn find<P: Scalar>(model: &Model<P>, name: &str) -> Result<Self, Unknown> {
        model.find_frame(name).map_err(Unknown::Element)
    }
}

/// A choice among some names.
macro_rules! choices {
    ($kind:ty, $argument:literal: $($name:literal => $value:ident),*) => {
        impl Named for $kind {
            fn find<P: Scalar>(_: &Model<P>, name: &str) -> Result<Self, Unknown> {
                match name {
                    $($name => Ok(Self::$value),)*
                    other => Err(Unknown::Choice($argument, other.to_owned(), &[$($name),*])),
                }
            }
        }
    };
}
choices!(Representation, "representation": "body" => Body, "mixed" => Mixed, "inertial" => Inertial);
choices!(MomentumFrame, "frame": "centroidal" => Centroidal, "world" => World, "base" => Base);
