//! Values of options: the words and numbers that are allowed.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use planish_geometry::map::manifest::LARGEST_SIDE;
use planish_geometry::map::occlusion::MOST_RAYS;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::named::{Named, Word};

/// Returns words with their meanings, as the help lists them.
pub(super) fn possible(words: &'static [Word]) -> Vec<PossibleValue> {
    words.iter().map(|word| PossibleValue::new(word.name).help(word.help.trim_end_matches('.'))).collect()
}

/// Returns a parser of the names of an enum.
pub(super) fn named<T: Named>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(possible(T::WORDS)).try_map(|name| T::named(&name))
}

/// A value, or `None` for `auto`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrAuto<T>(pub(crate) Option<T>);

/// Returns a parser of the names of an enum and of `auto`, whose help is `auto`.
pub(super) fn named_or_auto<T: Named>(auto: &'static str) -> impl TypedValueParser<Value = OrAuto<T>> {
    let words = [PossibleValue::new("auto").help(auto)].into_iter().chain(possible(T::WORDS));
    PossibleValuesParser::new(words.collect::<Vec<_>>()).try_map(|name| {
        if name == "auto" { Ok(OrAuto(None)) } else { T::named(&name).map(|value| OrAuto(Some(value))) }
    })
}

/// Kind of displacement map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MapArg {
    /// Heights along the normals, one channel
    #[default]
    Scalar,
    /// The whole displacement, three channels
    Vector,
}

/// Axes of a vector map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SpaceArg {
    /// Axes of the model
    #[default]
    Object,
    /// Tangent, bitangent and normal of each vertex; the map then follows a mesh that is deformed
    Tangent,
}

/// One of several parts of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Number of the part, counted from 1.
    pub(crate) part: usize,
    /// Number of parts.
    pub(crate) parts: usize,
}

/// Parses `--shard`.
pub(super) fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    let allowed = numbers.filter(|(part, parts)| (1..=*parts).contains(part));
    let (part, parts) = allowed.ok_or("a shard is I/N with I from 1 to N, such as 2/8")?;
    Ok(Shard { part, parts })
}

/// Parses `--size`.
pub(super) fn side(text: &str) -> Result<OrAuto<u32>, String> {
    if text == "auto" {
        return Ok(OrAuto(None));
    }
    match text.parse() {
        Ok(side) if (1..=LARGEST_SIDE).contains(&side) => Ok(OrAuto(Some(side))),
        _ => Err(format!("a size is `auto` or a number from 1 to {LARGEST_SIDE}")),
    }
}

/// Parses `--max-size`.
pub(super) fn largest_side(text: &str) -> Result<u32, String> {
    let allowed = text.parse().ok().filter(|side| (1..=LARGEST_SIDE).contains(side));
    allowed.ok_or_else(|| format!("a size is a number from 1 to {LARGEST_SIDE}"))
}

/// Parses `--ao-rays`.
pub(super) fn rays(text: &str) -> Result<u32, String> {
    let allowed = text.parse().ok().filter(|rays| (1..=MOST_RAYS).contains(rays));
    allowed.ok_or_else(|| format!("not a number from 1 to {MOST_RAYS}"))
}

/// Parses a length, model units.
pub(super) fn length(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "not a length above 0")
}

/// Parses `--bits`.
pub(super) fn bits(text: &str) -> Result<u32, String> {
    let allowed = text.parse().ok().filter(|bits| [8, 16, 32].contains(bits));
    allowed.ok_or_else(|| "a texel has 8, 16 or 32 bits".to_owned())
}

/// Parses `--tolerance`, in quanta.
pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    number(text, |x| (0.625..=1e6).contains(&x), "not a number of at least 0.625; encoding alone costs half a quantum")
}

/// Parses NAME=VALUE, where VALUE is JSON or a bare word.
pub(super) fn setting(text: &str) -> Result<(String, serde_json::Value), String> {
    let (name, value) = text.split_once('=').ok_or("a setting is NAME=VALUE")?;
    Ok((name.to_owned(), serde_json::from_str(value).unwrap_or_else(|_| value.into())))
}

/// Parses `--weld`.
pub(super) fn welding(text: &str) -> Result<Welding, String> {
    match text {
        "exact" => Ok(Welding::Exact),
        "none" => Ok(Welding::None),
        _ => match text.parse() {
            Ok(epsilon) if f64::is_finite(epsilon) && epsilon > 0.0 => Ok(Welding::Epsilon(epsilon)),
            _ => Err("welding is `exact`, `none` or a distance greater than 0".to_owned()),
        },
    }
}

/// Parses a finite number that `is_allowed` accepts, or returns `rule` as the error.
pub(super) fn number(text: &str, is_allowed: impl Fn(f64) -> bool, rule: &str) -> Result<f64, String> {
    let parsed: Result<f64, _> = text.parse();
    parsed.ok().filter(|x| x.is_finite() && is_allowed(*x)).ok_or_else(|| rule.to_owned())
}

/// Parses finite numbers with commas between them.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|part| part.trim().parse().ok().filter(|x| f64::is_finite(*x))).collect()
}

/// Parses a number between −10⁶ and 10⁶.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text, |x| x.abs() <= 1e6, "not a number between −1000000 and 1000000")
}

/// Parses a number between 0 and 10⁶.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1e6).contains(&x), "not a number between 0 and 1000000")
}

/// Parses a number between 10⁻⁶ and 10⁶.
pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| (1e-6..=1e6).contains(&x), "not a number between 0.000001 and 1000000")
}

/// Parses a number between 0 and 1.
pub(super) fn in_unit_interval(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "not a number between 0 and 1")
}
