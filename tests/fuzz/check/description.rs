//! Descriptions: an error with its source, or a robot whose dynamics are finite or reported as not finite, and that reads back from
//! its written files.

use dualbody::dynamics::{bias_forces, forward_dynamics, inverse_dynamics, mass_matrix};
use dualbody::joint::JointKind;
use dualbody::model::Base;
use dualbody::sim::RolloutStatus;
use dualbody::view::model_page;
use dualbody::{ImportReport, LoadError, Model, ModelOptions, Simulator, State};
use nalgebra::DMatrix;
use rand::RngExt;

use super::{check_characters, check_message, check_page};
use crate::input::{Case, Kind, Random};

/// Larger robots skip checks whose cost is the cube of their size.
const MAX_DEGREES: usize = 60;

/// Pages and files of other formats are made of every so many robots: they cost most.
const FILES: u32 = 8;

/// Difference of the mass matrices of a robot and of the robot that is read back, relative to the largest entry.
const SAME_ROBOT: f64 = 1e-9;

pub(super) fn check(case: &Case) -> Result<bool, String> {
    let (text, mut random) = (case.text(), case.random.clone());
    let options = options(&mut random);
    let (loaded, source) = match case.kind {
        Kind::Urdf => (options.load_urdf_str(&text), "URDF text"),
        Kind::Mjcf => (options.load_mjcf_str(&text), "MJCF text"),
        _ => (options.load_sdf_str(&text), "SDF text"),
    };
    let (model, report): (Model, ImportReport) = match loaded {
        Ok(loaded) => loaded,
        Err(error) => return refused(&error, source),
    };
    check_message(&report.to_string(), source)?;
    let rest = State::neutral(&model).check(&model);
    rest.map_err(|error| format!("the neutral state is none: {error}"))?;
    if model.nv() <= MAX_DEGREES {
        check_dynamics(&model, &mut random)?;
        check_written(&model, &options, &mut random)?;
    }
    if random.random_range(0..FILES) == 0 {
        check_page(&model_page(&model))?;
        if let Ok(text) = model.to_mjcf() {
            let document = roxmltree::Document::parse(&text);
            document.map_err(|error| format!("MJCF is not well-formed: {error}"))?;
        }
    }
    Ok(true)
}

fn refused(error: &LoadError, source: &str) -> Result<bool, String> {
    check_message(&error.to_string(), source)?;
    Ok(false)
}

fn options(random: &mut Random) -> ModelOptions {
    let options = ModelOptions::default();
    match random.random_range(0..8) {
        0 => options.with_base(Base::Fixed),
        1 => options.with_base(Base::Floating),
        2 => options.with_independent_mimic_joints(),
        _ => options,
    }
}

/// All results at a state are finite, or the step from it reports that they are not.
fn check_dynamics(model: &Model, random: &mut Random) -> Result<(), String> {
    let state = State::random(model, random, 1.0);
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let zero = vec![0.0; model.nv()];
    let mut all = vec![
        (
            "RNEA",
            is_finite(inverse_dynamics(model, q, v, &zero).as_slice()),
        ),
        ("bias", is_finite(bias_forces(model, q, v).as_slice())),
        ("CRBA", is_finite(mass_matrix(model, q).as_slice())),
    ];
    if model.check_mass_matrix().is_err() {
        // Steps are refused, as the check reports; the rest must still be finite.
        return all_finite(&all);
    }
    let a = forward_dynamics(model, q, v, &zero);
    all.push(("ABA", is_finite(a.as_slice())));
    let rollout = Simulator::new(model.clone()).rollout(&state, 2, |_, _, _| {});
    let is_completed = rollout.status == RolloutStatus::Completed;
    if is_completed && !rollout.states.iter().all(State::is_finite) {
        return Err("a completed rollout is not finite".into());
    }
    if is_completed {
        all_finite(&all)
    } else {
        Ok(())
    }
}

/// Whether all quantities are finite, or which are not.
fn all_finite(all: &[(&str, bool)]) -> Result<(), String> {
    let wrong = all.iter().filter(|(_, is_finite)| !is_finite);
    let wrong: Vec<&str> = wrong.map(|(name, _)| *name).collect();
    if wrong.is_empty() {
        return Ok(());
    }
    Err(format!("not finite without a word: {}", wrong.join(", ")))
}

fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// A written file reads back as the same robot.
fn check_written(model: &Model, options: &ModelOptions, random: &mut Random) -> Result<(), String> {
    // A URDF has no place for rotors, which an MJCF has.
    let rotors = 0..model.nv();
    let model = &rotors.fold(model.clone(), |bare, k| bare.with_armature(k, 0.0));
    let Ok(text) = model.to_urdf() else {
        return Ok(());
    };
    check_characters(&text)?;
    let (again, _) = options
        .load_urdf_str(&text)
        .map_err(|error| format!("URDF written is not read back: {error}"))?;
    if again.nv() != model.nv() || again.joint_names() != written_names(model) {
        return Err(format!(
            "URDF written has nv {}, not {}, or other joints",
            again.nv(),
            model.nv()
        ));
    }
    let q = model.random_configuration(random);
    let [own, other] = [model, &again].map(|model| mass_matrix(model, q.as_slice()));
    check_equal(&own, &other)
}

/// The names of the joints in a URDF, where a universal joint is two.
fn written_names(model: &Model) -> Vec<String> {
    let joints = model.joints().iter().flat_map(|joint| match joint.kind {
        JointKind::Universal => vec![
            format!("{}::axis", joint.name),
            format!("{}::axis2", joint.name),
        ],
        _ => vec![joint.name.clone()],
    });
    joints.collect()
}

fn check_equal(own: &DMatrix<f64>, other: &DMatrix<f64>) -> Result<(), String> {
    let (size, difference) = (own.amax(), (own - other).amax());
    // Numbers that overflow differ, and were reported as not finite.
    if !size.is_finite() || !other.amax().is_finite() || difference <= SAME_ROBOT * size {
        return Ok(());
    }
    Err(format!(
        "URDF written has another mass matrix, by {:.0e}",
        difference / size
    ))
}
