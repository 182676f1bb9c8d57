//! How far two correct computations of a quantity may differ, and the comparison; `tests/python/bounds.py` in Rust.
//!
//! Every bound is [`REL`] of the quantity's natural scale plus what rounding can do on this mesh:
//!
//! - Subtracting two coordinates rounds to half an ulp of the *difference*. So an offset of |x| costs edge vectors, and
//!   all that is made from them, nothing; it costs ε |x| wherever coordinates themselves are added up: means, smoothed
//!   positions, the centroid.
//! - κ = longest edge squared / twice the area is how badly conditioned a triangle is. A cross product has a relative
//!   error of ε κ, and so have normal, area, and a cotangent's denominator.

use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeMap;

const REL: f64 = 1e-12;
/// Operations in the longest chain that a bound summarises.
const CHAIN: f64 = 8.0;
const STEP: f64 = 0.5;

/// Quantities made of integers.
const EXACT: [&str; 7] = [
    "vertices",
    "faces",
    "rings",
    "boundary_vertices",
    "boundary_edges",
    "non_manifold_edges",
    "non_manifold_vertices",
];

/// A sparse matrix.
type Entries = BTreeMap<(usize, usize), f64>;

/// Bounds of the quantities that are not exact, one for each entry or row.
pub(super) struct Bounds {
    rows: BTreeMap<&'static str, Vec<f64>>,
    nested: BTreeMap<(&'static str, &'static str), Vec<f64>>,
    cotangent_laplacian: Entries,
}

/// What is known of each triangle.
struct Triangle {
    vertices: [usize; 3],
    normal: DVec3,
    doubled_area: f64,
    angles: [f64; 3],
    cotangents: [f64; 3],
    /// CHAIN · ε · κ; zero without area, where a convention takes the place of a condition: the zero is exact.
    rounding: f64,
}

impl Triangle {
    fn new(positions: &[DVec3], vertices: [usize; 3]) -> Self {
        let p = vertices.map(|v| positions[v]);
        let cross = (p[1] - p[0]).cross(p[2] - p[0]);
        let doubled_area = cross.length();
        let sides = |k: usize| (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        let dots = [0, 1, 2].map(|k| sides(k).0.dot(sides(k).1));
        let longest_edge = [0, 1, 2].map(|k| sides(k).0.length()).into_iter().fold(0.0, f64::max);
        let or_zero = |x: f64| if doubled_area > 0.0 { x } else { 0.0 };
        Self {
            vertices,
            normal: cross.normalize_or_zero(),
            doubled_area,
            angles: dots.map(|dot| doubled_area.atan2(dot)),
            cotangents: dots.map(|dot| or_zero(dot / doubled_area)),
            rounding: or_zero(CHAIN * f64::EPSILON * longest_edge * longest_edge / doubled_area),
        }
    }
    /// How far each cotangent may be off.
    fn cotangent_bounds(&self) -> [f64; 3] {
        self.cotangents.map(|c| (REL + self.rounding) * (1.0 + c.abs()))
    }
}

/// Half of what lies opposite each edge, summed, in both directions: the wᵢⱼ of a cotangent matrix.
fn edge_weights(triangles: &[Triangle], opposite: impl Fn(&Triangle) -> [f64; 3]) -> Entries {
    let mut weights = Entries::new();
    for t in triangles {
        for (k, value) in opposite(t).into_iter().enumerate() {
            let (i, j) = (t.vertices[(k + 1) % 3], t.vertices[(k + 2) % 3]);
            *weights.entry((i, j)).or_default() += value / 2.0;
            *weights.entry((j, i)).or_default() += value / 2.0;
        }
    }
    weights
}

/// Row sums.
fn totals(entries: &Entries, rows: usize) -> Vec<f64> {
    let mut totals = vec![0.0; rows];
    for (&(i, _), w) in entries {
        totals[i] += w;
    }
    totals
}

/// Errors after 1 and after 10 smoothing steps: they spread as positions do, one ring a step, and each step adds its
/// own.
fn propagated(weights: &Entries, per_step: &[f64]) -> [Vec<f64>; 2] {
    let total = totals(weights, per_step.len());
    let step = |bound: &[f64]| {
        let stays = |i: usize| if total[i] > 0.0 { (1.0 - STEP) * bound[i] } else { bound[i] };
        let mut next: Vec<f64> = (0..bound.len()).map(|i| stays(i) + per_step[i]).collect();
        for (&(i, j), w) in weights.iter().filter(|((i, _), _)| total[*i] > 0.0) {
            next[i] += STEP * w / total[i] * bound[j];
        }
        next
    };
    let first = step(&vec![0.0; per_step.len()]);
    let tenth = (1..10).fold(first.clone(), |bound, _| step(&bound));
    [first, tenth]
}

impl Bounds {
    pub(super) fn new(positions: &[DVec3], faces: &[[usize; 3]]) -> Self {
        let count = positions.len();
        let triangles: Vec<Triangle> = faces.iter().map(|&face| Triangle::new(positions, face)).collect();
        let magnitude = positions.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let low = positions.iter().copied().reduce(DVec3::min).unwrap();
        let high = positions.iter().copied().reduce(DVec3::max).unwrap();
        let diagonal = low.distance(high);

        let weights = edge_weights(&triangles, |t| t.cotangents);
        let weight_bounds = edge_weights(&triangles, Triangle::cotangent_bounds);
        let ones: Entries = weights.keys().map(|&ends| (ends, 1.0)).collect();
        let valence = totals(&ones, count);
        let lengths = || ones.keys().map(|&(i, j)| (i, positions[i].distance(positions[j])));
        let mut longest_at = vec![0.0_f64; count];
        for (i, length) in lengths() {
            longest_at[i] = longest_at[i].max(length);
        }

        let sum_rounding: Vec<f64> = valence.iter().map(|n| f64::EPSILON * (n + 2.0) * magnitude).collect();
        let positive: Entries = weights.iter().map(|(&ends, w)| (ends, w.max(0.0))).collect();
        let (total, loose) = (totals(&positive, count), totals(&weight_bounds, count));
        // A weight off by t moves the mean by t / Σ w of the longest edge, and again through that sum.
        let drift = |i: usize| if total[i] > 0.0 { 2.0 * loose[i] * longest_at[i] / total[i] } else { 0.0 };
        let with_drift: Vec<f64> = (0..count).map(|i| sum_rounding[i] + drift(i)).collect();

        let mut cotangent_laplacian = weight_bounds;
        cotangent_laplacian.extend(loose.iter().enumerate().map(|(i, sum)| ((i, i), *sum)));

        let mut mass = vec![0.0; count];
        for t in &triangles {
            for v in t.vertices {
                mass[v] += t.doubled_area / 6.0 * (REL + t.rounding);
            }
        }
        let area = triangles.iter().map(|t| t.doubled_area).sum::<f64>() / 2.0;
        let area_rounding = triangles.iter().map(|t| t.doubled_area * t.rounding).sum::<f64>() / 2.0;
        let mean_edge = lengths().map(|(_, length)| length).sum::<f64>() / ones.len() as f64;
        let rows = BTreeMap::from([
            ("face_normals", triangles.iter().map(|t| REL + t.rounding).collect()),
            ("uniform_laplacian", (0..count).map(|i| REL * longest_at[i] + sum_rounding[i]).collect()),
            ("mass", mass),
            ("mean_edge", vec![REL * mean_edge]),
            ("area", vec![REL * area + area_rounding]),
            // The centroid is a sum of as many terms; where the surface is open the volume depends on it.
            ("volume", vec![area * (REL * diagonal + count as f64 * f64::EPSILON * magnitude)]),
        ]);
        let mut nested = vertex_normal_bounds(&triangles, count);
        for (name, weights, per_step) in
            [("smoothed_uniform", &ones, &sum_rounding), ("smoothed_cotangent", &positive, &with_drift)]
        {
            for (steps, bounds) in ["1", "10"].into_iter().zip(propagated(weights, per_step)) {
                nested.insert((name, steps), bounds.into_iter().map(|b| b + REL * diagonal).collect());
            }
        }
        Self { rows, nested, cotangent_laplacian }
    }

    /// Sentences on where `actual` departs from `expected`; none if every quantity in `expected` agrees.
    pub(super) fn differences(&self, actual: &Value, expected: &Value) -> Vec<String> {
        let mut found = Vec::new();
        for (name, expected) in expected.as_object().unwrap() {
            let actual = &actual[name];
            if EXACT.contains(&name.as_str()) {
                found.extend((actual != expected).then(|| format!("{name} differ")));
            } else if name == "cotangent_laplacian" {
                found.extend(self.laplacian_difference(actual, expected));
            } else if let Some(bounds) = self.rows.get(name.as_str()) {
                found.extend(difference(name, actual, expected, bounds));
            } else {
                for (inner, expected) in expected.as_object().unwrap() {
                    let bounds = &self.nested[&(name.as_str(), inner.as_str())];
                    found.extend(difference(&format!("{name} {inner}"), &actual[inner], expected, bounds));
                }
            }
        }
        found
    }

    /// Compares matrices given as rows [i, j, w]; what only one of them lists counts as zero in the other.
    fn laplacian_difference(&self, actual: &Value, expected: &Value) -> Option<String> {
        let entries = |matrix: &Value| -> Option<Entries> {
            let index = |x: &Value| x.as_u64().map(|i| i as usize);
            matrix.as_array()?.iter().map(|e| Some(((index(&e[0])?, index(&e[1])?), e[2].as_f64()?))).collect()
        };
        let Some(actual) = entries(actual) else {
            return Some("cotangent_laplacian is no list of [i, j, w]".to_owned());
        };
        let expected = entries(expected).unwrap();
        let at = |matrix: &Entries, place| matrix.get(place).copied().unwrap_or(0.0);
        let fine = |place| {
            let gap = at(&actual, place) - at(&expected, place);
            gap.abs() <= at(&self.cotangent_laplacian, place)
        };
        let place = actual.keys().chain(expected.keys()).find(|place| !fine(*place))?;
        let (found, wanted) = (at(&actual, place), at(&expected, place));
        Some(format!("cotangent_laplacian at {place:?} is {found}, not {wanted}"))
    }
}

/// Errors of the summands over the length of the sum: where normals cancel, their errors do not.
fn vertex_normal_bounds(triangles: &[Triangle], count: usize) -> BTreeMap<(&'static str, &'static str), Vec<f64>> {
    type Weights = fn(&Triangle) -> [f64; 3];
    let weightings: [(&'static str, Weights, f64); 3] = [
        ("uniform", |_| [1.0; 3], 0.0),
        ("area", |t| [t.doubled_area / 2.0; 3], 0.0),
        // An angle is itself off by the rounding of its sine.
        ("angle", |t| t.angles, 1.0),
    ];
    let bounds = weightings.map(|(name, weights, own)| {
        let (mut sums, mut errors) = (vec![DVec3::ZERO; count], vec![0.0; count]);
        for t in triangles {
            for (v, w) in t.vertices.into_iter().zip(weights(t)) {
                sums[v] += t.normal * w;
                errors[v] += w * (REL + 2.0 * t.rounding) + own * t.rounding;
            }
        }
        let bound = |(sum, error): (&DVec3, &f64)| if *sum == DVec3::ZERO { 0.0 } else { error / sum.length() };
        (("vertex_normals", name), sums.iter().zip(&errors).map(bound).collect())
    });
    BTreeMap::from(bounds)
}

/// The numbers of a scalar (one row), of a list (a row for each), or of a list of lists.
fn rows_of(value: &Value) -> Option<Vec<Vec<f64>>> {
    let numbers = |row: &Value| match row {
        Value::Array(items) => items.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>(),
        scalar => scalar.as_f64().map(|x| vec![x]),
    };
    match value {
        Value::Array(rows) => rows.iter().map(numbers).collect(),
        scalar => numbers(scalar).map(|row| vec![row]),
    }
}

fn difference(name: &str, actual: &Value, expected: &Value, bounds: &[f64]) -> Option<String> {
    let expected = rows_of(expected).unwrap();
    assert_eq!(expected.len(), bounds.len(), "one bound for each row of {name}");
    let Some(actual) = rows_of(actual) else {
        return Some(format!("{name} is not made of numbers"));
    };
    if actual.len() != expected.len() {
        return Some(format!("{name} has {} entries, not {}", actual.len(), expected.len()));
    }
    // NaN compares false, so this form also finds what is not a number.
    let fine = |row: usize| {
        let pairs = || actual[row].iter().zip(&expected[row]);
        actual[row].len() == expected[row].len() && pairs().all(|(a, e)| (a - e).abs() <= bounds[row])
    };
    let row = (0..actual.len()).find(|&row| !fine(row))?;
    Some(format!("{name} [{row}] is {:?}, not {:?}: the bound is {:e}", actual[row], expected[row], bounds[row]))
}
