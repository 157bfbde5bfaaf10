//! States, forces and matrices in the coordinates of other engines.

use dualbody::sim::{Engine, EngineCoordinates};
use pyo3::types::PySlice;

use crate::prelude::*;

fn engine(name: &str) -> PyResult<Engine> {
    let choices = [
        ("pinocchio", Engine::Pinocchio),
        ("mujoco", Engine::MuJoCo),
        ("jaxsim", Engine::JaxSim),
    ];
    choice("engine", name, &choices)
}

/// Coordinates of this robot in another engine: "pinocchio", "mujoco" or "jaxsim".
///
/// joint_order: names of the joints as the engine lists them, if its order is another (`model.names` of Pinocchio); names that this robot does not
/// have are passed over. Functions named "…_to" take what is in the coordinates of this library, those named "…_from" what is in the engine's; q is
/// that of this library in all of them but configuration_from, which gives it. With T the engine's velocity over ours, v' = T v and tau' = T tau
/// (T is orthogonal), J' = J Tᵀ, M' = T M Tᵀ. What stands before the last axes is a batch. Pickles.
#[pyclass(frozen, name = "EngineCoordinates", module = "dualbody")]
pub(crate) struct PyEngineCoordinates {
    model: Py<PyModel>,
    engine: String,
    joint_order: Option<Vec<String>>,
}

getters! { PyEngineCoordinates {
    /// The robot.
    model: Py<PyModel> = |own, py| own.model.clone_ref(py);

    /// Name of the engine.
    engine: &str = |own| &own.engine;

    /// Number of the engine's configuration coordinates.
    nq: PyResult<usize> = |own| Ok(own.coordinates(&own.model.get().model)?.nq());
} }

impl PyEngineCoordinates {
    fn made(
        model: &Bound<'_, PyModel>,
        engine: &str,
        joint_order: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let joints = joint_order.as_deref().unwrap_or(&[]);
        let is_again = |k: &usize| joints[..*k].contains(&joints[*k]);
        if let Some(k) = (0..joints.len()).find(is_again) {
            refuse!("joint_order names \"{}\" twice", joints[k]);
        }
        let out = Self {
            model: model.clone().unbind(),
            engine: engine.to_owned(),
            joint_order,
        };
        out.coordinates(&model.get().model)?;
        Ok(out)
    }

    fn coordinates<'m>(&self, model: &'m Model) -> PyResult<EngineCoordinates<'m>> {
        let coordinates = EngineCoordinates::new(model, engine(&self.engine)?);
        match &self.joint_order {
            None => Ok(coordinates),
            Some(joints) => guarded(|| coordinates.with_joint_order(joints))?.or_raise(),
        }
    }

    /// Applies a function of rows.
    fn map<'py>(
        &self,
        given: &[Argument<'_, 'py>],
        tail: &[usize],
        one: impl Fn(&EngineCoordinates<'_>, &[&[f64]], &mut [f64]) + Sync,
    ) -> PyResult<Array<'py>> {
        let own = self.model.get();
        let coordinates = self.coordinates(&own.model)?;
        own.map(given, tail, &|x, out| one(&coordinates, x, out))
    }

    /// Applies a function of vectors, the first of which is q.
    fn vectors<'py>(
        &self,
        given: &[(&'static str, &Bound<'py, PyAny>)],
        one: impl Fn(&EngineCoordinates<'_>, &[&[f64]]) -> DVector<f64> + Sync,
    ) -> PyResult<Array<'py>> {
        let m = &self.model.get().model;
        let (nq, nv) = ([m.nq()], [m.nv()]);
        let of = |&(name, x)| argument(name, x, if name == "q" { &nq } else { &nv });
        let given: Vec<_> = given.iter().map(of).collect();
        self.map(&given, &nv, |coordinates, x, out| {
            out.copy_from_slice(one(coordinates, x).as_slice());
        })
    }

    /// Applies a function of the tangent map at q and a matrix with nv columns, and as many rows if it is square.
    fn matrices<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        (name, matrix): (&'static str, &Bound<'py, PyAny>),
        is_square: bool,
        one: impl Fn(DMatrix<f64>, &DMatrix<f64>) -> DMatrix<f64> + Sync,
    ) -> PyResult<Array<'py>> {
        let m = &self.model.get().model;
        let (nq, array) = ([m.nq()], numbers(name, matrix)?);
        let shape = array.shape();
        let rows = shape.len().checked_sub(2);
        let rows = rows.map(|k| if is_square { m.nv() } else { shape[k] });
        let expected = || shape_error(name, shape, format_args!("(…, rows, {})", m.nv()));
        let shape = [rows.ok_or_else(expected)?, m.nv()];
        let given = [
            argument("q", q, &nq),
            argument(name, array.as_any(), &shape),
        ];
        self.map(&given, &shape, |coordinates, x, out| {
            let matrix = DMatrix::from_row_slice(shape[0], shape[1], x[1]);
            write_matrix(&one(coordinates.tangent_map(x[0]), &matrix), out);
        })
    }

    fn slice<'py>(
        &self,
        py: Python<'py>,
        joint: &str,
        of: impl Fn(&EngineCoordinates<'_>, dualbody::model::JointId) -> std::ops::Range<usize>,
    ) -> PyResult<Bound<'py, PySlice>> {
        let m = &self.model.get().model;
        let range = of(&self.coordinates(m)?, m.find_joint(joint).or_raise()?);
        Ok(slice(py, range))
    }
}

#[pymethods]
impl PyEngineCoordinates {
    /// Range of a joint in the engine's configuration.
    fn joint_q<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        self.slice(py, name, |own, joint| own.joint_q(joint))
    }

    /// Range of a joint in the engine's velocities and forces.
    fn joint_v<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        self.slice(py, name, |own, joint| own.joint_v(joint))
    }

    /// Configuration in the engine's coordinates, (..., its nq). q (..., nq).
    fn configuration_to<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let nq = [self.model.get().model.nq()];
        self.map(
            &[argument("q", q, &nq)],
            &[self.nq()?],
            |coordinates, x, out| {
                out.copy_from_slice(coordinates.configuration_to(x[0]).as_slice());
            },
        )
    }

    /// Configuration of this robot, (..., nq), from that of the engine, (..., its nq). Angles given as (cos, sin) become angles in (−π, π].
    fn configuration_from<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let tail = [self.model.get().model.nq()];
        self.map(
            &[argument("q", q, &[self.nq()?])],
            &tail,
            |coordinates, x, out| {
                out.copy_from_slice(coordinates.configuration_from(x[0]).as_slice());
            },
        )
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> Recipe<'py> {
        let (py, own) = (this.py(), this.get());
        let parts = (
            own.model.clone_ref(py),
            &own.engine,
            own.joint_order.clone(),
        );
        let parts = parts.into_pyobject(py)?.into_any();
        Ok((this.get_type().into_any(), parts))
    }

    fn __repr__(&self) -> String {
        let name = self.model.get().model.name();
        format!("EngineCoordinates(\"{name}\", \"{}\")", self.engine)
    }
}

methods! { PyEngineCoordinates {
    #[new]
    fn new(model: &Bound<'py, PyModel>, engine: &str, joint_order: Option<Vec<String>> = None) -> PyResult<Self> {
        Self::made(model, engine, joint_order)
    }
} }

methods! { PyEngineCoordinates {
    /// Velocity, small displacement or gradient in the engine's coordinates, (..., nv). q (..., nq), v (..., nv).
    fn tangent_to(&self, q, v) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("v", v)], |own, x| own.tangent_to(x[0], x[1]))
    }

    /// Velocity, small displacement or gradient of this library from the engine's, (..., nv). q (..., nq), v (..., nv).
    fn tangent_from(&self, q, v) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("v", v)], |own, x| own.tangent_from(x[0], x[1]))
    }

    /// Joint forces in the engine's coordinates, (..., nv), of the same power: tau'·v' = tau·v. q (..., nq), tau (..., nv).
    fn force_to(&self, q, tau) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("tau", tau)], |own, x| own.tangent_to(x[0], x[1]))
    }

    /// Joint forces of this library from the engine's, (..., nv). q (..., nq), tau (..., nv).
    fn force_from(&self, q, tau) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("tau", tau)], |own, x| own.tangent_from(x[0], x[1]))
    }

    /// Acceleration in the engine's coordinates, the rate of the velocity there, (..., nv). q (..., nq), v and a (..., nv) of this library.
    fn acceleration_to(&self, q, v, a) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("v", v), ("a", a)], |own, x| own.acceleration_to(x[0], x[1], x[2]))
    }

    /// Acceleration of this library from the engine's, (..., nv). q (..., nq) and v (..., nv) of this library, a (..., nv) of the engine.
    fn acceleration_from(&self, q, v, a) -> PyResult<Array<'py>> {
        self.vectors(&[("q", q), ("v", v), ("a", a)], |own, x| own.acceleration_from(x[0], x[1], x[2]))
    }

    /// Jacobian whose columns are the engine's directions, (..., rows, nv); its rows stay. q (..., nq), jacobian (..., rows, nv).
    fn jacobian_to(&self, q, jacobian) -> PyResult<Array<'py>> { self.matrices(q, ("jacobian", jacobian), false, |t, x| x * t.transpose()) }

    /// Jacobian of this library from one whose columns are the engine's directions, (..., rows, nv). q (..., nq), jacobian (..., rows, nv).
    fn jacobian_from(&self, q, jacobian) -> PyResult<Array<'py>> { self.matrices(q, ("jacobian", jacobian), false, |t, x| x * t) }

    /// Mass matrix, its inverse or another symmetric matrix in the engine's coordinates, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv).
    fn mass_matrix_to(&self, q, mass_matrix) -> PyResult<Array<'py>> { self.matrices(q, ("mass_matrix", mass_matrix), true, |t, x| &t * x * t.transpose()) }

    /// Mass matrix, its inverse or another symmetric matrix of this library from the engine's, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv).
    fn mass_matrix_from(&self, q, mass_matrix) -> PyResult<Array<'py>> { self.matrices(q, ("mass_matrix", mass_matrix), true, |t, x| t.tr_mul(x) * t) }
} }

methods! { PyModel {
    /// State of this robot in the coordinates of "pinocchio", "mujoco" or "jaxsim": (q, v). Joints may be in another order. q (..., nq), v (..., nv);
    /// `EngineCoordinates` has forces, accelerations and matrices too.
    fn to_engine(this: &Bound<'py, Self>, engine: &str, q, v, joint_order: Option<Vec<String>> = None) -> PyResult<(Array<'py>, Array<'py>)> {
        let coordinates = PyEngineCoordinates::made(this, engine, joint_order)?;
        Ok((coordinates.configuration_to(q)?, coordinates.tangent_to(q, v)?))
    }

    /// State (q, v) of this robot from the coordinates of "pinocchio", "mujoco" or "jaxsim". q (..., the engine's nq), v (..., nv).
    fn from_engine(this: &Bound<'py, Self>, engine: &str, q, v, joint_order: Option<Vec<String>> = None) -> PyResult<(Array<'py>, Array<'py>)> {
        let coordinates = PyEngineCoordinates::made(this, engine, joint_order)?;
        let q = coordinates.configuration_from(q)?;
        let v = coordinates.tangent_from(q.as_any(), v)?;
        Ok((q, v))
    }
} }
