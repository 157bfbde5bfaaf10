//! Names of coordinates.

use super::simulator::Simulator;
use crate::joint::JointKind;
use crate::model::{Model, numbered};
use crate::scalar::Scalar;

/// A name without the characters that would break a table.
fn clean(name: String) -> String {
    name.replace([',', '"', '\n', '\r'], "_")
}

/// Names of inputs as columns of a table: `u.<name>`, or `u0`, `u1`, … where there is not a name for each of them.
///
/// * `names` – what the inputs act on
/// * `n` – number of inputs
pub(crate) fn input_columns(names: &[String], n: usize) -> Vec<String> {
    match names.len() == n {
        true => names
            .iter()
            .map(|name| clean(format!("u.{name}")))
            .collect(),
        false => numbered("u", n).collect(),
    }
}

/// Names of the coordinates of q, then of v, as columns of a table.
pub(crate) fn column_names(model: &Model) -> Vec<String> {
    let q = prefixed("q", model, JointKind::nq);
    q.chain(prefixed("v", model, JointKind::nv))
        .map(clean)
        .collect()
}

/// Name of a floating base in columns and inputs.
const BASE: &str = "base";

/// The name of the joint of each velocity coordinate, numbered where it has several; of a floating base `base`.
pub(super) fn velocity_names<P: Scalar>(model: &Model<P>) -> Vec<String> {
    model.coordinate_names(JointKind::nv, BASE).collect()
}

/// `<prefix>.<joint>` of each coordinate, of which a joint has `count`.
fn prefixed<'a, P: Scalar>(
    prefix: &'a str,
    model: &'a Model<P>,
    count: fn(JointKind) -> usize,
) -> impl Iterator<Item = String> + 'a {
    let names = model.coordinate_names(count, BASE);
    names.map(move |name| format!("{prefix}.{name}"))
}

impl<P: Scalar> Simulator<P> {
    /// Name of each direction of the [tangent space](Self::n_tangent) of the state, which are the rows and columns of A: `q.<joint>` for a small
    /// displacement,
    /// `v.<joint>` for a velocity, numbered from 0 where a joint has several (`q.base.3` of a floating base turns it about its x axis), then
    /// `contact<k>` for the contact state.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let cartpole = Simulator::new(samples::cartpole());
    /// let names = cartpole.tangent_names();
    /// assert_eq!(names, ["q.linear", "q.pivot", "v.linear", "v.pivot"]);
    /// let speed = names.iter().position(|name| name == "v.linear").unwrap();
    /// let step = cartpole.linearize(&State::new(&[0.0; 2], &[0.0; 2]), &[0.0; 2]);
    /// assert!(step.b[(speed, 0)] > 0.0);
    /// ```
    pub fn tangent_names(&self) -> Vec<String> {
        let of = |prefix| prefixed(prefix, self.model(), JointKind::nv);
        let contact = numbered("contact", self.n_contact());
        of("q").chain(of("v")).chain(contact).collect()
    }

    /// The name of the joint of a velocity coordinate, numbered where it has several.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub(crate) fn tangent_name(&self, k: usize) -> String {
        velocity_names(self.model()).swap_remove(k)
    }
}
