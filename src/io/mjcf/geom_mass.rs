//! Masses that geoms state.

use super::entry::Entry;
use crate::error::LoadError;

/// Default density, kg/m³: water.
const DENSITY: f64 = 1000.0;

/// Mass of a geom.
#[derive(Clone, Copy, Debug)]
pub(super) struct Material {
    /// kg, if it is stated.
    pub(super) mass: Option<f64>,
    /// kg/m³ or kg/m².
    pub(super) density: f64,
    pub(super) is_shell: bool,
}

impl Material {
    pub(super) fn read(entry: &Entry<'_, '_>) -> Result<Self, LoadError> {
        let out = Self {
            density: entry.number("density")?.unwrap_or(DENSITY),
            mass: entry.number("mass")?,
            is_shell: entry.flag("shellinertia", false)?,
        };
        match (out.mass, out.density) {
            (Some(mass), _) if mass < 0.0 => Err(entry.malformed("mass", "is negative")),
            (_, density) if density < 0.0 => Err(entry.malformed("density", "is negative")),
            _ => Ok(out),
        }
    }

    pub(super) fn is_nothing(&self) -> bool {
        self.mass.unwrap_or(self.density) == 0.0
    }
}
