//! The axis of a mesh file that points up.

/// Treatment of the up axis that a COLLADA file states.
///
/// Descriptions put z up. A file whose `<up_axis>` is another one is either turned, so that this axis points along z,
/// or taken as its numbers stand, as `RViz` takes them. Either way the page of the robot and
/// [`Contacts::mesh_remarks`](crate::contact::Contacts::mesh_remarks) say so. STL and OBJ files state no axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "view", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "view", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum UpAxis {
    /// Turns the file, unless `MeshLab` (its library `VCGLib`) wrote it, which states `Y_UP` whatever the axes are.
    ///
    /// Of the robots that the defaults were tried on, those with files of `MeshLab` hold z up in them, the others what
    /// they state.
    #[default]
    Auto,
    /// Turns the file as it says.
    Honour,
    /// Takes the numbers as they stand.
    Ignore,
}
