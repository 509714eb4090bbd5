//! The JSON Schema of study files, generated from their types, and a walk along it that finds all problems of a file at
//! once.

use std::sync::LazyLock;

use serde_json::Value;

use super::definition::Definition;
use super::problem::Problem;

/// Generates the schema that is checked in as `studies/schema.json`.
pub fn generate() -> Value {
    schemars::schema_for!(Definition).to_value()
}

/// Checks a value's form: keys, types, ranges, names of choices. Without problems it can be deserialised.
pub fn check(value: &Value) -> Vec<Problem> {
    static SCHEMA: LazyLock<Value> = LazyLock::new(generate);
    let mut walk = SchemaWalk { root: &SCHEMA, problems: Vec::new() };
    walk.visit(&SCHEMA, value, "");
    walk.problems
}

struct SchemaWalk<'a> {
    root: &'a Value,
    problems: Vec<Problem>,
}

impl<'a> SchemaWalk<'a> {
    fn say(&mut self, path: &str, what: String) {
        self.problems.push(Problem { path: path.to_owned(), what });
    }

    /// Follows `$ref` and the `anyOf [type, null]` of an optional value.
    fn target(&self, schema: &'a Value, value: &Value) -> &'a Value {
        if let Some(name) = schema["$ref"].as_str() {
            let pointer = name.strip_prefix('#').unwrap_or(name);
            return self.root.pointer(pointer).map_or(schema, |s| self.target(s, value));
        }
        if let Some(choices) = schema["anyOf"].as_array() {
            let is_null = |s: &&Value| s["type"] == "null";
            let chosen = choices.iter().find(|s| is_null(s) == value.is_null());
            return chosen.map_or(schema, |s| self.target(s, value));
        }
        schema
    }

    fn visit(&mut self, schema: &'a Value, value: &Value, path: &str) {
        let schema = self.target(schema, value);
        if let Some(allowed) = words(schema) {
            if !value.as_str().is_some_and(|v| allowed.contains(&v)) {
                self.say(path, format!("{} is not one of {}", short(value), quote(&allowed)));
            }
            return;
        }
        let types: Vec<&str> = match &schema["type"] {
            Value::String(one) => vec![one],
            Value::Array(many) => many.iter().filter_map(Value::as_str).collect(),
            _ => return,
        };
        if !types.iter().any(|t| has_type(value, t)) {
            self.say(path, format!("{} is not of type {}", short(value), types.join(" or ")));
            return;
        }
        match value {
            Value::Number(number) => self.range(schema, number.as_f64().unwrap_or(f64::NAN), path),
            Value::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    self.visit(&schema["items"], item, &format!("{path}[{i}]"));
                }
            }
            Value::Object(_) => self.object(schema, value, path),
            _ => {}
        }
    }

    fn range(&mut self, schema: &Value, number: f64, path: &str) {
        let (low, high) = (schema["minimum"].as_f64(), schema["maximum"].as_f64());
        if low.is_some_and(|l| number < l) || high.is_some_and(|h| number > h) {
            let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
            self.say(path, format!("{number} is not within {} to {}", bound(low), bound(high)));
        }
    }

    fn object(&mut self, schema: &'a Value, value: &Value, path: &str) {
        let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        let known = schema["properties"].as_object();
        for (key, inner) in value.as_object().into_iter().flatten() {
            match (known.and_then(|k| k.get(key)), &schema["additionalProperties"]) {
                (Some(property), _) => self.visit(property, inner, &join(key)),
                (None, Value::Bool(false)) => {
                    let keys: Vec<&str> = known.into_iter().flat_map(|k| k.keys().map(String::as_str)).collect();
                    self.say(&join(key), format!("unknown key; allowed here: {}", quote(&keys)));
                }
                (None, other) => self.visit(other, inner, &join(key)),
            }
        }
        for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            if value.get(key).is_none() {
                self.say(&join(key), "is missing".to_owned());
            }
        }
    }
}

/// The words of a plain choice, in either of the forms in which the schema writes it.
fn words(schema: &Value) -> Option<Vec<&str>> {
    if let Some(list) = schema["enum"].as_array() {
        return Some(list.iter().filter_map(Value::as_str).collect());
    }
    let choices = schema["oneOf"].as_array()?;
    let mut out = Vec::new();
    for choice in choices {
        match (&choice["const"], choice["enum"].as_array()) {
            (Value::String(word), _) => out.push(word.as_str()),
            (_, Some(list)) => out.extend(list.iter().filter_map(Value::as_str)),
            _ => return None,
        }
    }
    Some(out)
}

fn has_type(value: &Value, name: &str) -> bool {
    match name {
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        _ => false,
    }
}

fn quote(words: &[&str]) -> String {
    words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")
}

/// A value in a message, cut where it is long.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 40 { text } else { text.chars().take(40).chain(['…']).collect() }
}
