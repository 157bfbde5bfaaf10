//! Sizes and densities of links as parameters.

use dualbody::model::{Dimension, Hardware, MassDistribution, ScaledLink};

use crate::prelude::*;

use Dimension::{Density, Length, Radius, X, Y, Z};
use MassDistribution::{Described, Homogeneous};

/// Links as Python chooses them: name, dimensions, distribution of mass.
type Links = Vec<(String, Vec<String>, String)>;

fn hardware_of(model: &Bound<'_, PyModel>, links: Option<&Links>) -> PyResult<Hardware> {
    let model = &*model.get().model;
    let links = match links {
        None => ScaledLink::all_of(model),
        Some(links) => links.iter().map(scaled).collect::<PyResult<_>>()?,
    };
    guarded(|| Hardware::new(model, &links))?.or_raise()
}

fn scaled((name, dimensions, masses): &(String, Vec<String>, String)) -> PyResult<ScaledLink> {
    let dimensions: Vec<Dimension> = dimensions
        .iter()
        .map(|own| variant("dimension", own, &[X, Y, Z, Radius, Length, Density]))
        .collect::<PyResult<_>>()?;
    let masses = variant("masses", masses, &[Described, Homogeneous])?;
    Ok(ScaledLink::new(name, &dimensions).with_mass_distribution(masses))
}

functions! {
    /// Names and nominal values of the parameters.
    fn _hardware(model: &Bound<'py, PyModel>, links: Option<Links>) -> PyResult<(Vec<String>, Bound<'py, PyAny>)> {
        let hardware = hardware_of(model, links.as_ref())?;
        let nominal = vector(model.py(), hardware.nominal());
        Ok((hardware.names().to_vec(), nominal.into_any()))
    }

    /// The robot with other values of the parameters.
    fn _hardware_model(model: &Bound<'py, PyModel>, links: Option<Links>, x) -> PyResult<PyModel> {
        let hardware = hardware_of(model, links.as_ref())?;
        let x = read_vector("x", x, Some(hardware.names().len()))?;
        let made = guarded(|| hardware.model(&x))?.or_raise()?;
        let recipe = (model, links, x).into_pyobject(model.py())?;
        Ok(PyModel::new(made, ("_hardware_model", recipe)))
    }

    /// Derivatives of all parameters of the model in those of the hardware.
    fn _hardware_jacobian(model: &Bound<'py, PyModel>, links: Option<Links>, x) -> PyResult<Array<'py>> {
        let hardware = hardware_of(model, links.as_ref())?;
        let x = read_vector("x", x, Some(hardware.names().len()))?;
        let jacobian = guarded(|| hardware.parameter_jacobian(&x))?.or_raise()?;
        Ok(matrix(model.py(), &jacobian))
    }
}
