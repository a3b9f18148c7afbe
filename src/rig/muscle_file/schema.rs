//! The JSON Schema of the muscle file, for editors that check while one types.

use super::tables::File;
use serde_json::Value;

/// The JSON Schema of the muscle file: every key with its description, unknown keys forbidden.
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(File).to_value();
    without_null(&mut schema);
    schema
}

/// TOML has no null: a key that may be left out is left out.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if object.get("default").is_some_and(Value::is_null) {
                object.remove("default");
            }
            if let Some(Value::Array(types)) = object.get_mut("type") {
                types.retain(|t| t != "null");
                if let [only] = &types[..] {
                    let only = only.clone();
                    object.insert("type".into(), only);
                }
            }
            if let Some(Value::Array(choices)) = object.get_mut("anyOf") {
                choices.retain(|choice| choice.get("type").is_none_or(|t| t != "null"));
                if let [Value::Object(only)] = &choices[..] {
                    let only = only.clone();
                    object.remove("anyOf");
                    object.extend(only);
                }
            }
            object.values_mut().for_each(without_null);
        }
        Value::Array(items) => items.iter_mut().for_each(without_null),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every key of every table of the schema, as `Table.key`.
    fn keys(schema: &Value) -> Vec<String> {
        let definitions = schema["$defs"].as_object().expect("definitions").iter();
        let tables = definitions.map(|(name, table)| (name.as_str(), table)).chain([("File", schema)]);
        let mut keys = Vec::new();
        for (name, table) in tables {
            let Some(properties) = table.get("properties").and_then(Value::as_object) else { continue };
            assert_eq!(table["additionalProperties"], false, "{name} lets unknown keys through");
            for (key, property) in properties {
                assert!(property["description"].is_string(), "{name}.{key} is not described");
                keys.push(format!("{name}.{key}"));
            }
        }
        keys
    }

    #[test]
    fn every_key_is_described_and_no_other_is_allowed() {
        let schema = schema();
        let keys = keys(&schema);
        // What deserialising says that it knows is what the schema has to name.
        let known = |text: &str| {
            let error = toml::from_str::<File>(text).err().expect("an unknown key").message().to_owned();
            let list = error.rsplit_once("expected ").expect("a list").1.to_owned();
            list.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()
        };
        let muscle = |text: &str| format!("[[muscle]]\n{text} = {{ zzz = 1 }}");
        let driver = |text: &str| format!("[[muscle]]\ndrivers = [{{ {text} }}]");
        for (table, text) in [
            ("File", "zzz = 1".to_owned()),
            ("CharacterTable", "[character]\nzzz = 1".into()),
            ("MuscleTable", "[[muscle]]\nzzz = 1".into()),
            ("AttachmentTable", muscle("origin")),
            ("WrapTable", muscle("wrap")),
            ("FibresTable", muscle("fibres")),
            ("ActiveTable", muscle("active")),
            ("KeysTable", muscle("keys")),
            ("DriverTable", driver("zzz = 1")),
            ("LengthTable", driver("length = { zzz = 1 }")),
            ("AngleTable", driver("angle = { zzz = 1 }")),
            ("TimeTable", driver("table = { zzz = 1 }")),
            ("BoneTable", "[[bone]]\nzzz = 1".into()),
            ("JointTable", "[joints.a]\nzzz = 1".into()),
            ("GroupTable", "[groups.a]\nzzz = 1".into()),
            ("MarkTable", "[[mark]]\nzzz = 1".into()),
            ("CapsuleTable", "[[bone]]\ncapsule = { zzz = 1 }".into()),
        ] {
            let mut known: Vec<String> = known(&text).iter().map(|key| format!("{table}.{key}")).collect();
            let mut named: Vec<String> = keys.iter().filter(|k| k.starts_with(&format!("{table}."))).cloned().collect();
            known.sort();
            named.sort();
            assert!(!known.is_empty());
            assert_eq!(named, known);
        }
        let curve = &schema["$defs"]["Curve"]["anyOf"][1];
        assert_eq!(
            (&curve["additionalProperties"], curve["properties"].as_object().map(|p| p.len())),
            (&false.into(), Some(2))
        );
        assert!(!schema.to_string().contains("null"));
    }

    #[test]
    fn a_table_that_lets_keys_through_is_caught() {
        let mut open = schema();
        open["$defs"]["ActiveTable"]["additionalProperties"] = true.into();
        assert!(std::panic::catch_unwind(|| keys(&open)).is_err());
    }
}
