//! Variables of the robot that shooting adjusts, and where they go.

use nalgebra::DMatrix;

use super::Adjustable;
use super::body::Body;
use crate::identify::consistent::possible;
use crate::identify::error::IdentifyError;
use crate::identify::estimate::Interval;
use crate::model::{ParameterGroup, ParameterLayout};
use crate::nested::IntoNested;
use crate::numbers::Domain;
use crate::sim::{Simulator, SimulatorParameterGroup as Group};
use crate::spatial::INERTIAL_PARAMETERS;

/// Places of a number in the vector of [parameters](Simulator::parameters), with the parameter over the number: several where it is shared.
pub(super) type Target = Vec<(usize, f64)>;

/// Variables of the robot: its numbers themselves, of inertias the standard parameters, which move along [directions](Body) of their own.
#[derive(Default)]
pub(super) struct Variables {
    /// The first variable of each inertia.
    inertias: Vec<usize>,
    pub(super) targets: Vec<Target>,
    names: Vec<String>,
    /// Those of the nominal robot.
    pub(super) nominal: Vec<f64>,
    pub(super) domains: Vec<Domain>,
}

impl Variables {
    /// # Errors
    /// If a name is unknown, or a number is none that a descent may take anywhere.
    pub(super) fn new(
        simulator: &Simulator,
        adjustable: &[Adjustable],
    ) -> Result<Self, IdentifyError> {
        let (mut out, layout) = (Self::default(), simulator.parameter_layout());
        for own in adjustable {
            match own {
                Adjustable::Inertia(link) => out.add_inertia(simulator, &layout, link)?,
                Adjustable::LinkMass(link) => out.add_mass(simulator, &layout, link)?,
                Adjustable::Parameter(name) => out.add_parameter(simulator, &layout, name)?,
                Adjustable::Friction(points) => out.add_friction(simulator, &layout, points)?,
            }
        }
        Ok(out)
    }

    fn add_inertia(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        link: &str,
    ) -> Result<(), IdentifyError> {
        let model = simulator.model();
        let frame = model.find_frame(link)?;
        let body = model.frames()[frame.0].body;
        let body = body.ok_or_else(|| IdentifyError::option(link, "it does not move"))?;
        let group = Group::Model(ParameterGroup::Inertia(body));
        let range = layout.range(group).unwrap_or_default();
        self.names.extend_from_slice(&layout.names()[range.clone()]);
        self.targets.extend(range.map(|index| vec![(index, 1.0)]));
        self.inertias.push(self.nominal.len());
        self.nominal.extend(possible(model, body).to_parameters());
        self.domains.extend([Domain::Finite; INERTIAL_PARAMETERS]);
        Ok(())
    }

    fn add_mass(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        link: &str,
    ) -> Result<(), IdentifyError> {
        let model = simulator.model();
        let body = model.frames()[model.find_frame(link)?.0].body;
        let body = body.ok_or_else(|| IdentifyError::option(link, "it does not move"))?;
        let mass = model.body(body).inertia.mass;
        if mass <= 0.0 {
            return Err(IdentifyError::option(link, "it has no mass to scale"));
        }
        let group = Group::Model(ParameterGroup::Inertia(body));
        let range = layout.range(group).unwrap_or_default();
        let parameters = simulator.parameters();
        let target = range.map(|index| (index, parameters[index] / mass));
        let name = format!("{link}: mass with its moments");
        self.push(target.collect(), name, mass, Domain::Positive);
        Ok(())
    }

    fn add_parameter(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        name: &str,
    ) -> Result<(), IdentifyError> {
        let index = layout.find(name)?;
        if layout
            .range(Group::TimeStep)
            .is_some_and(|own| own.contains(&index))
        {
            return Err(IdentifyError::option(name, "the rate of the log sets it"));
        }
        let domain = layout.domains()[index];
        if bounds(domain).is_none() {
            let reason = "the fit could leave its domain";
            return Err(IdentifyError::option(name, reason));
        }
        let value = simulator.parameters()[index];
        self.push(vec![(index, 1.0)], name.into(), value, domain);
        Ok(())
    }

    fn add_friction(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        points: &[usize],
    ) -> Result<(), IdentifyError> {
        let error = |reason| IdentifyError::option("friction", reason);
        let of = |&k: &usize| {
            let mut law = layout.range(Group::ContactLaw(k))?;
            let found = law.find(|&index| layout.names()[index].ends_with(": friction"));
            found.map(|index| (index, 1.0))
        };
        let target: Option<Target> = points.iter().map(of).collect();
        let target = target.filter(|target| !target.is_empty());
        let target = target.ok_or_else(|| error("there are no such contact points"))?;
        let parameters = simulator.parameters();
        if target
            .iter()
            .any(|&(index, _)| !parameters[index].is_finite())
        {
            return Err(error("that of a point is infinite"));
        }
        let name = format!("friction of points {points:?}");
        let first = parameters[target[0].0];
        self.push(target, name, first, Domain::NotNegative);
        Ok(())
    }

    fn push(&mut self, target: Target, name: String, value: f64, domain: Domain) {
        self.targets.push(target);
        self.names.push(name);
        self.nominal.push(value);
        self.domains.push(domain);
    }

    pub(super) fn len(&self) -> usize {
        self.nominal.len()
    }

    /// Whether parameters of the robot, one for each variable, are in their domains.
    pub(super) fn make_sense(&self, values: &[f64]) -> bool {
        let mut pairs = self.domains.iter().zip(values);
        pairs.all(|(domain, &x)| x.is_finite() && domain.contains(x))
    }

    /// Number of residuals of [`distances`](Self::distances).
    pub(super) fn n_distances(&self) -> usize {
        INERTIAL_PARAMETERS * self.inertias.len()
    }

    /// Distances of the log-Cholesky parameters of all inertias from the nominal ones, which know no units and grow without bounds where a body ceases to be one.
    /// Not finite where there is none.
    pub(super) fn distances<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let log = |x: &[f64]| Body::new(x).map(|body| body.log_cholesky());
        self.inertias.iter().nested(move |&first| {
            let both = log(&x[first..]).zip(log(&self.nominal[first..]));
            (0..INERTIAL_PARAMETERS)
                .map(move |k| both.map_or(f64::NAN, |(own, nominal)| own[k] - nominal[k]))
        })
    }

    /// Jacobian of [`distances`](Self::distances) in the directions, with a weight, in rows from `row` on.
    pub(super) fn distance_slopes(
        &self,
        x: &[f64],
        weight: f64,
        row: usize,
        out: &mut DMatrix<f64>,
    ) {
        for (index, &first) in self.inertias.iter().enumerate() {
            let row = row + INERTIAL_PARAMETERS * index;
            let slopes = Body::new(&x[first..]).and_then(|body| body.log_slopes());
            let mut own =
                out.fixed_view_mut::<INERTIAL_PARAMETERS, INERTIAL_PARAMETERS>(row, first);
            match slopes {
                Some(slopes) => own.copy_from(&(slopes * weight)),
                None => own.fill(f64::NAN),
            }
        }
    }

    /// Derivatives of the parameters in the directions: 1, except those of inertias.
    pub(super) fn slopes(&self, x: &[f64]) -> DMatrix<f64> {
        let mut out = DMatrix::identity(self.len(), self.len());
        for &first in &self.inertias {
            let mut own =
                out.fixed_view_mut::<INERTIAL_PARAMETERS, INERTIAL_PARAMETERS>(first, first);
            match Body::new(&x[first..]) {
                Some(body) => own.copy_from(&body.slopes()),
                None => own.fill(f64::NAN),
            }
        }
        out
    }

    /// Takes a step: numbers grow by d; inertias go along the directions of their bodies.
    pub(super) fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        for ((out, x), d) in out.iter_mut().zip(x).zip(d) {
            *out = x + d;
        }
        for &first in &self.inertias {
            let own = first..first + INERTIAL_PARAMETERS;
            let moved = Body::new(&x[own.clone()]).map(|body| body.moved(&d[own.clone()]));
            out[own].copy_from_slice(&moved.unwrap_or([f64::NAN; INERTIAL_PARAMETERS]));
        }
    }

    pub(super) fn intervals(
        &self,
        values: &[f64],
        covariance: &DMatrix<f64>,
        factor: f64,
    ) -> Vec<Interval> {
        let interval = |k: usize| {
            let (value, deviation) = (values[k], covariance[(k, k)].max(0.0).sqrt());
            Interval::new(self.names[k].clone(), value, deviation, factor)
        };
        (0..values.len()).map(interval).collect()
    }
}

/// Least and largest value in a domain that a descent is to go to; `None` where it depends on another number.
pub(super) fn bounds(domain: Domain) -> Option<[f64; 2]> {
    use Domain::{Anything, AtLeastOne, Finite, Fraction, NotNegativeOrdered, Ordered, WithinOne};
    match domain {
        Anything | Ordered | NotNegativeOrdered => None,
        Finite => Some([f64::NEG_INFINITY, f64::INFINITY]),
        Fraction | WithinOne => Some([0.0, 1.0]),
        AtLeastOne => Some([1.0, f64::INFINITY]),
        _ => Some([0.0, f64::INFINITY]),
    }
}
