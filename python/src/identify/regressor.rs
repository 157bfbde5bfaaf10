//! Regressors and base parameters.

use dualbody::identify::{BaseParameters, DryFriction, Regressor};

use crate::prelude::*;

/// Dry friction (shape, number) from its description in Python.
pub(super) fn friction_of(given: Option<(String, f64)>) -> PyResult<Option<DryFriction>> {
    let one = |(shape, x): (String, f64)| {
        let smooth = DryFriction::Smooth { slip_velocity: x };
        let sign = DryFriction::Sign { dead_zone: x };
        choice(
            "dry_friction",
            &shape,
            &[("smooth", smooth), ("sign", sign)],
        )
    };
    given.map(one).transpose()
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
    let (nq, nv) = ([own.model.nq()], [own.model.nv()]);
    let given = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("a", a, &nv),
    ];
    own.map(&given, tail, &|x, out| one([x[0], x[1], x[2]], out))
}

functions! {
    /// Y of states, (…, nv, unknowns).
    fn _regressor_matrix(regressor, q, v, a) -> PyResult<Array<'py>> {
        let own = regressor_of(regressor)?;
        let tail = [own.model().nv(), own.names().len()];
        map_motion(&model_of(regressor)?, [q, v, a], &tail, &|[q, v, a], out| write_matrix(&own.matrix(q, v, a), out))
    }

    /// The combinations of unknowns that motion tells: (independent, dependent, combination, without effect, meanings).
    fn _base_parameters(regressor) -> PyResult<Bound<'py, PyTuple>> {
        let (py, base) = (regressor.py(), BaseParameters::new(&regressor_of(regressor)?));
        let meanings: Vec<String> = (0..base.len()).map(|k| base.meaning(k)).collect();
        (&base.independent, &base.dependent, matrix(py, &base.combination), &base.without_effect, meanings).into_pyobject(py)
    }
}
