//! A bearing flange as a machinist would draw it: planes, cylinders and cones that meet in sharp
//! edges of many angles, and in a few smooth ones.
//!
//! Millimetres; z is up until the last step. A square plate with round corners and four countersunk
//! bolt holes carries a chamfered boss on four ribs; a bore with a keyway goes through, and a
//! bearing seat is sunk into the underside.

use crate::brep::{Brep, Curve};
use crate::chart::Chart;
use crate::developable::Developable;
use glam::{DVec2, DVec3, dvec3};
use spade::InsertionError;

/// Names of the groups that charts refer to.
pub(crate) const GROUP_NAMES: [&str; 5] = ["plate", "holes", "ribs", "boss", "bore"];
const PLATE: usize = 0;
const HOLES: usize = 1;
const RIBS: usize = 2;
const BOSS: usize = 3;
const BORE: usize = 4;

const EDGE_LENGTH: f64 = 2.5;

const PLATE_HALF_WIDTH: f64 = 50.0;
const PLATE_TOP: f64 = 12.0;
const CORNER_RADIUS: f64 = 15.0;
const CORNER_CENTRE: f64 = PLATE_HALF_WIDTH - CORNER_RADIUS;

const HOLE_RADIUS: f64 = 5.5;
const COUNTERSINK_RADIUS: f64 = 10.0;
const COUNTERSINK_DEPTH: f64 = COUNTERSINK_RADIUS - HOLE_RADIUS;

const BOSS_RADIUS: f64 = 26.0;
const BOSS_TOP: f64 = 46.0;
const CHAMFER: f64 = 3.5;

const RIB_HALF_WIDTH: f64 = 4.0;
const RIB_END: f64 = 45.0;
const RIB_TOE: f64 = 17.0;

const BORE_RADIUS: f64 = 15.0;
const KEY_HALF_WIDTH: f64 = 4.0;
const KEY_DEPTH: f64 = 19.0;
const SEAT_RADIUS: f64 = 22.5;
const SEAT_TOP: f64 = 8.0;

const ACROSS: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
const CENTRE: DVec2 = DVec2::ZERO;

/// The flange's vertices, y up, and its charts in model units, sorted by group.
pub(crate) fn flange() -> Result<(Vec<DVec3>, Vec<Chart>), InsertionError> {
    let mut brep = Brep::new(EDGE_LENGTH);
    let [bore_bottom, bore_top] = bore(&mut brep)?;
    let seat_rim = seat(&mut brep, &bore_bottom)?;
    let foot = boss_and_ribs(&mut brep, &bore_top)?;
    let holes = bolt_holes(&mut brep)?;
    plate(&mut brep, &foot, &holes, &seat_rim)?;
    let mut charts = brep.charts;
    charts.sort_by_key(|chart| chart.group);
    Ok((brep.positions.into_iter().map(|p| dvec3(p.x, p.z, -p.y)).collect(), charts))
}

/// The round bore with its keyway towards +x; returns its outlines at the bottom and the top.
fn bore(brep: &mut Brep) -> Result<[Vec<Curve>; 2], InsertionError> {
    let x = (BORE_RADIUS * BORE_RADIUS - KEY_HALF_WIDTH * KEY_HALF_WIDTH).sqrt();
    let corners =
        [(x, KEY_HALF_WIDTH), (x, -KEY_HALF_WIDTH), (KEY_DEPTH, -KEY_HALF_WIDTH), (KEY_DEPTH, KEY_HALF_WIDTH)];
    let [low, high] = [SEAT_TOP, BOSS_TOP].map(|z| corners.map(|(x, y)| brep.point(x, y, z)));
    let [bottom, top] = [low, high].map(|[a, b, c, d]| {
        let sides = [[b, c], [c, d], [d, a]].map(|[from, to]| brep.line(from, to));
        [vec![brep.arc(CENTRE, a, b)], sides.to_vec()].concat()
    });
    let uprights = [0, 1, 2, 3].map(|k| brep.line(low[k], high[k]));
    let corner = |k: usize| dvec3(corners[k].0, corners[k].1, 0.0);
    let surfaces = [
        Developable::Bore { centre: CENTRE, radius: BORE_RADIUS, toward: DVec2::NEG_X },
        Developable::plane(corner(1), DVec3::Y, DVec3::NEG_X),
        Developable::plane(corner(2), DVec3::NEG_X, DVec3::NEG_Y),
        Developable::plane(corner(3), DVec3::NEG_Y, DVec3::X),
    ];
    for (k, surface) in surfaces.iter().enumerate() {
        let boundary = [&bottom[k], &uprights[(k + 1) % 4], &top[k], &uprights[k]];
        brep.face(BORE, surface, &[&boundary])?;
    }
    Ok([bottom, top])
}

/// The bearing seat under the bore; returns its rim in the underside.
fn seat(brep: &mut Brep, bore_outline: &[Curve]) -> Result<Vec<Curve>, InsertionError> {
    let cuts = [DVec2::X, DVec2::NEG_X];
    let rim = brep.ring(CENTRE, SEAT_RADIUS, 0.0, &cuts);
    let floor = brep.ring(CENTRE, SEAT_RADIUS, SEAT_TOP, &cuts);
    let wall = |toward| Developable::Bore { centre: CENTRE, radius: SEAT_RADIUS, toward };
    brep.wall(BORE, [&rim, &floor], &[wall(DVec2::Y), wall(DVec2::NEG_Y)])?;
    let plane = Developable::plane(DVec3::Z * SEAT_TOP, DVec3::NEG_Z, DVec3::X);
    brep.face(BORE, &plane, &[&all(&floor), &all(bore_outline)])?;
    Ok(rim)
}

/// The boss and its ribs; returns the outline of their foot on the plate.
fn boss_and_ribs(brep: &mut Brep, bore_outline: &[Curve]) -> Result<Vec<Curve>, InsertionError> {
    let diagonals = ACROSS.map(|d| (d + d.perp()).normalize());
    let shoulder = brep.ring(CENTRE, BOSS_RADIUS, BOSS_TOP - CHAMFER, &diagonals);
    let brow = brep.ring(CENTRE, BOSS_RADIUS - CHAMFER, BOSS_TOP, &diagonals);
    let apex = BOSS_TOP + BOSS_RADIUS - CHAMFER;
    // Arc k runs from diagonal k to diagonal k + 1, through direction k + 1.
    let chamfers = [1, 2, 3, 0].map(|k| Developable::Cone { centre: CENTRE, apex, rise: -1.0, toward: ACROSS[k] });
    brep.wall(BOSS, [&shoulder, &brow], &chamfers)?;
    let plane = Developable::plane(DVec3::Z * BOSS_TOP, DVec3::Z, DVec3::X);
    brep.face(BOSS, &plane, &[&all(&brow), &all(bore_outline)])?;

    let ground = diagonals.map(|d| brep.point(BOSS_RADIUS * d.x, BOSS_RADIUS * d.y, PLATE_TOP));
    let seams = [0, 1, 2, 3].map(|k| brep.line(ground[k], shoulder[k][0]));
    let mut foot = Vec::new();
    for (k, toward) in ACROSS.into_iter().enumerate() {
        let before = (k + 3) % 4;
        let rib = rib(brep, toward)?;
        let to_rib = brep.arc(CENTRE, ground[before], rib.foot[0][0]);
        let from_rib = brep.arc(CENTRE, rib.foot[2][0], ground[k]);
        let [right, crest, left] = &rib.joint;
        let boundary = [&to_rib, right, crest, left, &from_rib, &seams[k], &shoulder[before], &seams[before]];
        let shaft = Developable::Shaft { centre: CENTRE, radius: BOSS_RADIUS, toward };
        brep.face(BOSS, &shaft, &[&boundary])?;
        foot.push(to_rib);
        foot.extend(rib.foot);
        foot.push(from_rib);
    }
    Ok(foot)
}

/// Where a rib meets the rest of the solid; right and left as seen from the boss.
struct Rib {
    /// On the plate: out along the right side, across, back along the left side.
    foot: [Curve; 3],
    /// On the boss: up the right side, over the crest, down the left side.
    joint: [Curve; 3],
}

/// A rib from the boss outwards, its top falling at 45° to a low toe.
fn rib(brep: &mut Brep, out: DVec2) -> Result<Rib, InsertionError> {
    let crest_height = |x: f64| RIB_TOE + RIB_END - x;
    let on_boss = |y: f64| (BOSS_RADIUS * BOSS_RADIUS - y * y).sqrt();
    let place = |x: f64, y: f64, z: f64| (x * out + y * out.perp()).extend(z);
    let root = on_boss(RIB_HALF_WIDTH);
    let sides = [-RIB_HALF_WIDTH, RIB_HALF_WIDTH].map(|y| {
        let heights = [(root, PLATE_TOP), (RIB_END, PLATE_TOP), (RIB_END, RIB_TOE), (root, crest_height(root))];
        let corners = heights.map(|(x, z)| {
            let p = place(x, y, z);
            brep.point(p.x, p.y, p.z)
        });
        [0, 1, 2, 3].map(|k| brep.line(corners[k], corners[(k + 1) % 4]))
    });
    let [right, left] = &sides;
    // Each side: foot, toe, crest, joint.
    let foot_end = brep.line(right[1][0], left[1][0]);
    let toe_top = brep.line(right[2][0], left[2][0]);
    let crest_on_boss = brep.curve(right[3][0], left[3][0], 2.0 * RIB_HALF_WIDTH, |t| {
        let y = RIB_HALF_WIDTH * (2.0 * t - 1.0);
        place(on_boss(y), y, crest_height(on_boss(y)))
    });
    let (origin, out3, left3) = (place(RIB_END, 0.0, RIB_TOE), out.extend(0.0), out.perp().extend(0.0));
    for (side, normal) in [(right, -left3), (left, left3)] {
        let surface = Developable::plane(origin + normal * RIB_HALF_WIDTH, normal, out3);
        brep.face(RIBS, &surface, &[&[&side[0], &side[1], &side[2], &side[3]]])?;
    }
    let crest = Developable::plane(origin, (out3 + DVec3::Z).normalize(), left3);
    brep.face(RIBS, &crest, &[&[&toe_top, &left[2], &crest_on_boss, &right[2]]])?;
    let toe = Developable::plane(origin, out3, left3);
    brep.face(RIBS, &toe, &[&[&foot_end, &left[1], &toe_top, &right[1]]])?;
    let [[foot_right, _, _, joint_right], [foot_left, _, _, joint_left]] = sides;
    Ok(Rib { foot: [foot_right, foot_end, foot_left], joint: [joint_right, crest_on_boss, joint_left] })
}

/// A bolt hole's circles in the plate's top and underside.
struct HoleRims {
    top: Vec<Curve>,
    bottom: Vec<Curve>,
}

fn bolt_holes(brep: &mut Brep) -> Result<Vec<HoleRims>, InsertionError> {
    let cuts = [DVec2::X, DVec2::NEG_X];
    let mut holes = Vec::new();
    for out in ACROSS {
        let centre = (out + out.perp()) * CORNER_CENTRE;
        let neck_height = PLATE_TOP - COUNTERSINK_DEPTH;
        let bottom = brep.ring(centre, HOLE_RADIUS, 0.0, &cuts);
        let neck = brep.ring(centre, HOLE_RADIUS, neck_height, &cuts);
        let top = brep.ring(centre, COUNTERSINK_RADIUS, PLATE_TOP, &cuts);
        let halves = [DVec2::Y, DVec2::NEG_Y];
        let apex = neck_height - HOLE_RADIUS;
        let shank = halves.map(|toward| Developable::Bore { centre, radius: HOLE_RADIUS, toward });
        let sink = halves.map(|toward| Developable::Cone { centre, apex, rise: 1.0, toward });
        brep.wall(HOLES, [&bottom, &neck], &shank)?;
        brep.wall(HOLES, [&neck, &top], &sink)?;
        holes.push(HoleRims { top, bottom });
    }
    Ok(holes)
}

/// The plate's rim, top and underside.
fn plate(brep: &mut Brep, foot: &[Curve], holes: &[HoleRims], seat_rim: &[Curve]) -> Result<(), InsertionError> {
    let [bottom, top] = [0.0, PLATE_TOP].map(|z| plate_outline(brep, z));
    let uprights: Vec<Curve> = bottom.iter().zip(&top).map(|(low, high)| brep.line(low[0], high[0])).collect();
    for k in 0..8 {
        let out = ACROSS[k / 2];
        let surface = if k % 2 == 0 {
            let normal = out.extend(0.0);
            Developable::plane(normal * PLATE_HALF_WIDTH, normal, out.perp().extend(0.0))
        } else {
            let diagonal = out + out.perp();
            Developable::Shaft { centre: diagonal * CORNER_CENTRE, radius: CORNER_RADIUS, toward: diagonal.normalize() }
        };
        let boundary = [&bottom[k], &uprights[(k + 1) % 8], &top[k], &uprights[k]];
        brep.face(PLATE, &surface, &[&boundary])?;
    }
    let face = |outline: &[Curve], middle: &[Curve], rim: fn(&HoleRims) -> &Vec<Curve>| {
        let outlines = [outline, middle].into_iter();
        outlines.chain(holes.iter().map(|hole| rim(hole).as_slice())).map(<[Curve]>::to_vec).collect()
    };
    let upper: Vec<Vec<Curve>> = face(&top, foot, |hole| &hole.top);
    let lower: Vec<Vec<Curve>> = face(&bottom, seat_rim, |hole| &hole.bottom);
    for (z, normal, outlines) in [(PLATE_TOP, DVec3::Z, upper), (0.0, DVec3::NEG_Z, lower)] {
        let loops: Vec<Vec<&Curve>> = outlines.iter().map(|curves| all(curves)).collect();
        let loops: Vec<&[&Curve]> = loops.iter().map(Vec::as_slice).collect();
        brep.face(PLATE, &Developable::plane(DVec3::Z * z, normal, DVec3::X), &loops)?;
    }
    Ok(())
}

/// Straight side, round corner, and so on, counter-clockwise from the right-hand side.
fn plate_outline(brep: &mut Brep, z: f64) -> Vec<Curve> {
    let ends = ACROSS.map(|out| {
        [-CORNER_CENTRE, CORNER_CENTRE].map(|along| {
            let p = out * PLATE_HALF_WIDTH + out.perp() * along;
            brep.point(p.x, p.y, z)
        })
    });
    let mut outline = Vec::new();
    for k in 0..4 {
        let corner = (ACROSS[k] + ACROSS[k].perp()) * CORNER_CENTRE;
        outline.push(brep.line(ends[k][0], ends[k][1]));
        outline.push(brep.arc(corner, ends[k][1], ends[(k + 1) % 4][0]));
    }
    outline
}

fn all(curves: &[Curve]) -> Vec<&Curve> {
    curves.iter().collect()
}
