//! Report of an import: base, warnings, and unused content.

use std::fmt;

use super::context::Context;
use super::place::ImportNote;
use super::sensors::{self, ImportedSensor};
use crate::error::{message, write_remarks};
use crate::model::{Base, Limits, Link, Model};
use crate::sim::{Sensors, Servo};
use crate::sorting::sort_seldom;

/// Report on a loaded file.
///
/// `Display` writes a table with the first hundred remarks of each kind and the number of others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImportReport {
    /// Source of the description.
    pub file: String,
    /// Base of the robot: [`Base::Fixed`] or [`Base::Floating`].
    pub base: Base,
    /// Base in the options: for [`Base::Auto`] the name of the root link decides, and [`base_note`](Self::base_note) reports it.
    pub wanted_base: Base,
    /// The root link, which is fixed to the world or floats.
    pub root_link: String,
    /// Number of joints with a limit of position, speed or effort; see [`limits_note`](Self::limits_note).
    pub limited_joints: usize,
    /// Remarks on content that may not have the intended meaning.
    pub warnings: Vec<ImportNote>,
    /// Remarks on content that the model does not use. The content of an ignored element is not listed again.
    pub ignored: Vec<ImportNote>,
    /// Joints with a command interface in `<ros2_control>` or `<transmission>` of a URDF, in the order of the file, each with its servo; without a servo the
    /// input is the effort. `None` if the file has no such elements. [`simulator`](Self::simulator) uses them.
    pub commands: Option<Vec<(String, Option<Servo>)>>,
    /// Sensors of an SDF, of an MJCF, or of Gazebo's settings in a URDF, in the order of the file. Modelled sensors have different names; those without a name,
    /// or with a taken one, are called by kind and index, as in `gyro 3`.
    pub sensors: Vec<ImportedSensor>,
}

impl ImportReport {
    /// Makes a report without remarks, for programs that store reports.
    pub fn new(file: impl Into<String>, base: Base, root_link: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            base,
            wanted_base: base,
            root_link: root_link.into(),
            limited_joints: 0,
            warnings: Vec::new(),
            ignored: Vec::new(),
            commands: None,
            sensors: Vec::new(),
        }
    }

    /// Returns the modelled [`sensors`](Self::sensors) by name. Noise is not included: use [`ImportedSensor::noise`] with
    /// [`NoisySensors`](crate::sim::NoisySensors).
    ///
    /// * `model` – the model that was loaded with this report
    ///
    /// # Panics
    /// If the model is another one, which has no such frames.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let xml = r#"<sdf version="1.9"><model name="m"><link name="a"><inertial/>
    ///   <sensor name="imu" type="imu"><update_rate>100</update_rate></sensor></link></model></sdf>"#;
    /// let (model, report) = ModelOptions::default().load_sdf_str(xml)?;
    /// assert_eq!(report.known_sensors(&model).names()[..2], ["imu/gyro.x", "imu/gyro.y"]);
    /// assert_eq!(report.sensors[0].noise.period, 0.01);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn known_sensors(&self, model: &Model) -> Sensors {
        sensors::known(&self.sensors, model)
    }

    /// Note on the reason for the base, and on how to change it; `None` if the options set it.
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let (arm, report) = ModelOptions::default().load_urdf_file("assets/quadruped.urdf")?;
    /// assert!(arm.has_floating_base() && report.base_note().unwrap().contains("base=fixed"));
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn base_note(&self) -> Option<String> {
        let root = &self.root_link;
        match (self.wanted_base, self.base) {
            (Base::Auto, Base::Floating) => Some(format!(
                "NOTE: the robot FLOATS, with 6 degrees of freedom more than its joints have, as its root link \"{root}\" is not called \
                 \"world\"; the option base=fixed holds it"
            )),
            (Base::Auto, _) => Some(format!(
                "NOTE: the robot is FIXED to the world, as its root link is called \"{root}\"; \
                 the option base=floating lets it float"
            )),
            _ => None,
        }
    }
}

impl ImportReport {
    /// Note on simulators that apply joint limits and command interfaces; `None` for a robot without limits and inputs in its description.
    pub fn limits_note(&self) -> Option<String> {
        let commands = self.commands.as_ref().map_or(0, Vec::len);
        let parts = [
            (self.limited_joints, "limits of position, speed and effort"),
            (commands, "command interfaces"),
        ];
        let counted = parts.iter().filter(|(n, _)| *n > 0);
        let parts: Vec<_> = counted
            .map(|(n, of)| format!("{of} ({n} joints)"))
            .collect();
        let simulators = match commands {
            0 => "the actuation of the model",
            _ => "the actuation of the file",
        };
        (!parts.is_empty()).then(|| {
            let parts = parts.join(" and ");
            format!("NOTE: {parts} act in simulators with {simulators} only")
        })
    }
}

impl ImportReport {
    /// The notes and remarks, one line each: those of [`Model::remarks`].
    pub fn remarks(&self) -> Vec<String> {
        let notes = [self.base_note(), self.limits_note()].into_iter().flatten();
        let remarks = self.warnings.iter().chain(&self.ignored);
        notes.chain(remarks.map(ToString::to_string)).collect()
    }
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let base = match self.base {
            Base::Floating => "floating",
            Base::Fixed | Base::Auto => "fixed",
        };
        let (file, root) = (&self.file, &self.root_link);
        let text = format_args!("{file}: {base} base, root link \"{root}\"");
        writeln!(f, "{}", message(text))?;
        for note in [self.base_note(), self.limits_note()].into_iter().flatten() {
            writeln!(f, "{}", message(format_args!("{note}")))?;
        }
        for (title, notes) in [("warnings", &self.warnings), ("ignored", &self.ignored)] {
            writeln!(f, "{title}: {}", notes.len())?;
            write_remarks(f, notes)?;
        }
        Ok(())
    }
}

/// Closes the remarks on a file that became a model.
pub(super) fn report(context: Context<'_>, wanted_base: Base, model: &Model) -> ImportReport {
    let (base, root) = if model.has_floating_base() {
        let floats = |link: &&Link| model.frames()[link.frame.0].body.is_some();
        (Base::Floating, model.links().iter().find(floats))
    } else {
        (Base::Fixed, model.links().first())
    };
    let name = root.map(|link| model.frames()[link.frame.0].name.clone());
    let sorted = |mut notes: Vec<ImportNote>| {
        sort_seldom(&mut notes, |one, other| one.line.cmp(&other.line));
        notes
    };
    let is_limited = |limits: &Limits| *limits != Limits::default();
    let joints = model.joints().iter();
    ImportReport {
        commands: context.commands,
        file: context.file.into(),
        limited_joints: joints.filter(|joint| is_limited(&joint.limits)).count(),
        base,
        wanted_base,
        root_link: name.unwrap_or_default(),
        warnings: sorted(context.warnings),
        ignored: sorted(context.ignored),
        sensors: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displayed_report_equals_the_table_a_person_expects() {
        let note = ImportNote {
            path: "robot/joint/limit@jerk".into(),
            name: "knee".into(),
            line: 7,
            reason: "not used".into(),
        };
        let report = ImportReport {
            file: "leg.urdf".into(),
            base: Base::Floating,
            wanted_base: Base::Floating,
            root_link: "hip".into(),
            limited_joints: 0,
            commands: None,
            warnings: Vec::new(),
            ignored: vec![note],
            sensors: Vec::new(),
        };
        assert_eq!(
            report.to_string(),
            "leg.urdf: floating base, root link \"hip\"\nwarnings: 0\nignored: 1\n  \
             line 7: robot/joint/limit@jerk \"knee\": not used\n"
        );
        let wanted_base = Base::Auto;
        let text = ImportReport {
            wanted_base,
            ..report
        }
        .to_string();
        assert!(
            text.lines()
                .nth(1)
                .unwrap()
                .contains("root link \"hip\" is not called \"world\""),
            "{text}"
        );
    }

    #[test]
    fn report_of_many_remarks_is_cut_and_shows_no_control_characters() {
        let note = ImportNote {
            path: "robot/link".into(),
            name: "\u{1b}[2J".into(),
            line: 7,
            reason: "not used\r\n".into(),
        };
        let report = ImportReport {
            file: "a\nb.urdf".into(),
            base: Base::Fixed,
            wanted_base: Base::Fixed,
            root_link: "hip".into(),
            limited_joints: 0,
            commands: None,
            warnings: Vec::new(),
            ignored: vec![note; 20_000],
            sensors: Vec::new(),
        };
        let text = report.to_string();
        assert!(text.len() < 10_000, "{} bytes", text.len());
        assert!(
            text.ends_with("\"\\u{1b}[2J\": not used\\r\\n\n  and 19900 more\n"),
            "{text}"
        );
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'));
        assert_eq!(text.lines().count(), 104);
    }
}
