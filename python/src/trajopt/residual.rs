//! Residuals, whatever their type.

use dualbody::Scalar;
use dualbody::contact::LinkShapes;
use dualbody::model::FrameId;
use dualbody::trajopt::{
    Activation, AnyResidual, AnySystem, CenterOfMass, CentroidalMomentum, FrameDistance,
    FrameOrientation, FramePose, FramePosition, FrameVelocity, InputError, LinkDistances, Node,
    Obstacle, Residual, StateError,
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

/// A residual of any type, behind the pointer that costs and constraints keep of it.
pub(super) struct Known(Box<dyn AnyResidual>);

impl Residual for Known {
    fn dim(&self, node: &Node<'_>) -> usize {
        self.0.dim(node)
    }

    /// Not called: costs and constraints call what is behind the pointer.
    fn eval<T: Scalar>(&self, _: &Node<'_, T>, _: &[T], _: &[T], r: &mut [T]) {
        r.fill(f64::NAN.into());
    }

    fn boxed(self) -> Box<dyn AnyResidual> {
        self.0
    }
}

/// Makes the residual that a class of Python describes.
pub(super) fn residual_of(
    dynamics: &dyn AnySystem,
    value: &Bound<'_, PyAny>,
    raised: &Raised,
) -> PyResult<Known> {
    let own = match (kind_of(value)?.as_str(), dynamics.robot()) {
        ("Residual", _) => {
            let sizes = [dynamics.ndx(), dynamics.nu()];
            UserResidual::read(value, sizes, raised)?.boxed()
        }
        ("InputError", _) => match references(value, dynamics.nu())?.as_deref() {
            None => InputError::to_zero(dynamics).boxed(),
            Some([one]) => InputError::to(one).boxed(),
            Some(all) => InputError::along(all).boxed(),
        },
        ("StateError", model) => match references(value, dynamics.nx())?.as_deref() {
            None => StateError::to(&rest(dynamics, model)).boxed(),
            Some([one]) => StateError::to(one).boxed(),
            Some(all) => StateError::along(all).boxed(),
        },
        (kind, Some(model)) => robot_residual_of(model, kind, value)?,
        (other, None) => refuse!(
            "a residual of the kind \"{other}\" is one of robots, and the dynamics are functions"
        ),
    };
    Ok(Known(own))
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

/// [`residual_of`] for residuals of robots alone.
fn robot_residual_of(
    model: &Model,
    kind: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<Box<dyn AnyResidual>> {
    let frame = || -> PyResult<FrameId> { named(model, &attribute::<String>(value, "frame")?) };
    let target = || value.getattr("target");
    let pose = || read_pose("target", &target()?);
    let three = || -> PyResult<[f64; 3]> { target()?.extract() };
    let six = || -> PyResult<[f64; 6]> { target()?.extract() };
    Ok(match kind {
        "FramePosition" => FramePosition::new(frame()?, three()?).boxed(),
        "FrameOrientation" => FrameOrientation {
            frame: frame()?,
            target: pose()?.rotation,
        }
        .boxed(),
        "FramePose" => FramePose {
            frame: frame()?,
            target: pose()?,
        }
        .boxed(),
        "FrameVelocity" => FrameVelocity {
            frame: frame()?,
            representation: named(model, &attribute::<String>(value, "representation")?)?,
            target: six()?,
        }
        .boxed(),
        "FrameDistance" => {
            let from = value.getattr("from_")?;
            let from = match from.extract::<String>() {
                Ok(name) => Obstacle::Frame(named(model, &name)?),
                Err(_) => Obstacle::Point(from.extract::<[f64; 3]>()?.into()),
            };
            let frame = frame()?;
            FrameDistance { frame, from }.boxed()
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
            let distances = distances.or_raise()?;
            distances.with_samples_between(samples).boxed()
        }
        "CenterOfMass" => CenterOfMass {
            target: three()?.into(),
        }
        .boxed(),
        "CentroidalMomentum" => CentroidalMomentum { target: six()? }.boxed(),
        _ => refuse!("residual is of the unknown kind \"{kind}\""),
    })
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
