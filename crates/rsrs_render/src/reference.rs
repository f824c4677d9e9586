//! The reference as Markdown: a table of keys for each kind of file.

use std::fmt::Write;

use rsrs_core::judge::order::{Parameter, Prerequisite};
use rsrs_core::quantity::Axis;
use rsrs_pipeline::schema::FileKind;
use serde_json::{Map, Value};

use crate::axes;

/// The reference of all files and axes, as Markdown.
pub fn reference() -> String {
    let mut page = "# Every key of every file\n\n\
        This page is what `rsrs schema --reference` prints; `rsrs schema sweep` prints the same for \
        editors, as JSON Schema.\n\
        Keys name their units; files are YAML, and unknown keys are refused.\n"
        .to_owned();
    for kind in FileKind::ALL {
        let schema = kind.schema();
        let mut rows = Vec::new();
        collect(&schema, &schema, "", &mut rows);
        section(&mut page, kind.key, &once(&rows));
    }
    axes::section(&mut page);
    order_parameters(&mut page);
    page
}

/// One key.
#[derive(Clone, PartialEq, Eq)]
struct Row {
    path: String,
    kind: String,
    default: String,
    text: String,
}

/// What holds for all robots, and what may stand as well under a type or a robot.
const COMMON: &str = "all.";
const OWN: [&str; 2] = ["robot_types.NAME.", "robots.NAME."];

/// The keys, with one row in place of those that mean under a type or a robot what they mean under `all`.
fn once(rows: &[Row]) -> Vec<Row> {
    let is_common = |key: &str, row: &Row| {
        let under_all = rows.iter().find(|other| other.path.strip_prefix(COMMON) == Some(key));
        under_all.is_some_and(|other| Row { path: row.path.clone(), ..other.clone() } == *row)
    };
    let mut kept: Vec<Row> = Vec::new();
    for row in rows {
        let own = OWN.iter().find_map(|own| Some((own, row.path.strip_prefix(own)?)));
        let Some((own, _)) = own.filter(|(_, key)| is_common(key, row)) else {
            kept.push(row.clone());
            continue;
        };
        let path = format!("{own}…");
        if kept.iter().all(|row| row.path != path) {
            let text = "The keys of `all`, with the same meaning.".to_owned();
            kept.push(Row { path, kind: String::new(), default: String::new(), text });
        }
    }
    kept
}

fn section(page: &mut String, kind: &str, rows: &[Row]) {
    let line = |page: &mut String, text: &str| {
        page.push_str(text);
        page.push('\n');
    };
    let article = if kind == "experiment" { "An" } else { "A" };
    line(page, &format!("\n## {article} {kind} file\n"));
    line(page, "| key | value | if left out | meaning |");
    line(page, "|---|---|---|---|");
    for Row { path, kind, default, text } in rows {
        line(page, &format!("| `{path}` | {kind} | {default} | {text} |"));
    }
}

/// What the rules of a behaviour may look at.
fn order_parameters(page: &mut String) {
    page.push_str(
        "\n## Order parameters\n\nThe keys of `when` in a behaviour file, and columns of `replicates.parquet`: numbers from 0 on \
         that describe a window of a run.\n\
         Those that need an arena with walls are refused where there is none.\n\n\
         | key | unit | at most | meaning | needs |\n|---|---|---|---|---|\n",
    );
    for it in Parameter::all() {
        let most = if it.most().is_finite() { it.most().to_string() } else { String::new() };
        let needs = [
            (Prerequisite::Commands, "commands"),
            (Prerequisite::Reach, "reach"),
            (Prerequisite::Radius, "radius of the bodies"),
            (Prerequisite::Arena, "arena"),
            (Prerequisite::Objects, "objects"),
            (Prerequisite::Goals, "goals"),
            (Prerequisite::Classes, "classes of robots"),
        ];
        let needs: Vec<&str> =
            needs.iter().filter(|(what, _)| it.needs(*what)).map(|(_, words)| *words).collect();
        let words = it.words().replace('|', "\\|");
        writeln!(page, "| `{it}` | {} | {most} | {words} | {} |", it.unit(), needs.join(", "))
            .expect("a text takes whatever is written to it");
    }
}

/// The definition that a schema refers to, or itself.
fn resolved<'a>(schema: &'a Value, root: &'a Value) -> &'a Value {
    let name = schema["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/"));
    name.map_or(schema, |name| &root["$defs"][name])
}

/// The schema of what is there, where it may also not be there.
fn given<'a>(schema: &'a Value, root: &'a Value) -> &'a Value {
    let schema = resolved(schema, root);
    let choices = schema["anyOf"].as_array();
    let there = choices.and_then(|choices| {
        let is_there = |choice: &&Value| choice["type"] != "null";
        let mut there = choices.iter().filter(is_there);
        there.next().filter(|_| choices.len() == 2 && there.next().is_none())
    });
    there.map_or(schema, |there| resolved(there, root))
}

/// Adds the keys of an object, and those below them.
fn collect(schema: &Value, root: &Value, prefix: &str, rows: &mut Vec<Row>) {
    let Some(properties) = schema["properties"].as_object() else { return };
    // Axes have a table of their own.
    let has_axes = properties.contains_key(Axis::SensorBearing.key());
    let is_axis = |key: &str| has_axes && Axis::ALL.iter().any(|axis| axis.key() == key);
    let required = schema["required"].as_array();
    let is_required = |key: &str| required.is_some_and(|keys| keys.iter().any(|it| it == key));
    for (key, property) in properties.iter().filter(|(key, _)| !is_axis(key)) {
        let path = format!("{prefix}{key}");
        let below = given(property, root);
        rows.push(Row {
            kind: kind(below, root),
            default: if is_required(key) { "required".to_owned() } else { default(property) },
            text: text(property).or_else(|| text(below)).unwrap_or_default(),
            path: path.clone(),
        });
        collect_below(below, root, &path, rows);
    }
}

/// What is below a key: an object, the items of a list, the entries of a map, or one of several.
fn collect_below(schema: &Value, root: &Value, path: &str, rows: &mut Vec<Row>) {
    collect(schema, root, &format!("{path}."), rows);
    let items = given(&schema["items"], root);
    if items["properties"].is_object() {
        collect(items, root, &format!("{path}[]."), rows);
    }
    let entries = given(&schema["additionalProperties"], root);
    if entries["properties"].is_object() {
        collect(entries, root, &format!("{path}.NAME."), rows);
    }
    for choice in schema["anyOf"].as_array().into_iter().flatten() {
        collect(resolved(choice, root), root, &format!("{path}."), rows);
    }
    for choice in schema["oneOf"].as_array().into_iter().flatten() {
        let Some(properties) = choice["properties"].as_object() else { continue };
        let tag = properties.values().find_map(|property| property["const"].as_str());
        let Some(tag) = tag else { continue };
        let rest: Map<String, Value> = properties
            .iter()
            .filter(|(_, property)| property["const"].is_null())
            .map(|(key, property)| (key.clone(), property.clone()))
            .collect();
        let choice = serde_json::json!({"properties": rest, "required": choice["required"]});
        collect(&choice, root, &format!("{path}({tag})."), rows);
    }
}

/// What kind of value it is, in few words.
fn kind(schema: &Value, root: &Value) -> String {
    if let Some(choices) = schema["enum"].as_array() {
        return words(choices.iter());
    }
    if let Some(choices) = schema["oneOf"].as_array() {
        let constants: Vec<Value> = choices.iter().map(constant).collect();
        return words(constants.iter().filter(|word| word.is_string()));
    }
    if let Some(choices) = schema["anyOf"].as_array() {
        let kinds = choices.iter().map(|choice| match choice["const"].as_str() {
            Some(word) => format!("`{word}`"),
            None => kind(resolved(choice, root), root),
        });
        return kinds.collect::<Vec<_>>().join(" or ");
    }
    // What may be left out may be null as well.
    let types = schema["type"].as_array();
    let there = types.and_then(|types| types.iter().find(|kind| **kind != "null"));
    match there.unwrap_or(&schema["type"]).as_str() {
        Some("array") => format!("list of: {}", kind(given(&schema["items"], root), root)),
        Some("object") if schema["properties"][Axis::SensorBearing.key()].is_object() => {
            "axes".to_owned()
        }
        Some("object") => "map".to_owned(),
        Some("integer") => "whole number".to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("string") => "text".to_owned(),
        Some(other) => other.to_owned(),
        None => "any".to_owned(),
    }
}

/// The word that stands for a choice, or the key and the word by which a map is recognised.
fn constant(choice: &Value) -> Value {
    let tags = choice["properties"].as_object().into_iter().flatten();
    let tagged = tags.filter_map(|(key, property)| Some((key, property["const"].as_str()?)));
    let mut tagged = tagged.map(|(key, word)| Value::from(format!("{key}: {word}")));
    match &choice["const"] {
        own @ Value::String(_) => own.clone(),
        // Else the only key that a map of this choice has.
        _ => tagged.next().or_else(|| only_key(choice)).unwrap_or(Value::Null),
    }
}

fn only_key(choice: &Value) -> Option<Value> {
    let mut keys = choice["properties"].as_object()?.keys();
    let key = keys.next().filter(|_| keys.next().is_none())?;
    Some(Value::from(format!("{key}: …")))
}

fn words<'a>(choices: impl Iterator<Item = &'a Value>) -> String {
    let quoted = choices.filter_map(Value::as_str).map(|word| format!("`{word}`"));
    quoted.collect::<Vec<_>>().join(", ")
}

fn default(property: &Value) -> String {
    match &property["default"] {
        Value::Null | Value::Object(_) | Value::Array(_) => String::new(),
        Value::String(word) => format!("`{word}`"),
        other => other.to_string(),
    }
}

/// A description on one line.
fn text(schema: &Value) -> Option<String> {
    let text = schema["description"].as_str()?;
    let first = text.split("\n\n").next().unwrap_or_default();
    Some(first.replace('\n', " ").replace('|', "\\|"))
}
