//! Sensing in lanes: what [`crate::field_of_view`] and [`crate::contact`] define, for many worlds at once.
//!
//! Each pair is looked at once, for both of its robots. What one sees of the other lies at
//! `(forward, lateral)`; what the difference of their places is to the other robot has the opposite
//! sign, and that is exact: `-a + -b` is `-(a + b)` to the bit, save for the sign of zero, which no
//! comparison below distinguishes.

use rsrs_core::judge::number::{Mask, Number};

use crate::contact::Contact;
use crate::field_of_view::{self, ConeView, PolygonView};
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
    /// What follows from how far apart two robots are, for both of them.
    type Apart: Copy;
    /// What follows from their squared distance.
    fn apart(self, d2: S::F) -> Self::Apart;
    /// Whether a neighbour is seen at these distances; of a cone, those in front.
    fn sees(self, forward: S::F, lateral: S::F, apart: Self::Apart) -> S::M;
    /// Whether one is seen at minus these distances.
    fn sees_opposite(self, forward: S::F, lateral: S::F, apart: Self::Apart) -> S::M;

    /// The squared distance below which [`Self::sees_close`] is to be asked, too; `None` if never.
    fn close(self) -> Option<S::F> {
        None
    }
    /// Whether a neighbour is seen that is not in front, or as close as its body's radius.
    fn sees_close(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M;
}

/// [`ConeView`] in lanes.
#[derive(Clone, Copy)]
pub struct Cone<F> {
    zero: F,
    slope: F,
    per_m: F,
    end_m: F,
    width_squared_m2: F,
    body_squared_m2: F,
    behind_squared_m2: F,
}

impl<F: Copy> Cone<F> {
    pub fn new<S: Simd<F = F>>(simd: S, view: ConeView) -> Self {
        Self {
            zero: simd.single(0.0),
            slope: simd.single(view.slope),
            per_m: simd.single(view.per_m),
            end_m: simd.single(view.end_m),
            width_squared_m2: simd.single(view.width_squared_m2),
            body_squared_m2: simd.single(view.body_squared_m2),
            behind_squared_m2: simd.single(view.behind_squared_m2()),
        }
    }
}

impl<S: Simd> LaneView<S> for Cone<S::F> {
    /// The square of how far beside the sector a centre may be, across the heading.
    type Apart = S::F;

    #[inline(always)]
    fn apart(self, d2: S::F) -> S::F {
        let over = (d2 * self.per_m - self.end_m).most(self.zero);
        self.width_squared_m2 - over * over
    }

    #[inline(always)]
    fn sees(self, forward: S::F, lateral: S::F, room: S::F) -> S::M {
        let beside = (lateral.abs() - forward * self.slope).most(self.zero);
        forward.gt(self.zero) & (beside * beside).le(room)
    }

    #[inline(always)]
    fn sees_opposite(self, forward: S::F, lateral: S::F, room: S::F) -> S::M {
        let beside = (lateral.abs() + forward * self.slope).most(self.zero);
        forward.lt(self.zero) & (beside * beside).le(room)
    }

    #[inline(always)]
    fn close(self) -> Option<S::F> {
        Some(self.behind_squared_m2)
    }

    #[inline(always)]
    fn sees_close(self, forward: S::F, lateral: S::F, d2: S::F) -> S::M {
        let lateral = lateral.abs();
        let is_along = self.zero.le(forward + lateral * self.slope);
        let beside = (lateral - forward * self.slope).most(self.zero);
        let touches = (beside * beside).le(LaneView::<S>::apart(self, d2));
        d2.gt(self.zero) & (d2.le(self.body_squared_m2) | (is_along & touches))
    }
}

/// A half-plane `normal . point <= limit`, which is `-normal . point >= -limit`.
#[derive(Clone, Copy)]
struct HalfPlane<F> {
    normal_x: F,
    normal_y: F,
    limit_m: F,
    minus_limit_m: F,
}

/// A corner with the chord beyond which it is nearest.
#[derive(Clone, Copy)]
struct Corner<F> {
    chord: HalfPlane<F>,
    x_m: F,
    y_m: F,
}

/// [`PolygonView`] in lanes.
pub struct Polygon<F> {
    zero: F,
    body_squared_m2: F,
    sides: Vec<HalfPlane<F>>,
    corners: Vec<Corner<F>>,
}

impl<F: Copy> Polygon<F> {
    pub fn new<S: Simd<F = F>>(simd: S, view: &PolygonView) -> Self {
        let half_plane = |half_plane: &field_of_view::HalfPlane| HalfPlane {
            normal_x: simd.single(half_plane.normal_x),
            normal_y: simd.single(half_plane.normal_y),
            limit_m: simd.single(half_plane.limit_m),
            minus_limit_m: simd.single(-half_plane.limit_m),
        };
        let corner = |corner: &field_of_view::Corner| Corner {
            chord: half_plane(&corner.chord),
            x_m: simd.single(corner.x_m),
            y_m: simd.single(corner.y_m),
        };
        Self {
            zero: simd.single(0.0),
            body_squared_m2: simd.single(view.body_squared_m2),
            sides: view.sides.iter().map(half_plane).collect(),
            corners: view.corners.iter().map(corner).collect(),
        }
    }
}

impl<S: Simd> LaneView<S> for &Polygon<S::F> {
    /// Whether they are apart at all.
    type Apart = S::M;

    #[inline(always)]
    fn apart(self, d2: S::F) -> S::M {
        d2.gt(self.zero)
    }

    #[inline(always)]
    fn sees(self, forward: S::F, lateral: S::F, are_apart: S::M) -> S::M {
        let mut seen = are_apart;
        // A closure that is not inlined is not vectorized.
        for side in &self.sides {
            let along = forward * side.normal_x + lateral * side.normal_y;
            seen = seen & along.le(side.limit_m);
        }
        for Corner { chord, x_m, y_m } in &self.corners {
            let along = forward * chord.normal_x + lateral * chord.normal_y;
            let (dx, dy) = (forward - *x_m, lateral - *y_m);
            let touches = (dx * dx + dy * dy).le(self.body_squared_m2);
            seen = seen & (along.le(chord.limit_m) | touches);
        }
        seen
    }

    #[inline(always)]
    fn sees_opposite(self, forward: S::F, lateral: S::F, are_apart: S::M) -> S::M {
        let mut seen = are_apart;
        for side in &self.sides {
            let along = forward * side.normal_x + lateral * side.normal_y;
            seen = seen & side.minus_limit_m.le(along);
        }
        for Corner { chord, x_m, y_m } in &self.corners {
            let along = forward * chord.normal_x + lateral * chord.normal_y;
            let (dx, dy) = (forward + *x_m, lateral + *y_m);
            let touches = (dx * dx + dy * dy).le(self.body_squared_m2);
            seen = seen & (chord.minus_limit_m.le(along) | touches);
        }
        seen
    }

    #[inline(always)]
    fn sees_close(self, _: S::F, _: S::F, d2: S::F) -> S::M {
        d2.lt(self.zero)
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

/// Looks at some neighbouring robots and all after them; what they find is added. The result is who
/// of the `SOME` robots from `first` on sees another: no later robot looks at them again.
///
/// Robots are looked at some at a time, so that what is loaded of the others serves each of them.
/// Bodies and what is found are of all robots, shape `[n_robots]`.
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
    // Contact is rare, so only who is touched is asked where. So is a neighbour that a cone sees and
    // that is not in front: unless the cone is wide, it overlaps with the robot itself.
    let close_m2 = view.close().unwrap_or(contact.diameter_squared_m2);
    if nearest_m2.lt(contact.diameter_squared_m2.most(close_m2)).any() {
        for me in first..first + SOME {
            let blocked = (&mut found.ahead[me..], &mut found.behind[me..]);
            block_each_other(contact, &bodies[me..], blocked);
        }
        if view.close().is_some() && nearest_m2.lt(close_m2).any() {
            for (me, our_seen) in us.iter().zip(&mut our_seen) {
                *our_seen = *our_seen | sees_any_close(simd, view, me, &bodies[first..]);
            }
            for (other, their_seen) in others.iter().zip(&mut found.seen[first + SOME..]) {
                *their_seen = *their_seen | sees_any_close(simd, view, other, us);
            }
        }
    }
    our_seen
}

/// Whether a robot sees any of these that is close to it.
#[inline(always)]
fn sees_any_close<S: Simd, V: LaneView<S>>(
    simd: S,
    view: V,
    me: &Body<S::F>,
    others: &[Body<S::F>],
) -> S::M {
    let mut seen = simd.no();
    for other in others {
        let (dx_m, dy_m) = (other.x_m - me.x_m, other.y_m - me.y_m);
        let d2_m2 = dx_m * dx_m + dy_m * dy_m;
        let forward_m = dx_m * me.cosine + dy_m * me.sine;
        let lateral_m = dy_m * me.cosine - dx_m * me.sine;
        seen = seen | view.sees_close(forward_m, lateral_m, d2_m2);
    }
    seen
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
    let apart = view.apart(d2_m2);
    let forward_m = dx_m * me.cosine + dy_m * me.sine;
    let lateral_m = dy_m * me.cosine - dx_m * me.sine;
    let mine = view.sees_opposite(forward_m, lateral_m, apart);
    let forward_m = dx_m * other.cosine + dy_m * other.sine;
    let lateral_m = dy_m * other.cosine - dx_m * other.sine;
    (mine, view.sees(forward_m, lateral_m, apart))
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
