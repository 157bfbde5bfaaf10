//! Regressors and base parameters.

use dualbody::identify::{BaseParameters, DryFriction, Regressor};

use crate::prelude::*;

/// Dry friction (shape, number) from its description in Python.
pub(super) fn friction_of(given: Option<(String, f64)>) -> PyResult<Option<DryFriction>> {
    given
        .map(|(shape, number)| {
            let choices = [
                (
                    "smooth",
                    DryFriction::Smooth {
                        slip_velocity: number,
                    },
                ),
                ("sign", DryFriction::Sign { dead_zone: number }),
            ];
            choice("dry_friction", &shape, &choices)
        })
        .transpose()
}

/// The robot of a description in Python.
pub(super) fn model_of<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyModel>> {
    Ok(value.getattr("model")?.cast_into::<PyModel>()?)
}

pub(super) fn regressor_of(value: &Bound<'_, PyAny>) -> PyResult<Regressor> {
    let known: Vec<String> = attribute(value, "known_links")?;
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let flag = |name: &str| -> PyResult<bool> { attribute(value, name) };
    let mut out = Regressor::new(&model_of(value)?.get().model)
        .with_known_links(&known)
        .or_raise()?;
    if flag("damping")? {
        out = out.with_damping();
    }
    if flag("armature")? {
        out = out.with_armature();
    }
    if let Some(shape) = friction_of(attribute(value, "dry_friction")?)? {
        out = out.with_dry_friction(shape).or_raise()?;
    }
    if flag("offsets")? {
        out = out.with_offsets();
    }
    Ok(out)
}

functions! {
    /// Names and nominal values of the unknowns.
    fn _regressor(regressor) -> PyResult<(Vec<String>, Bound<'py, PyAny>)> {
        let own = regressor_of(regressor)?;
        let nominal = vector(regressor.py(), own.nominal().as_slice());
        Ok((own.names().to_vec(), nominal.into_any()))
    }
}

/// Applies a function of q, v and a to each of a motion.
///
/// * `tail` – shape of the result of one
pub(super) fn map_motion<'py>(
    model: &Bound<'py, PyModel>,
    motion: [&Bound<'py, PyAny>; 3],
    tail: &[usize],
    one: &(dyn Fn([&[f64]; 3], &mut [f64]) + Sync),
) -> PyResult<Array<'py>> {
    let (own, [q, v, a]) = (model.get(), motion);
    let (nq, nv) = (own.model.nq(), own.model.nv());
    let given = [("q", q, nq), ("v", v, nv), ("a", a, nv)];
    own.map(model.py(), &given, tail, &|x, out| {
        one([x[0], x[1], x[2]], out)
    })
}

functions! {
    /// Y of states, (…, nv, unknowns).
    fn _regressor_matrix(regressor, q, v, a) -> PyResult<Array<'py>> {
        let own = regressor_of(regressor)?;
        let tail = [own.model().nv(), own.names().len()];
        map_motion(
            &model_of(regressor)?,
            [q, v, a],
            &tail,
            &|[q, v, a], out| {
                write_matrix(&own.matrix(q, v, a), out);
            },
        )
    }
}

/// (independent, dependent, combination, without effect, meanings).
type Base<'py> = (Vec<usize>, Vec<usize>, Array<'py>, Vec<usize>, Vec<String>);

/// The combinations of unknowns that motion tells.
#[pyfunction]
pub(crate) fn _base_parameters<'py>(regressor: &Bound<'py, PyAny>) -> PyResult<Base<'py>> {
    let (py, own) = (regressor.py(), regressor_of(regressor)?);
    let base = guarded(|| BaseParameters::new(&own))?;
    let meanings = (0..base.len()).map(|k| base.meaning(k)).collect();
    Ok((
        base.independent.clone(),
        base.dependent.clone(),
        matrix(py, &base.combination),
        base.without_effect.clone(),
        meanings,
    ))
}
