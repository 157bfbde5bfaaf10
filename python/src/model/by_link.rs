//! Masses link by link.

use crate::prelude::*;

#[pymethods]
impl PyModel {
    /// Mass of a link, kg: of the link alone, also if several fixed links form one body.
    fn link_mass(&self, link: &str) -> PyResult<f64> {
        Ok(self.model.link_inertia(link).or_raise()?.mass)
    }

    /// Centre of mass of a link in its frame, (3,), m; NaN for a link without mass.
    fn link_center_of_mass<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Bound<'py, PyAny>> {
        let com = self.model.link_inertia(link).or_raise()?.com();
        Ok(vector(py, com.as_slice()))
    }

    /// Inertia of a link in its frame, (6, 6), rows and columns [linear; angular].
    fn link_inertia<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Array<'py>> {
        let array = empty(py, &[6, 6]);
        let inertia = self.model.link_inertia(link).or_raise()?.to_matrix();
        // Symmetric: columns are rows.
        numbers_mut(&array).copy_from_slice(inertia.as_slice());
        Ok(array)
    }

    /// Masses of all links in the order of link_names, (n_links,), kg.
    #[getter]
    fn link_masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let all = self.model.link_inertias();
        vector(
            py,
            &all.iter().map(|inertia| inertia.mass).collect::<Vec<_>>(),
        )
    }

    /// Inertias of all links in their frames, in the order of link_names, (n_links, 6, 6).
    #[getter]
    fn link_inertias<'py>(&self, py: Python<'py>) -> Array<'py> {
        let all = self.model.link_inertias();
        let array = empty(py, &[all.len(), 6, 6]);
        for (inertia, out) in all.iter().zip(numbers_mut(&array).chunks_mut(36)) {
            out.copy_from_slice(inertia.to_matrix().as_slice());
        }
        array
    }
}
