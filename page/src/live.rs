//! A swarm that is looked at while it runs.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::label_with;
use rsrs_core::judge::reason::Reason;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;

/// Numbers of a robot in a frame.
pub const PER_ROBOT: usize = 4;

/// A swarm that is looked at while it runs.
pub struct Live {
    conditions: Conditions,
    world: World,
    controllers: Controllers,
    /// The judged window, and at most as much before it.
    past: Trajectory,
    /// x and y in metres, heading in radians, and 1 for a detection, 2 for a robot that is blocked; shape
    /// `[n_robots][PER_ROBOT]`.
    frame: Vec<f32>,
}

impl Live {
    /// Places a swarm.
    pub fn new(conditions: Conditions, seed: Seed) -> Result<Self, String> {
        let world = World::new(&conditions, seed).map_err(|error| error.to_string())?;
        let controllers = Controllers::new(&conditions, seed);
        let past = Trajectory::new(conditions.period_s, conditions.robots);
        let frame = vec![0.0; PER_ROBOT * conditions.robots];
        let mut live = Self { conditions, world, controllers, past, frame };
        live.look();
        Ok(live)
    }

    /// Makes steps, and keeps what the judge needs of them.
    pub fn step(&mut self, n_steps: u32) {
        for _ in 0..n_steps {
            let mut commands = Vec::with_capacity(self.conditions.robots);
            self.controllers.decide(self.world.sense_all(), &mut commands);
            self.past.poses.extend(self.world.poses());
            self.past.commands.extend_from_slice(&commands);
            self.world.advance(&commands);
        }
        let window = self.conditions.behaviour.window();
        let n_kept = window.n_needed(self.past.n_samples(), self.conditions.period_s);
        if self.past.n_samples() > 2 * n_kept {
            let too_old = (self.past.n_samples() - n_kept) * self.conditions.robots;
            self.past.poses.drain(..too_old);
            self.past.commands.drain(..too_old);
        }
        self.look();
    }

    /// Sensing again changes nothing, so the frame shows what the next step will answer.
    #[expect(clippy::cast_possible_truncation, reason = "the world is in single precision")]
    fn look(&mut self) {
        let detected = self.world.sense().to_vec();
        let robots = self.world.poses().zip(self.world.blocked()).zip(detected);
        for (row, ((pose, blocked), detected)) in self.frame.chunks_exact_mut(PER_ROBOT).zip(robots)
        {
            let flags = f32::from(u8::from(detected) + 2 * u8::from(*blocked));
            let place = [pose.x_m, pose.y_m, pose.heading_rad].map(|number| number as f32);
            row[..3].copy_from_slice(&place);
            row[3] = flags;
        }
    }

    /// Where the numbers of a frame are.
    pub fn frame(&self) -> &[f32] {
        &self.frame
    }

    /// Names the state.
    pub fn digest(&self) -> u64 {
        self.world.digest()
    }

    /// Steps made so far.
    pub fn n_steps(&self) -> u64 {
        self.world.step_index()
    }

    /// Order parameters of the last minute, or of what there is of it, and the phase after a minute.
    pub fn judge(&self) -> serde_json::Value {
        let n_samples = self.past.n_samples();
        let time_s = self.n_steps() as f64 * self.conditions.period_s;
        if n_samples == 0 {
            return serde_json::json!({ "time_s": time_s });
        }
        let bodies = self.conditions.bodies();
        let rules = self.conditions.behaviour.rules();
        match label_with(&self.past, &bodies, &rules) {
            Ok(verdict) => {
                let reason = Reason::new(&self.past, &bodies, &verdict, &rules);
                // When somebody left is not known of what came before the kept past.
                let reason = Reason { departures: Vec::new(), ..reason };
                serde_json::json!({
                    "time_s": time_s,
                    "phase": verdict.phase,
                    "evidence": verdict.evidence,
                    "reason": reason.sentences(rules.wanted, &[]),
                })
            }
            Err(_) => serde_json::json!({
                "time_s": time_s,
                "evidence": OrderParameters::with(&self.past, 0..n_samples, &bodies, &rules.asked()),
            }),
        }
    }
}
