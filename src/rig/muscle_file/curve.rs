//! Values over time: a plain list of keys, or a table that says besides how they are joined.

use super::tables::EaseName;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{
    Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer,
    value::SeqAccessDeserializer,
};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Keys of one number: `[seconds, value]`, or `[seconds, value, slope in, slope out]`.
pub(super) type CurveTable = KeyList<Vec<f32>>;
/// Keys of the exponents: `[seconds, alpha, beta]`.
pub(super) type ShapeCurveTable = KeyList<Exact<(f32, u32, u32)>>;

/// A list of so many values and no more: what is left over would be lost without a word.
pub(super) struct Exact<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Exact<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Whole<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Whole<T> {
            type Value = Exact<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Self::Value, A::Error> {
                let value = T::deserialize(SeqAccessDeserializer::new(&mut values))?;
                match values.next_element::<IgnoredAny>()? {
                    None => Ok(Exact(value)),
                    Some(_) => Err(Error::custom("the list is too long; three numbers are needed")),
                }
            }
        }
        from.deserialize_seq(Whole(PhantomData))
    }
}

impl<T: JsonSchema> JsonSchema for Exact<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// Keys with the way they are joined.
pub(super) struct KeyList<P> {
    pub ease: EaseName,
    pub points: Vec<P>,
}

/// How the keys are joined, with the keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Eased<P> {
    #[serde(default)]
    ease: EaseName,
    points: Vec<P>,
}

// By hand rather than `untagged`, which would forget where in the file a mistake is.
impl<'de, P: Deserialize<'de>> Deserialize<'de> for KeyList<P> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Either<P>(PhantomData<P>);
        impl<'de, P: Deserialize<'de>> Visitor<'de> for Either<P> {
            type Value = KeyList<P>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of keys, or a table of `ease` and `points`")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, keys: A) -> Result<Self::Value, A::Error> {
                let points = Vec::deserialize(SeqAccessDeserializer::new(keys))?;
                Ok(KeyList { ease: EaseName::Linear, points })
            }

            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Self::Value, A::Error> {
                let Eased { ease, points } = Eased::deserialize(MapAccessDeserializer::new(table))?;
                Ok(KeyList { ease, points })
            }
        }
        from.deserialize_any(Either(PhantomData))
    }
}

/// What distinguishes the two kinds of keys in the schema.
trait KeyPoint {
    const NAME: &'static str;
    fn point() -> Schema;
}

impl KeyPoint for Vec<f32> {
    const NAME: &'static str = "Curve";

    fn point() -> Schema {
        json_schema!({
            "description": "[seconds, value]; of a cubic curve also [seconds, value, slope in, slope out], per second",
            "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 4,
        })
    }
}

impl KeyPoint for Exact<(f32, u32, u32)> {
    const NAME: &'static str = "ShapeCurve";

    fn point() -> Schema {
        json_schema!({
            "description": "[seconds, alpha, beta]",
            "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3,
        })
    }
}

impl<P: KeyPoint> JsonSchema for KeyList<P> {
    fn schema_name() -> Cow<'static, str> {
        P::NAME.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let point = P::point();
        let ease = generator.subschema_for::<EaseName>();
        json_schema!({
            "anyOf": [
                { "description": "Keys joined by straight lines.", "type": "array", "items": point },
                {
                    "description": "Keys and how they are joined.",
                    "type": "object",
                    "properties": { "ease": ease, "points": { "type": "array", "items": point } },
                    "required": ["points"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}
