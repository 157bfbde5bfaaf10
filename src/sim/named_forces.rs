//! Steps under forces given by name.

use nalgebra::DVector;

use super::force::ExternalForce;
use super::names::velocity_names;
use super::simulator::Simulator;
use super::state::State;
use crate::constraint::Anchor;
use crate::dynamics::{NamedForces, joint_forces};
use crate::error::UnknownName;
use crate::spatial::{Force, Representation};

impl Simulator<f64> {
    /// Advances by one time step under forces given by name. Forces along joints are inputs; forces on frames are added to the external forces of the
    /// simulator. Allocates a simulator with them; for many steps under the same forces, [`with_frame_forces`](Self::with_frame_forces) and
    /// [`inputs_of`](Self::inputs_of) make it once.
    ///
    /// # Errors
    /// If there is a force along a joint that has no input.
    ///
    /// # Panics
    /// If the state has the wrong length, the forces are those of another model, or one is not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::dynamics::NamedForces;
    /// use dualbody::spatial::{Force, Representation};
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let joint = simulator.model().joint_names()[0].to_owned();
    /// let mut forces = NamedForces::default();
    /// forces.set_joint_forces(simulator.model(), &[(&joint, &[2.0])])?;
    /// let next = simulator.step_with_forces(&State::new(&[0.0], &[0.0]), &forces)?;
    /// assert!((next.v[0] - 0.01 * 2.0 * 3.0).abs() < 1e-15); // Δt u / J with J = 1/3 kg·m²
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn step_with_forces(
        &self,
        state: &State,
        forces: &NamedForces,
    ) -> Result<State, UnknownName> {
        let u = self.inputs_of(forces)?;
        let forced = self.clone().with_frame_forces(forces);
        Ok(forced.step(state, u.as_slice()))
    }

    /// The input u (length `nu`) of forces along joints by name; zero for inputs without a force and for frame actuators. Allocates.
    ///
    /// # Errors
    /// If there is a force along a joint that has no input.
    ///
    /// # Panics
    /// If the forces are those of another model.
    pub fn inputs_of(&self, forces: &NamedForces) -> Result<DVector<f64>, UnknownName> {
        let tau = joint_forces(self.model(), forces);
        let idle = |k: &usize| tau[*k] != 0.0 && !self.actuated().contains(k);
        if let Some(k) = (0..tau.len()).find(idle) {
            return Err(UnknownName {
                model: self.model().name().into(),
                element: "actuated joint".into(),
                name: velocity_names(self.model()).swap_remove(k),
                known: self.input_names(),
            });
        }
        let mut u = DVector::zeros(self.nu());
        for (u, &k) in u.iter_mut().zip(self.actuated()) {
            *u = tau[k];
        }
        Ok(u)
    }

    /// Adds the forces on frames by name to the external forces, constant in the representation of each. Forces along joints are ignored: they are
    /// [inputs](Self::inputs_of). A force on a frame that is fixed to the world has no effect.
    ///
    /// # Panics
    /// If the forces are those of another model, or one is not finite.
    #[must_use]
    pub fn with_frame_forces(self, forces: &NamedForces) -> Self {
        let mut all = self.external_forces().to_vec();
        let on_bodies = forces
            .on_frames()
            .filter_map(|(frame, force, representation)| {
                let frame = self.model().frame_of(frame);
                frame.body?;
                let place = Anchor::frame(self.model(), &frame.name).ok()?;
                Some(constant(place, force, representation))
            });
        all.extend(on_bodies);
        self.with_external_forces(all)
    }
}

fn constant(place: Anchor, force: &Force<f64>, representation: Representation) -> ExternalForce {
    ExternalForce::constant(place, *force, representation)
}
