//! Robots and simulators that compiled programs use.

use std::collections::HashMap;
use std::sync::{PoisonError, RwLock};

use crate::prelude::*;

/// Bytes of the digest by which a robot is known.
const DIGEST: usize = 16;

/// A model or simulator that a compiled program uses. It is never freed, since the lifetime of the program is unknown.
pub(super) enum Used {
    Model(Py<PyModel>),
    Simulator(Py<PySimulator>),
}

#[derive(Default)]
struct Registry {
    /// Names by the number of the object, so that each is digested once.
    names: HashMap<u64, String>,
    used: HashMap<String, &'static Used>,
}

static REGISTRY: RwLock<Option<Registry>> = RwLock::new(None);

/// The name of a model or simulator in programs: a digest of what it is.
#[pyfunction]
pub(crate) fn _foreign_name(of: &Bound<'_, PyAny>) -> PyResult<String> {
    let (id, used) = if let Ok(model) = of.cast::<PyModel>() {
        (model.get().id, Used::Model(model.clone().unbind()))
    } else if let Ok(simulator) = of.cast::<PySimulator>() {
        let used = Used::Simulator(simulator.clone().unbind());
        (simulator.get().id(), used)
    } else {
        return Err(type_error("a Model or a Simulator is expected"));
    };
    let known = REGISTRY.read().unwrap_or_else(PoisonError::into_inner);
    if let Some(name) = known.as_ref().and_then(|known| known.names.get(&id)) {
        return Ok(name.clone());
    }
    drop(known);
    let name = digest(of)?;
    let mut known = REGISTRY.write().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    known.names.insert(id, name.clone());
    let used = || &*Box::leak(Box::new(used));
    known.used.entry(name.clone()).or_insert_with(used);
    Ok(name)
}

fn digest(of: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = of.py();
    let bytes = py.import("pickle")?.call_method1("dumps", (of,))?;
    let options = dict!(py; digest_size = DIGEST);
    let digest = py.import("hashlib")?.getattr("blake2b")?;
    let digest = digest.call((bytes,), Some(&options))?;
    digest.call_method0("hexdigest")?.extract()
}

/// Finds the object of a name.
pub(super) fn find(name: &str) -> Result<&'static Used, String> {
    let known = REGISTRY.read().unwrap_or_else(PoisonError::into_inner);
    let found = known
        .as_ref()
        .and_then(|known| known.used.get(name).copied());
    found.ok_or_else(|| {
        format!("no robot of this process is {name}: use it once with dualbody.jax, then load programs of other processes")
    })
}
