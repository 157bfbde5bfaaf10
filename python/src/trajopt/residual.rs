//! Residuals, whatever their type.

use dualbody::contact::LinkShapes;
use dualbody::model::FrameId;
use dualbody::spatial::Representation;
use dualbody::trajopt::{
    Activation, AnySystem, CenterOfMass, CentroidalMomentum, FrameDistance, FrameOrientation,
    FramePose, FramePosition, FrameVelocity, InputError, LinkDistances, Obstacle, Residual,
    StateError,
};

use crate::dynamics::named;
use crate::model::read_pose;
use crate::prelude::*;

use super::user::UserResidual;

pub(super) fn activation_of(value: &Bound<'_, PyAny>) -> PyResult<Activation> {
    let kind: String = attribute(value, "kind")?;
    let numbers = |name| read_vector(name, &value.getattr(name)?, None);
    let (x, y) = (numbers("x")?, numbers("y")?);
    match (kind.as_str(), x.as_slice()) {
        ("quadratic", _) => Ok(Activation::Quadratic),
        ("weighted", _) => Ok(Activation::Weighted(x)),
        ("smooth_abs", &[width]) => Ok(Activation::SmoothAbs { width }),
        ("flat", &[width]) => Ok(Activation::Flat { width }),
        ("barrier", _) => guarded(|| Activation::barrier(&x, &y)),
        _ => Err(invalid!("activation is of the unknown kind \"{kind}\"")),
    }
}

/// Work on a residual of any type.
pub(super) trait Use {
    type Out;
    fn with<R: Residual>(self, residual: R) -> PyResult<Self::Out>;
}

/// Makes the residual that a class of Python describes, and uses it.
pub(super) fn with_residual<U: Use>(
    dynamics: &dyn AnySystem,
    value: &Bound<'_, PyAny>,
    raised: &Raised,
    then: U,
) -> PyResult<U::Out> {
    match (kind_of(value)?.as_str(), dynamics.robot()) {
        ("Residual", _) => {
            let sizes = [dynamics.ndx(), dynamics.nu()];
            then.with(UserResidual::read(value, sizes, raised)?)
        }
        ("InputError", _) => match references(value, dynamics.nu())?.as_deref() {
            None => then.with(InputError::to_zero(dynamics)),
            Some([one]) => then.with(InputError::to(one)),
            Some(all) => then.with(InputError::along(all)),
        },
        ("StateError", model) => match references(value, dynamics.nx())?.as_deref() {
            None => then.with(StateError::to(&rest(dynamics, model))),
            Some([one]) => then.with(StateError::to(one)),
            Some(all) => then.with(StateError::along(all)),
        },
        (kind, Some(model)) => with_robot_residual(model, kind, value, then),
        (other, None) => Err(invalid!(
            "a residual of the kind \"{other}\" is one of robots, and the dynamics are functions"
        )),
    }
}

/// The state that is meant where none is said: neutral of a robot, else zero.
fn rest(dynamics: &dyn AnySystem, model: Option<&Model>) -> Vec<f64> {
    match model {
        Some(model) => State::neutral(model).numbers().copied().collect(),
        None => vec![0.0; dynamics.nx()],
    }
}

/// The references of a residual, if there are any.
fn references(value: &Bound<'_, PyAny>, n: usize) -> PyResult<Option<Vec<Vec<f64>>>> {
    let reference = value.getattr("reference")?;
    match reference.is_none() {
        true => Ok(None),
        false => reference_rows("reference", &reference, n).map(Some),
    }
}

/// [`with_residual`] for residuals of robots alone.
fn with_robot_residual<U: Use>(
    model: &Model,
    kind: &str,
    value: &Bound<'_, PyAny>,
    then: U,
) -> PyResult<U::Out> {
    let frame = |name: &str| -> PyResult<FrameId> {
        let frame: String = attribute(value, name)?;
        model.find_frame(&frame).or_raise()
    };
    let target = || value.getattr("target");
    let three = || -> PyResult<[f64; 3]> { target()?.extract() };
    let six = || -> PyResult<[f64; 6]> { target()?.extract() };
    match kind {
        "FramePosition" => then.with(FramePosition::new(frame("frame")?, three()?)),
        "FrameOrientation" => {
            let target = read_pose("target", &target()?)?.rotation;
            then.with(FrameOrientation {
                frame: frame("frame")?,
                target,
            })
        }
        "FramePose" => then.with(FramePose {
            frame: frame("frame")?,
            target: read_pose("target", &target()?)?,
        }),
        "FrameVelocity" => {
            let name: String = attribute(value, "representation")?;
            then.with(FrameVelocity {
                frame: frame("frame")?,
                representation: named::<Representation>(model, &name)?,
                target: six()?,
            })
        }
        "FrameDistance" => {
            let from = value.getattr("from_")?;
            let from = match from.extract::<String>() {
                Ok(name) => Obstacle::Frame(model.find_frame(&name).or_raise()?),
                Err(_) => Obstacle::Point(from.extract::<[f64; 3]>()?.into()),
            };
            then.with(FrameDistance {
                frame: frame("frame")?,
                from,
            })
        }
        "LinkDistances" => {
            let pairs: Vec<(String, String)> = attribute(value, "pairs")?;
            let pairs: Vec<[&str; 2]> = pairs.iter().map(|(a, b)| [a.as_str(), b]).collect();
            let width: f64 = attribute(value, "smoothing")?;
            let shapes = guarded(|| LinkShapes::new(model).with_smoothing(width))?;
            let distances = LinkDistances::new(model, shapes, &pairs);
            let samples: usize = attribute(value, "samples_between")?;
            // A row of a Jacobian for each, at each stage.
            check_trajectories(1, samples.saturating_add(1), pairs.len() * (model.nv() + 1))?;
            then.with(distances.or_raise()?.with_samples_between(samples))
        }
        "CenterOfMass" => then.with(CenterOfMass {
            target: three()?.into(),
        }),
        "CentroidalMomentum" => then.with(CentroidalMomentum { target: six()? }),
        _ => Err(invalid!("residual is of the unknown kind \"{kind}\"")),
    }
}

/// One vector, or one for each stage.
pub(super) fn reference_rows(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    n: usize,
) -> PyResult<Vec<Vec<f64>>> {
    if numbers(name, value)?.ndim() == 1 {
        return Ok(vec![read_vector(name, value, Some(n))?]);
    }
    let matrix = read_matrix(name, value)?;
    if matrix.ncols() != n {
        return Err(shape_error(
            name,
            matrix.shape(),
            format_args!("(stages, {n})"),
        ));
    }
    Ok(matrix
        .row_iter()
        .map(|row| row.iter().copied().collect())
        .collect())
}
