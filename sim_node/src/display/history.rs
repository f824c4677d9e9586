//! What a run was like up to now, as far back as its judge looks.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::samples_in;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::observation::{SwarmOrder, order_of};
use rsrs_sim::world::World;

/// Poses, commands and objects of the last steps: at least a window of the judge, once so many were made.
#[derive(Clone)]
pub struct History {
    trajectory: Trajectory,
    bodies: Bodies,
    behaviour: Behaviour,
}

impl History {
    /// Of a world that has made no step.
    pub fn new(conditions: &Conditions) -> Self {
        let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
        trajectory.n_objects = conditions.world.n_objects();
        Self { trajectory, bodies: conditions.bodies(), behaviour: conditions.behaviour }
    }

    /// Adds a step: what was sensed, and the commands that answered it.
    pub fn step(&mut self, world: &World, commands: &[Command]) {
        self.trajectory.poses.extend(world.poses());
        self.trajectory.objects_m.extend(world.objects_m());
        self.trajectory.commands.extend(commands);
        self.forget();
    }

    /// Gives up what is older than the judge looks back, in one go now and then.
    fn forget(&mut self) {
        let kept_s = self.behaviour.window().at_the_moment().reaches_back_s();
        let trajectory = &mut self.trajectory;
        let n_kept = samples_in(kept_s, trajectory.period_s);
        let n_old = trajectory.n_samples().saturating_sub(n_kept);
        if n_old >= n_kept {
            trajectory.poses.drain(..n_old * trajectory.n_robots);
            trajectory.commands.drain(..n_old * trajectory.n_robots);
            trajectory.objects_m.drain(..n_old * trajectory.n_objects);
        }
    }

    /// The phase of what there is, or how much more of it the judge wants to see.
    pub fn label(&self) -> String {
        let n_samples = self.trajectory.n_samples();
        let order = order_of(&self.trajectory, n_samples, &self.bodies, self.behaviour);
        match order.filter(SwarmOrder::is_whole) {
            Some(order) => order.phase.title().to_owned(),
            None => format!("no label before {} s", self.behaviour.window().least_s()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::tests::pushing;
    use rsrs_sim::draw::Seed;

    #[test]
    fn it_keeps_a_window_and_not_the_whole_run_and_labels_by_the_behaviour_of_the_world() {
        let conditions = pushing("last_s: 10");
        let mut world = World::new(&conditions, Seed { seed: 1, replicate: 0 }).expect("they fit");
        let mut history = History::new(&conditions);

        for step in 0..1000 {
            let is_short = history.label() == "no label before 10 s";
            assert_eq!(is_short, step < 100, "{step}");
            history.step(&world, &vec![Command::STOP; conditions.robots]);
            world.sense_all();
            world.advance(&vec![Command::STOP; conditions.robots]);
        }

        let window = &history.trajectory;
        assert!((100..200).contains(&window.n_samples()), "{}", window.n_samples());
        assert_eq!(window.commands.len(), window.poses.len());
        assert_eq!(window.objects_m.len(), window.n_samples() * 3);
        // Two of three objects lie side by side.
        assert_eq!(history.label(), "heaped");
    }

    #[test]
    fn of_a_run_that_is_judged_as_a_whole_nothing_is_given_up() {
        let conditions = pushing("whole_run");
        let world = World::new(&conditions, Seed { seed: 1, replicate: 0 }).expect("they fit");
        let mut history = History::new(&conditions);

        for _ in 0..2000 {
            history.step(&world, &vec![Command::STOP; conditions.robots]);
        }

        assert_eq!(history.trajectory.n_samples(), 2000);
    }
}
