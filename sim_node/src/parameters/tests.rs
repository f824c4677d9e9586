use rsrs_testing::conditions::{flockbot, measured_flockbots};

use super::*;

fn conditions() -> Conditions {
    measured_flockbots(3)
}

fn text(name: &str, value: &str) -> (String, ParameterValue) {
    (name.to_owned(), ParameterValue::String(value.to_owned()))
}

fn hosted() -> Vec<String> {
    ["robot_1", "robot_2", "robot_3"].map(str::to_owned).to_vec()
}

fn refusal(values: &[(String, ParameterValue)]) -> String {
    check(values, &hosted(), &flockbot()).unwrap_err().to_string()
}

#[test]
fn conditions_that_make_a_world_are_taken() {
    let json = serde_json::to_string(&conditions()).unwrap();

    assert!(
        check(&[text(CONDITIONS, &json), text(TIME, "real_time")], &hosted(), &flockbot()).is_ok()
    );
}

#[test]
fn conditions_that_make_none_are_refused_by_name() {
    let json = |change: fn(&mut Conditions)| {
        let mut conditions = conditions();
        change(&mut conditions);
        text(CONDITIONS, &serde_json::to_string(&conditions).unwrap())
    };

    assert_eq!(
        refusal(&[json(|c| c.robot.radius_m = -0.075)]),
        "`conditions`: robot.radius_m is -0.075, expected a number from 0.000001 to 1000000"
    );
    assert_eq!(
        refusal(&[json(|c| c.robots = 4)]),
        "`conditions`: robots is 4, expected 1 to 3, the robots of this simulator; name those of \
         others in `robots`, in the same request"
    );
    assert!(refusal(&[json(|c| c.robots = 0)]).contains("robots is 0, expected 1 to 3"));
    assert!(refusal(&[text(CONDITIONS, "{}")]).contains("missing field `robots`"));
    assert_eq!(refusal(&[text(TIME, "fast")]), "`time` is `fast`, expected lockstep or real_time");
    assert_eq!(
        refusal(&[
            json(|c| c.period_s = 2.0),
            (STEPS.to_owned(), ParameterValue::Integer(i64::from(u32::MAX)))
        ]),
        "`steps` is 4294967295, expected at most 1073741823 with a period of 2 s"
    );
}

#[test]
fn start_values_are_taken_and_unknown_ones_named() {
    let given = BTreeMap::from([text(TIME, "real_time")]);
    let declared = declare(given).unwrap();
    let misspelt = declare(BTreeMap::from([text("tim", "real_time")]));

    let values: Vec<_> = declared.parameters.iter().map(|(_, value)| value).collect();
    assert!(values.contains(&&ParameterValue::String("real_time".to_owned())));
    assert_eq!(misspelt.unwrap_err().to_string(), "/simulator has no parameter `tim`");
}

#[test]
fn a_world_with_real_robots_is_taken_in_real_time_alone() {
    let json = text(CONDITIONS, &serde_json::to_string(&conditions()).unwrap());
    let names = ["robot_1", "robot_2", "real"].map(str::to_owned).to_vec();
    let robots = (ROBOTS.to_owned(), ParameterValue::StringArray(names));
    let real_time = [json.clone(), robots.clone(), text(TIME, "real_time")];

    assert!(check(&real_time, &hosted(), &flockbot()).is_ok());
    assert_eq!(
        refusal(&[json, robots, text(TIME, "lockstep")]),
        "`time` is `lockstep` and real is not one of this simulator's robots, expected `real_time` \
         for a world with real robots"
    );
    assert_eq!(refusal(&[text(TRACKED_BY, "tf")]), "`tracked_by` is `tf`, expected odom or pose");
}

#[test]
fn a_cell_that_is_typed_makes_the_conditions_that_programs_send() {
    let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=3";

    assert_eq!(by_hand::conditions(cell, &flockbot()).unwrap(), conditions());
    assert!(check(&[text(CELL, cell)], &hosted(), &flockbot()).is_ok());
    for (cell, expected) in [
        ("fast", "`cell` is `fast`, expected values such as `speed_m_s=0.15,robots=3`"),
        ("speed_m_s=0.15", "`cell`: "),
        ("speed_m_s=0.15,turn_rate_rad_s=0.75,robots=4", "4"),
    ] {
        assert!(
            refusal(&[text(CELL, cell)]).contains(expected),
            "{}",
            refusal(&[text(CELL, cell)])
        );
    }
}
