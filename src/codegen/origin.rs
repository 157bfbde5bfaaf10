//! The robot of a graph.

use crate::model::Model;
use crate::scalar::Scalar;
use crate::scalar::traced::{Graph, Origin, Tracer, trace};

/// Error for a graph of another robot, or of a robot that has changed since.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("the graph was made of {}, not of the present \"{model}\" (fingerprint {fingerprint:016x}): trace it again", made_of(.origin.as_ref()))]
pub struct OtherRobot {
    /// The robot of which the graph was recorded; `None` if unknown.
    pub origin: Option<Origin>,
    /// Name of the expected robot.
    pub model: String,
    /// Its fingerprint.
    pub fingerprint: u64,
}

fn made_of(origin: Option<&Origin>) -> String {
    match origin {
        Some(Origin { name, fingerprint }) => {
            format!("\"{name}\" with the fingerprint {fingerprint:016x}")
        }
        None => "no robot that it knows of".to_owned(),
    }
}

/// The note of a robot on a graph.
fn origin<P: Scalar>(model: &Model<P>) -> Origin {
    Origin {
        name: model.name().to_owned(),
        fingerprint: model.fingerprint(),
    }
}

/// Traces a computation of a robot.
#[cfg_attr(not(feature = "graphs"), inline)]
pub(super) fn trace_of<P: Scalar>(model: &Model<P>, work: impl FnOnce(&mut Tracer)) -> Graph {
    trace(work).with_origin(origin(model))
}

/// Checks that a graph, or code that was generated from it, was recorded from a robot, and that the robot has not changed since.
///
/// * `own` – [origin](Graph::origin) of the graph or code
///
/// # Errors
/// If it is of another robot, or a parameter of the robot has changed.
///
/// # Examples
/// ```
/// use dualbody::{codegen::{self, check_origin}, model::samples};
///
/// let model = samples::pendulum();
/// let graph = codegen::mass_matrix(&model);
/// assert!(check_origin(graph.origin(), &model).is_ok());
/// assert!(check_origin(graph.origin(), &model.with_armature(0, 0.1)).is_err());
/// ```
pub fn check_origin<P: Scalar>(own: Option<&Origin>, model: &Model<P>) -> Result<(), OtherRobot> {
    let now = origin(model);
    if own == Some(&now) {
        return Ok(());
    }
    Err(OtherRobot {
        origin: own.cloned(),
        model: now.name,
        fingerprint: now.fingerprint,
    })
}

crate::error::debug_by_message! { OtherRobot }
