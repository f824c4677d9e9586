//! Sensing in lanes: what [`crate::view`] and [`crate::contact`] define, for many worlds at once.
//!
//! Each pair is looked at once, for both of its robots. What one sees of the other lies at
//! `(forward, lateral)`; what the difference of their places is to the other robot has the opposite
//! sign, and that is exact: `-a + -b` is `-(a + b)` to the bit, save for the sign of zero, which no
//! comparison below distinguishes.

use rsrs_core::judge::number::{Mask, Number};

use crate::contact::Contact;
use crate::field_of_view::{ConeView, PolygonView};
use crate::vector::simd::Simd;

/// Place and heading of one robot in every world.
#[derive(Clone, Copy)]
pub struct Body<F> {
    pub x_m: F,
    pub y_m: F,
    pub cosine: F,
    pub sine: F,
}

/// A view in lanes.
pub trait LaneView<S: Simd>: Copy {
    /// Whether a neighbour is seen at these distances and this squared distance.
    fn sees(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M;
    /// Whether one is seen at minus these distances.
    fn sees_opposite(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M;
}

/// [`ConeView`] in lanes.
#[derive(Clone, Copy)]
pub struct Cone<F> {
    zero: F,
    slope: F,
    offset_m: F,
    reach_squared_m2: F,
}

impl<F: Copy> Cone<F> {
    pub fn new<S: Simd<F = F>>(simd: S, view: ConeView) -> Self {
        Self {
            zero: simd.single(0.0),
            slope: simd.single(view.slope),
            offset_m: simd.single(view.offset_m),
            reach_squared_m2: simd.single(view.reach_squared_m2),
        }
    }
}

impl<S: Simd> LaneView<S> for Cone<S::F> {
    #[inline(always)]
    fn sees(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M {
        forward.gt(self.zero)
            & d2.le(self.reach_squared_m2)
            & lateral.abs().le(forward * self.slope + self.offset_m)
    }

    #[inline(always)]
    fn sees_opposite(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M {
        forward.lt(self.zero)
            & d2.le(self.reach_squared_m2)
            & lateral.abs().le(self.offset_m - forward * self.slope)
    }
}

/// One side of a polygon: `normal . point <= limit`, which is `-normal . point >= -limit`.
#[derive(Clone, Copy)]
pub struct Side<F> {
    normal_x: F,
    normal_y: F,
    limit_m: F,
    minus_limit_m: F,
}

/// The sides of a polygon in lanes.
pub fn sides<S: Simd>(simd: S, view: &PolygonView) -> Vec<Side<S::F>> {
    view.sides
        .iter()
        .map(|side| Side {
            normal_x: simd.single(side.normal_x),
            normal_y: simd.single(side.normal_y),
            limit_m: simd.single(side.limit_m),
            minus_limit_m: simd.single(-side.limit_m),
        })
        .collect()
}

/// [`PolygonView`] in lanes; with `IN_FRONT` it sees bodies in front, else centres around.
#[derive(Clone, Copy)]
pub struct Polygon<'a, F, const IN_FRONT: bool> {
    pub zero: F,
    pub sides: &'a [Side<F>],
}

impl<S: Simd, const IN_FRONT: bool> LaneView<S> for Polygon<'_, S::F, IN_FRONT> {
    #[inline(always)]
    fn sees(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M {
        let mut inside = if IN_FRONT { forward.gt(self.zero) } else { d2.gt(self.zero) };
        // A closure that is not inlined is not vectorized.
        for side in self.sides {
            let along = forward * side.normal_x + lateral * side.normal_y;
            inside = inside & along.le(side.limit_m);
        }
        inside
    }

    #[inline(always)]
    fn sees_opposite(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M {
        let mut inside = if IN_FRONT { forward.lt(self.zero) } else { d2.gt(self.zero) };
        for side in self.sides {
            let along = forward * side.normal_x + lateral * side.normal_y;
            inside = inside & side.minus_limit_m.le(along);
        }
        inside
    }
}

/// [`Contact`] in lanes.
#[derive(Clone, Copy)]
pub struct LaneContact<F> {
    diameter_squared_m2: F,
    front: F,
    minus_front: F,
}

impl<F: Copy> LaneContact<F> {
    pub fn new<S: Simd<F = F>>(simd: S, contact: Contact) -> Self {
        Self {
            diameter_squared_m2: simd.single(contact.diameter_squared_m2),
            front: simd.single(contact.front),
            minus_front: simd.single(-contact.front),
        }
    }
}

/// What robots found out about each other so far in a step, a mask for each robot.
pub struct SensedNeighbours<'a, M> {
    /// Who sees another.
    pub seen: &'a mut [M],
    /// Who has another in front of it.
    pub ahead: &'a mut [M],
    /// Who has another behind it.
    pub behind: &'a mut [M],
}

/// Looks at some neighbouring robots and all after them; what they find is added.
///
/// Robots are looked at some at a time, so that what is loaded of the others serves each of them.
///
/// # Arguments
///
/// * `bodies` — all robots; shape `[n_robots]`, as what is found.
///
/// # Returns
///
/// Who of the `SOME` robots from `first` on sees another: no later robot looks at them again.
#[inline(always)]
pub fn sense<S: Simd, V: LaneView<S>, const SOME: usize>(
    simd: S,
    view: V,
    contact: LaneContact<S::F>,
    first: usize,
    bodies: &[Body<S::F>],
    found: &mut SensedNeighbours<'_, S::M>,
) -> [S::M; SOME] {
    let (us, others) = bodies[first..].split_at(SOME);
    let (ours, theirs) = found.seen[first..].split_at_mut(SOME);
    let mut our_seen: [S::M; SOME] = std::array::from_fn(|me| ours[me]);
    let mut nearest_m2 = simd.single(f32::INFINITY);
    for me in 0..SOME {
        for other in me + 1..SOME {
            let (mine, theirs) = look(view, &us[me], &us[other], &mut nearest_m2);
            our_seen[me] = our_seen[me] | mine;
            our_seen[other] = our_seen[other] | theirs;
        }
    }
    for (other, their_seen) in others.iter().zip(theirs) {
        for me in 0..SOME {
            let (mine, theirs) = look(view, &us[me], other, &mut nearest_m2);
            our_seen[me] = our_seen[me] | mine;
            *their_seen = *their_seen | theirs;
        }
    }
    // Contact is rare, so only who is touched is asked where.
    if nearest_m2.lt(contact.diameter_squared_m2).any() {
        for me in first..first + SOME {
            let blocked = (&mut found.ahead[me..], &mut found.behind[me..]);
            block_each_other(contact, &bodies[me..], blocked);
        }
    }
    our_seen
}

/// Whether two robots see each other.
#[inline(always)]
fn look<S: Simd, V: LaneView<S>>(
    view: V,
    me: &Body<S::F>,
    other: &Body<S::F>,
    nearest_m2: &mut S::F,
) -> (S::M, S::M) {
    let (dx_m, dy_m) = (me.x_m - other.x_m, me.y_m - other.y_m);
    let d2_m2 = dx_m * dx_m + dy_m * dy_m;
    *nearest_m2 = nearest_m2.least(d2_m2);
    let forward_m = dx_m * me.cosine + dy_m * me.sine;
    let lateral_m = dy_m * me.cosine - dx_m * me.sine;
    let mine = view.sees_opposite(forward_m, lateral_m, d2_m2);
    let forward_m = dx_m * other.cosine + dy_m * other.sine;
    let lateral_m = dy_m * other.cosine - dx_m * other.sine;
    (mine, view.sees(forward_m, lateral_m, d2_m2))
}

#[inline(always)]
fn block_each_other<F: Number>(
    contact: LaneContact<F>,
    bodies: &[Body<F>],
    (ahead, behind): (&mut [F::Mask], &mut [F::Mask]),
) {
    let me = bodies[0];
    for other_robot in 1..bodies.len() {
        let other = bodies[other_robot];
        let (dx_m, dy_m) = (other.x_m - me.x_m, other.y_m - me.y_m);
        let d2_m2 = dx_m * dx_m + dy_m * dy_m;
        let touches = d2_m2.lt(contact.diameter_squared_m2);
        let sector_m2 = contact.front * d2_m2;
        let minus_sector_m2 = contact.minus_front * d2_m2;
        let forward_m = dx_m * me.cosine + dy_m * me.sine;
        let along_m2 = forward_m * forward_m.abs();
        ahead[0] = ahead[0] | (touches & along_m2.gt(sector_m2));
        behind[0] = behind[0] | (touches & along_m2.lt(minus_sector_m2));
        let (dx_m, dy_m) = (me.x_m - other.x_m, me.y_m - other.y_m);
        let forward_m = dx_m * other.cosine + dy_m * other.sine;
        let along_m2 = forward_m * forward_m.abs();
        ahead[other_robot] = ahead[other_robot] | (touches & along_m2.gt(sector_m2));
        behind[other_robot] = behind[other_robot] | (touches & along_m2.lt(minus_sector_m2));
    }
}
