//! Names of coordinates.

use super::simulator::Simulator;
use crate::joint::JointKind;
use crate::model::{BodyId, Model};
use crate::scalar::Scalar;

/// `<prefix>0`, `<prefix>1`, …
pub(crate) fn numbered(prefix: &str, n: usize) -> impl Iterator<Item = String> + '_ {
    (0..n).map(move |k| format!("{prefix}{k}"))
}

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
    let q = coordinate_names(model, JointKind::nq, BASE).map(|name| clean(format!("q.{name}")));
    let v = coordinate_names(model, JointKind::nv, BASE).map(|name| clean(format!("v.{name}")));
    q.chain(v).collect()
}

/// Name of a floating base in columns and inputs.
const BASE: &str = "base";

/// The name of the joint of each velocity coordinate, numbered where it has several; of a floating base `base`.
pub(super) fn tangent_names<P: Scalar>(model: &Model<P>) -> Vec<String> {
    coordinate_names(model, JointKind::nv, BASE).collect()
}

impl<P: Scalar> Simulator<P> {
    /// Name of each direction of the [tangent space](Self::n_tangent) of the state, which are the rows and columns of A: `q.<joint>` for a small
    /// displacement,
    /// `v.<joint>` for a velocity, numbered from 0 where a joint has several (`q.base.3` of a floating base turns it about its x axis), then
    /// `contact<k>` for the state of contact.
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
        let of = |prefix: &'static str| {
            let names = tangent_names(self.model()).into_iter();
            names.map(move |name| format!("{prefix}.{name}"))
        };
        let contact = numbered("contact", self.n_contact());
        of("q").chain(of("v")).chain(contact).collect()
    }
}

/// The name of the joint of each coordinate, `<joint>.0`, `<joint>.1`, … where it has several.
///
/// * `count` – number of coordinates of a joint
/// * `base` – name of a floating base
pub(crate) fn coordinate_names<'a, P: Scalar>(
    model: &'a Model<P>,
    count: fn(JointKind) -> usize,
    base: &'a str,
) -> impl Iterator<Item = String> + 'a {
    let bodies = model.bodies().iter().enumerate();
    let independent = bodies.filter(|(_, body)| body.coupling.is_none());
    independent.flat_map(move |(i, body)| {
        let name = model.part_name(BodyId(i));
        let name = name.unwrap_or_else(|| base.to_owned());
        match count(body.joint) {
            1 => vec![name],
            n => numbered(&format!("{name}."), n).collect(),
        }
    })
}
