//! Errors of robot descriptions, their edits, states and recordings.
//!
//! Messages show texts of files without control characters and shortened; the fields contain the original texts.
//!
//! | failure | error |
//! |---|---|
//! | a description is not a model | [`LoadError`] |
//! | an operation on a description | [`EditError`] |
//! | a name is unknown | [`UnknownName`] |
//! | a variant of a robot differs in structure | [`StructureMismatch`] |
//! | a state is invalid | [`InvalidState`] |
//! | the mass matrix is singular: a joint moves without inertia | [`SingularMassMatrix`] |
//! | a model cannot be written in a format | [`WriteError`] |
//! | a recording cannot be written or read | [`RecordingError`] |
//! | a result would need more memory than the limit | [`OutOfMemory`] |

mod similar;
mod text;

use std::fmt;

use similar::similar_first;
use text::listed;
#[cfg(any(feature = "identification", feature = "plot"))]
pub(crate) use text::rounded;
pub(crate) use text::{message, write_remarks};

/// Errors whose `Debug` is their message: that is what a program prints whose `main` returns one.
macro_rules! debug_by_message {
    ($($error:ident),*) => {$(
        impl std::fmt::Debug for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(self, f)
            }
        }
    )*};
}
pub(crate) use debug_by_message;

/// A source position in a description: `arm.urdf:12`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourcePosition {
    /// The path of the file, or the label of a text or of a builder.
    pub file: String,
    /// The line, from 1; 0 if the description is not a text.
    pub line: u32,
}

impl fmt::Display for SourcePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        match self.line {
            0 => Ok(()),
            line => write!(f, ":{line}"),
        }
    }
}

/// Error for a description that did not become a model.
///
/// All variants name the source (a path, or the label of the builder), the line if available, the element and its name.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{}", message(format_args!("{file}: cannot be read: {source}")))]
    Io {
        /// The path as given.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is empty.
    #[error("{}", message(format_args!("{file}: is empty")))]
    Empty {
        /// Source of the description.
        file: String,
    },
    /// The text is not well-formed XML.
    #[error("{}", message(format_args!("{file}:{line}:{column}: not well-formed XML: {reason}")))]
    NotXml {
        /// Source of the description.
        file: String,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// Message of the parser.
        reason: String,
    },
    /// The text is not UTF-8, the only supported encoding.
    #[error("{}", message(format_args!("{file}: is not UTF-8 text (byte {offset}); convert it, for example with iconv")))]
    NotUtf8 {
        /// Source of the description.
        file: String,
        /// The first byte that does not fit, from 0.
        offset: usize,
    },
    /// The XML uses features that robot descriptions do not need and that can make reading arbitrarily slow.
    #[error("{}", message(format_args!("{file}:{line}: {reason}")))]
    UnsupportedXml {
        /// Source of the description.
        file: String,
        /// Line, from 1.
        line: u32,
        /// Construct that is refused, such as a document type declaration.
        reason: String,
    },
    /// The file is a xacro program; expand it to a URDF first.
    #[error("{}", message(format_args!("{file}:{line}: {found} is not expanded: run xacro on the file first, and load what it prints")))]
    NotExpanded {
        /// Source of the description.
        file: String,
        /// Line, from 1.
        line: u32,
        /// The element or expression.
        found: String,
    },
    /// The XML is not a robot description.
    #[error("{}", message(format_args!("{file}: the root element is <{element}>, expected <{expected}>")))]
    NotARobot {
        /// Source of the description.
        file: String,
        /// Name of the root element.
        element: String,
        /// Name of the root element that the format has.
        expected: String,
    },
    /// An element lacks required content.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\" has no {missing}")))]
    Missing {
        /// Source position.
        at: SourcePosition,
        /// Element that is incomplete.
        element: String,
        /// Name of the element, or that of the element around it.
        name: String,
        /// The attribute or child element.
        missing: String,
    },
    /// A value is malformed.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\": {attribute} = \"{value}\": {reason}")))]
    Malformed {
        /// Source position.
        at: SourcePosition,
        /// Element with the value.
        element: String,
        /// Name of the element, or that of the element around it.
        name: String,
        /// The attribute.
        attribute: String,
        /// Text of the value.
        value: String,
        /// Expected form of the value.
        reason: String,
    },
    /// A number is NaN or infinite.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\": {quantity} is not finite")))]
    NonFinite {
        /// Source position.
        at: SourcePosition,
        /// Element with the number.
        element: String,
        /// Name of the element.
        name: String,
        /// Quantity that the number is for.
        quantity: String,
    },
    /// A link's mass is negative.
    #[error("{}", message(format_args!("{at}: link \"{link}\" has the negative mass {mass} kg")))]
    NegativeMass {
        /// Source position.
        at: SourcePosition,
        /// The link.
        link: String,
        /// Mass of the link, kg.
        mass: f64,
    },
    /// Moving links and their subtrees have no inertia, and the options refuse such a robot.
    #[error("{}", message(format_args!("{file}: {source}")))]
    MissingInertia {
        /// Source of the description.
        file: String,
        /// The joints and the links that they move.
        source: SingularMassMatrix,
    },
    /// A number is so large that products in the dynamics overflow.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\": the {quantity} {value:e} is out of range: the dynamics overflow beyond ±{LARGEST_NUMBER:e}")))]
    TooLarge {
        /// Source position.
        at: SourcePosition,
        /// Element with the number, or which the number is summed up for.
        element: String,
        /// Name of the element.
        name: String,
        /// Quantity that the number is for.
        quantity: String,
        /// Value of the number.
        value: f64,
    },
    /// A joint that needs an axis has the zero vector.
    #[error("{}", message(format_args!("{at}: joint \"{joint}\" has a zero axis")))]
    ZeroAxis {
        /// Source position.
        at: SourcePosition,
        /// The joint.
        joint: String,
    },
    /// A joint's lower limit is above its upper one, or a limit of velocity or effort is negative.
    #[error("{}", message(format_args!("{at}: joint \"{joint}\": {reason}")))]
    InvalidLimits {
        /// Source position.
        at: SourcePosition,
        /// The joint.
        joint: String,
        /// Limits at fault, with their values.
        reason: String,
    },
    /// Two elements of one kind share a name.
    #[error("{}", message(format_args!("{at}: there are two {element}s with the name \"{name}\"")))]
    DuplicateName {
        /// Source position.
        at: SourcePosition,
        /// Link, joint or frame.
        element: String,
        /// The name.
        name: String,
    },
    /// A joint or frame refers to a link that does not exist.
    #[error("{}", message(format_args!("{at}: the parent \"{link}\" of {element} \"{name}\" does not exist")))]
    UnknownParent {
        /// Source position.
        at: SourcePosition,
        /// Joint or frame.
        element: String,
        /// Name of the joint or frame.
        name: String,
        /// The missing link.
        link: String,
    },
    /// A joint moves a link that does not exist.
    #[error("{}", message(format_args!("{at}: the child \"{link}\" of joint \"{joint}\" does not exist")))]
    UnknownChild {
        /// Source position.
        at: SourcePosition,
        /// The joint.
        joint: String,
        /// The missing link.
        link: String,
    },
    /// The leader of a mimic joint does not exist or is not allowed.
    #[error("{}", message(format_args!("{at}: joint \"{joint}\" cannot mimic \"{leader}\": {reason}")))]
    InvalidMimic {
        /// Source position.
        at: SourcePosition,
        /// The joint.
        joint: String,
        /// The joint that it should follow.
        leader: String,
        /// Reason why not.
        reason: String,
    },
    /// Two joints move one link; the model must be a tree.
    #[error("{}", message(format_args!("{at}: joint \"{}\" moves link \"{link}\", which joint \"{}\" moves already; close a loop by a Constraint on the simulator", joints[1], joints[0])))]
    SeveralParents {
        /// Source position of the second one.
        at: SourcePosition,
        /// The two joints.
        joints: [String; 2],
        /// The link that they move.
        link: String,
    },
    /// The joints close a loop; the model must be a tree.
    #[error("{}", message(format_args!("{at}: these joints lead from link \"{link}\" back to it: {}; leave one out, and close the loop by a Constraint on the simulator", listed(joints))))]
    Loop {
        /// Source position of one of them.
        at: SourcePosition,
        /// The joints of the loop, from the link down.
        joints: Vec<String>,
        /// The link at which it closes.
        link: String,
    },
    /// More than one link has no parent.
    #[error("{}", message(format_args!("{file}: several links have no parent: {}", listed(roots))))]
    SeveralRoots {
        /// Source of the description.
        file: String,
        /// The links without parent.
        roots: Vec<String>,
    },
    /// The requested base does not fit the robot.
    #[error("{}", message(format_args!("{at}: link \"{link}\" cannot become the base: {reason}")))]
    UnsupportedBase {
        /// Source position.
        at: SourcePosition,
        /// The root link.
        link: String,
        /// Reason why not.
        reason: String,
    },
    /// A file contains several models, or not the requested one.
    #[error("{}", message(format_args!("{file}: {reason}; the models are: {}", listed(names))))]
    ModelChoice {
        /// Source of the description.
        file: String,
        /// Reason why none is chosen.
        reason: String,
        /// Names of the models in the file.
        names: Vec<String>,
    },
    /// The joints to keep or lock do not fit the robot.
    #[error("{}", message(format_args!("{file}: {source}")))]
    JointChoice {
        /// Source of the description.
        file: String,
        /// Mismatch of the joints with the robot.
        source: Box<EditError>,
    },
    /// An element refers to a frame, link or joint that does not exist in its scope.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\": there is no frame \"{frame}\"")))]
    UnknownFrame {
        /// Source position.
        at: SourcePosition,
        /// Element with the reference.
        element: String,
        /// Name of the element.
        name: String,
        /// The frame that it names.
        frame: String,
    },
    /// Frames are defined relative to each other in a cycle.
    #[error("{}", message(format_args!("{at}: the frame of <{element}> \"{name}\" is given relative to itself")))]
    FrameCycle {
        /// Source position.
        at: SourcePosition,
        /// An element on the circle.
        element: String,
        /// Name of the element.
        name: String,
    },
    /// An included file is not found, or files include each other in a cycle.
    #[error("{}", message(format_args!("{file}:{line}: cannot include \"{uri}\": {reason}")))]
    Include {
        /// Source of the description.
        file: String,
        /// Line, from 1.
        line: u32,
        /// The reference.
        uri: String,
        /// Reason why not.
        reason: String,
    },
    /// The robot needs an unsupported feature.
    #[error("{}", message(format_args!("{at}: <{element}> \"{name}\": {reason}")))]
    Unsupported {
        /// Source position.
        at: SourcePosition,
        /// The element.
        element: String,
        /// Name of the element.
        name: String,
        /// Reason why the element is not supported.
        reason: String,
    },
}

/// Largest number in a description: products of three such numbers are finite.
pub const LARGEST_NUMBER: f64 = 1e100;

/// A mass matrix that is singular, or not positive definite, at (almost) every configuration: forces do not determine
/// accelerations.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("{}", message(format_args!(
    "no inertia resists the motion of {}, so that the mass matrix of \"{model}\" is singular: kinematics and inverse dynamics work, \
     forward dynamics and steps do not. Give these links an inertia (an <inertial>; with_link_inertia; the option massless_links), \
     lock or fix the joints (with_locked_joint), or give them rotors (with_armature)",
    listed(joints)
)))]
pub struct SingularMassMatrix {
    /// Name of the model.
    pub model: String,
    /// The joints, in the order of their coordinates.
    pub joints: Vec<UnresistedJoint>,
}

/// Error for a result that would need more memory than the [limit](crate::memory::limit).
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what} need {:.1e} bytes, and the limit is {:.1e}: memory::set_limit changes it", *bytes as f64, *limit as f64)]
#[non_exhaustive]
pub struct OutOfMemory {
    /// The result, as a plural noun.
    pub what: String,
    /// Bytes that it would need; `usize::MAX` on overflow.
    pub bytes: usize,
    /// The limit, bytes.
    pub limit: usize,
}

/// A joint whose motion nothing resists.
#[derive(Clone, Debug, PartialEq)]
pub struct UnresistedJoint {
    /// Name of the joint; `None` for a floating base.
    pub joint: Option<String>,
    /// The first link on the body that it moves.
    pub link: String,
    /// The inertia that resists it while all joints of its subtree move freely, kg·m² or kg: zero to rounding, or negative.
    pub inertia: f64,
}

impl fmt::Display for UnresistedJoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.joint {
            Some(name) => write!(f, "joint \"{name}\"")?,
            None => f.write_str("the floating base")?,
        }
        write!(f, " (link \"{}\", inertia {:e})", self.link, self.inertia)
    }
}

/// An unknown name. The message lists the existing names, similar ones first, shortened if there are many.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", message(format_args!("model \"{model}\" has no {element} \"{name}\"; it has: {}", listed(&similar_first(name, known)))))]
pub struct UnknownName {
    /// Name of the model.
    pub model: String,
    /// Joint, link or frame.
    pub element: String,
    /// The unknown name.
    pub name: String,
    /// The existing names.
    pub known: Vec<String>,
}

/// Error for variants of a robot that differ in structure.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", message(format_args!("model {index}, \"{model}\", is not a variant of the first: {difference}")))]
pub struct StructureMismatch {
    /// Index of the model, from 0.
    pub index: usize,
    /// Name of the model.
    pub model: String,
    /// The first difference.
    pub difference: String,
}

/// Error for a state that does not belong to a robot.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidState {
    /// The length of the state differs from the number of coordinates of the robot.
    #[error("{}", message(format_args!("{vector} of \"{model}\" has {expected} entries, got {given}")))]
    WrongLength {
        /// Name of the model.
        model: String,
        /// q or v.
        vector: &'static str,
        /// The number of coordinates.
        expected: usize,
        /// The number of entries.
        given: usize,
    },
    /// A number is NaN or infinite.
    #[error("{}", message(format_args!("{vector}[{index}], of {joint}, is {value}")))]
    NonFinite {
        /// q or v.
        vector: &'static str,
        /// Index of the number in its part.
        index: usize,
        /// The joint that it belongs to.
        joint: String,
        /// The number.
        value: f64,
    },
    /// An entry of the contact state is NaN or infinite.
    #[error("{}", message(format_args!("contact[{index}] is {value}")))]
    NonFiniteContact {
        /// Index of the number in its part.
        index: usize,
        /// The number.
        value: f64,
    },
    /// An entry of the activations of inputs is NaN or infinite.
    #[error("{}", message(format_args!("activation[{index}] is {value}")))]
    NonFiniteActivation {
        /// Index of the number among all activations.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A quaternion is not of unit length.
    #[error("{}", message(format_args!("the quaternion q[{index}..{}] of {joint} has the norm {norm}", index + 4)))]
    QuaternionNorm {
        /// Index at which the quaternion starts.
        index: usize,
        /// The joint that it belongs to.
        joint: String,
        /// Norm of the quaternion.
        norm: f64,
    },
    /// A joint has another kind in the target model, or is a mimic joint in one of the two models.
    #[error("{}", message(format_args!("joint \"{name}\" {reason}")))]
    OtherJoint {
        /// The joint.
        name: String,
        /// The difference.
        reason: String,
    },
}

/// Error for an invalid edit of a robot.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The robot has no such joint, link or frame.
    #[error(transparent)]
    UnknownName(#[from] UnknownName),
    /// A name is duplicate.
    #[error("{}", message(format_args!("there are two {element}s with the name \"{name}\"")))]
    DuplicateName {
        /// Link, joint or frame.
        element: String,
        /// The name.
        name: String,
    },
    /// The configuration of a joint has the wrong number of coordinates.
    #[error("{}", message(format_args!("joint \"{joint}\" has {expected} configuration coordinates, got {given}")))]
    WrongLength {
        /// The joint.
        joint: String,
        /// The number of coordinates of its kind.
        expected: usize,
        /// The number that was given.
        given: usize,
    },
    /// A joint, or its leader, is both to be kept and to be locked.
    #[error("{}", message(format_args!("joint \"{joint}\" must stay free, but it or the joint that it mimics is locked")))]
    KeptAndLocked {
        /// The joint.
        joint: String,
    },
    /// A quantity that must be positive and finite is not.
    #[error("{}", message(format_args!("the {quantity} {value} is not positive and finite")))]
    NotPositive {
        /// Quantity that the number is for.
        quantity: String,
        /// Value of the number.
        value: f64,
    },
    /// A link without mass cannot be scaled to another mass.
    #[error("{}", message(format_args!("link \"{link}\" has no mass to change: give it an inertia")))]
    NoMass {
        /// The link.
        link: String,
    },
    /// A link does not have the quantity to change.
    #[error("{}", message(format_args!("link \"{link}\" cannot be scaled: {reason}")))]
    CannotScale {
        /// The link.
        link: String,
        /// Reason why not.
        reason: String,
    },
    /// The shape of an object has no volume, so its inertia cannot be computed from its mass.
    #[error("{}", message(format_args!("object \"{object}\" has no inertia: {reason}")))]
    Shape {
        /// Name of the object.
        object: String,
        /// Reason why not.
        reason: String,
    },
    /// The edited description is not a valid model.
    #[error(transparent)]
    Load(#[from] LoadError),
}

/// Error for a robot that cannot be written to a file of some format.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The format cannot represent essential content.
    #[error("{}", message(format_args!("{format} cannot hold {element} \"{name}\": {reason}")))]
    Unsupported {
        /// The format.
        format: &'static str,
        /// Link, joint or frame.
        element: String,
        /// Name of the element.
        name: String,
        /// Reason why not.
        reason: String,
    },
}

/// Error while reading or writing a recording.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be read or written.
    #[error("{}", message(format_args!("{file}: {source}")))]
    Io {
        /// The path as given.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not a recording.
    #[error("{}", message(format_args!("{file}:{line}: {reason}")))]
    Malformed {
        /// The path as given.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Reason why the text is not a recording.
        reason: String,
    },
    /// The Rerun viewer, or its file, does not accept data.
    #[error("{}", message(format_args!("{target}: {reason}")))]
    Rerun {
        /// Address of the viewer, or the path as given.
        target: String,
        /// Message of the Rerun library.
        reason: String,
    },
    /// The file is a recording of other robots.
    #[error("{}", message(format_args!("{file}: {reason}")))]
    OtherRobots {
        /// The path as given.
        file: String,
        /// The first thing that does not fit.
        reason: String,
    },
}

debug_by_message! { LoadError, SingularMassMatrix, OutOfMemory, UnknownName, StructureMismatch, InvalidState, EditError, WriteError, RecordingError }
