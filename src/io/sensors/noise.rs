//! `<noise>` of an SDF.

use crate::error::LoadError;
use crate::io::context::{Context, Node, child, is_native, tag};
use crate::io::schema::{Known, check, known};
use crate::io::values::{Elements, Values};
use crate::sim::SensorNoise;

const NOISE: Known = known(
    "type",
    "type mean stddev bias_mean bias_stddev dynamic_bias_stddev dynamic_bias_correlation_time precision",
    "",
);

/// The noise in an element; none without a `<noise>`.
///
/// | element | becomes |
/// |---|---|
/// | `mean`, `bias_mean` | their sum is the offset |
/// | `stddev` | white noise |
/// | `bias_stddev` | the bias at the start |
/// | `dynamic_bias_stddev` | the random walk of the bias, without its return to zero |
/// | `precision` | the resolution |
pub(super) fn of(context: &mut Context<'_>, node: Node<'_>) -> Result<SensorNoise, LoadError> {
    match child(node, "noise") {
        Some(noise) => gaussian(context, noise),
        None => Ok(SensorNoise::default()),
    }
}

/// The noise of an element itself: a `<noise>`, or one of the parts that it had before version 1.5.
pub(super) fn gaussian(
    context: &mut Context<'_>,
    node: Node<'_>,
) -> Result<SensorNoise, LoadError> {
    let mut out = SensorNoise::default();
    check(context, node, &NOISE)?;
    let inner = Elements::value(context, node, "type")?;
    let kind = node.attribute("type").map(Into::into).or(inner);
    match kind.as_deref().unwrap_or("gaussian") {
        "none" => return Ok(out),
        "gaussian" | "gaussian_quantized" => {}
        kind => {
            let reason =
                format!("noise of the type \"{kind}\" is not modelled: the sensor has none");
            context.warn(node, reason);
            return Ok(out);
        }
    }
    let mut number = |name: &str| Ok(Elements::number(context, node, name)?.unwrap_or(0.0));
    let (mean, bias_mean) = (number("mean")?, number("bias_mean")?);
    out.offset = mean + bias_mean;
    let mut positive = |name: &str| magnitude(context, node, name);
    out.white = positive("stddev")?;
    out.bias = positive("bias_stddev")?;
    out.bias_walk = positive("dynamic_bias_stddev")?;
    out.resolution = positive("precision")?;
    if let Some(time) = child(node, "dynamic_bias_correlation_time") {
        context.ignore(time, "the bias does not return to zero");
    }
    if bias_mean != 0.0 && out.bias == 0.0 {
        context.warn(
            node,
            "the sign of <bias_mean> is not drawn: it is that of the file",
        );
    }
    Ok(out)
}

/// A number that is not negative; 0 where there is none.
pub(super) fn magnitude(
    context: &mut Context<'_>,
    node: Node<'_>,
    name: &str,
) -> Result<f64, LoadError> {
    let x = Elements::number(context, node, name)?.unwrap_or(0.0);
    match x >= 0.0 {
        true => Ok(x),
        false => {
            let reason = "expected a number that is not negative";
            Err(context.malformed_value(node, name, &x.to_string(), reason))
        }
    }
}

/// The noise of the axes of an element, which have one in common here: that of the first, with a warning where others differ.
///
/// * `axes` – names of the elements of the axes
pub(super) fn of_axes(
    context: &mut Context<'_>,
    node: Node<'_>,
    axes: &Known,
) -> Result<SensorNoise, LoadError> {
    check(context, node, axes)?;
    let (mut first, mut is_same, mut count) = (None, true, 0);
    for axis in node.children().filter(|axis| is_native(*axis)) {
        if !matches!(tag(axis), "x" | "y" | "z") {
            continue;
        }
        let own = of(context, axis)?;
        let first = *first.get_or_insert(own);
        (is_same, count) = (is_same && own == first, count + 1);
    }
    let first = first.unwrap_or_default();
    if !is_same || (count < 3 && first != SensorNoise::default()) {
        let reason =
            "all axes of a sensor have one noise here: that of its first axis is taken for all";
        context.warn(node, reason);
    }
    Ok(first)
}
