//! Regressors, base parameters, motions that excite.

use dualbody::identify::{
    BaseParameters, DryFriction, Excitation, ExcitationOptions, Regressor, excite,
};

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

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ExcitationOptions> {
    read_options!(ExcitationOptions, "excite", value;
        period, harmonics, range, reach, speed, acceleration, force_deviations, max_iterations, starts, seed)
}

functions! {
    /// Finds a periodic motion that tells much of the unknowns: (period, centre, coefficients, condition, condition of the start).
    fn _excite(py: Python, regressor, options: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyTuple>> {
        let (regressor, options) = (regressor_of(regressor)?, options_of(options)?);
        let found = on_pool_stopped(py, || excite(&regressor, &options))?;
        let found = found.or_raise()?;
        let (center, coefficients) = (vector(py, &found.center), matrix(py, &found.coefficients));
        (found.period, center, coefficients, found.condition, found.start_condition).into_pyobject(py)
    }

    /// Configurations, velocities and accelerations of a motion at times, (times, n) each.
    fn _excited(py: Python, motion, times) -> PyResult<[Array<'py>; 3]> {
        let center = read_vector("center", &motion.getattr("center")?, None)?;
        let (n, times) = (center.len(), read_vector("times", times, None)?);
        let motion = Excitation {
            period: attribute(motion, "period")?,
            coefficients: read_matrix("coefficients", &motion.getattr("coefficients")?)?,
            condition: attribute(motion, "condition")?,
            start_condition: attribute(motion, "start_condition")?,
            center,
        };
        let out = [(); 3].map(|()| empty(py, &[times.len(), n]));
        for (k, &time) in times.iter().enumerate() {
            let at = motion.at(time);
            for (out, x) in out.iter().zip([&at.q, &at.v, &at.a]) {
                numbers_mut(out)[k * n..(k + 1) * n].copy_from_slice(x.as_slice());
            }
        }
        Ok(out)
    }
}
