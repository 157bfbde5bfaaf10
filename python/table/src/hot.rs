//! Functions with working memory.

use dualbody::contact::Contacts;
use dualbody::dynamics::{
    self as d, AbaScratch, CoriolisScratch, CrbaScratch, ForwardDynamicsDerivatives,
    ForwardDynamicsDerivativesScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, MassMatrixInverseScratch,
};
use dualbody::scalar::Differentiable;
use dualbody::sim::ContactReport;
use dualbody::{Model, Over, Scalar, Simulator, State};
use nalgebra::DVector;

use crate::Memory;
use crate::write::{write_all, write_matrix};

/// A function that computes a row from rows, with a workspace.
macro_rules! rows {
    ($($name:ident, $m:ident, $memory:ident, $x:ident, $out:ident => $body:block)*) => { $(
        /// The function of this name of `dynamics`.
        pub fn $name<P: Scalar, T: Over<P> + Differentiable>($m: &Model<P>, $memory: &mut Memory<T>, $x: &[&[T]], $out: &mut [T]) $body
    )* };
}

rows! {
    inverse_dynamics, m, memory, x, out => {
        memory.read_external(x.get(3));
        d::inverse_dynamics_into(m, x[0], x[1], x[2], &memory.external, &mut memory.rnea, out);
    }
    bias_forces, m, memory, x, out => {
        memory.read_external(x.get(2));
        d::bias_forces_into(m, x[0], x[1], &memory.external, &mut memory.rnea, out);
    }
    forward_dynamics, m, memory, x, out => {
        memory.read_external(x.get(3));
        let scratch = memory.aba.get_or_insert_with(|| AbaScratch::new(m));
        d::forward_dynamics_into(m, x[0], x[1], x[2], &memory.external, scratch, out);
    }
    mass_matrix, m, memory, x, out => {
        let scratch = memory.crba.get_or_insert_with(|| CrbaScratch::new(m));
        d::mass_matrix_into(m, x[0], scratch, &mut memory.square);
        // Symmetric: columns are rows.
        out.copy_from_slice(memory.square.as_slice());
    }
    mass_matrix_inverse, m, memory, x, out => {
        let scratch = memory.inverse.get_or_insert_with(|| MassMatrixInverseScratch::new(m));
        d::mass_matrix_inverse_into(m, x[0], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    }
    coriolis_matrix, m, memory, x, out => {
        let scratch = memory.coriolis.get_or_insert_with(|| CoriolisScratch::new(m));
        d::coriolis_matrix_into(m, x[0], x[1], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    }
    inverse_dynamics_derivatives, m, memory, x, out => {
        let new = || (InverseDynamicsDerivativesScratch::new(m), InverseDynamicsDerivatives::zeros(m));
        let (scratch, all) = memory.inverse_derivatives.get_or_insert_with(new);
        d::inverse_dynamics_derivatives_into(m, x[0], x[1], x[2], &[], scratch, all);
        write_all([&all.dq, &all.dv, &all.da], out);
    }
    forward_dynamics_derivatives, m, memory, x, out => {
        let new = || (ForwardDynamicsDerivativesScratch::new(m), ForwardDynamicsDerivatives::zeros(m));
        let (scratch, all) = memory.forward_derivatives.get_or_insert_with(new);
        d::forward_dynamics_derivatives_into(m, x[0], x[1], x[2], &[], scratch, all);
        write_all([&all.dq, &all.dv, &all.dtau], out);
    }
}

/// The state of (q, v, u, contact); contact has the activations behind it, and is neutral where none is given.
pub fn state<T: Scalar>(simulator: &Simulator<T>, x: &[&[T]]) -> State<T> {
    let state = simulator.state(x[0], x[1]);
    match x.get(3) {
        Some(numbers) => {
            let (contact, activation) = numbers.split_at(simulator.n_contact());
            let state = state.with_contact(DVector::from_column_slice(contact));
            state.with_activation(DVector::from_column_slice(activation))
        }
        None => state,
    }
}

/// Report on what touches, and how.
pub fn contact_report<T: Scalar>(simulator: &Simulator<T>, x: &[&[T]]) -> ContactReport<T> {
    simulator.contact_report(&state(simulator, x), x[2])
}

/// The contacts of a simulator.
///
/// # Panics
/// If there are no contacts.
pub fn contacts<T: Scalar>(simulator: &Simulator<T>) -> &Contacts<T> {
    (simulator.contacts()).expect("the simulator has no contacts")
}

/// Number of points of contact.
pub fn points(simulator: &Simulator) -> usize {
    simulator
        .contacts()
        .map_or(0, |contacts| contacts.points().len())
}
