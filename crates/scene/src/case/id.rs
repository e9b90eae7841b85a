//! The name of a case, a string or a number, and how to find it in a line that is wrong elsewhere.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

/// Name of a case, given back with its answer. Strings and integers of 64 bits come back as they were, other numbers as the
/// nearest double.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(untagged, expecting = "`id` must be a string or a number")]
pub enum Id {
    /// A string.
    Text(String),
    /// A number.
    Number(serde_json::Number),
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl From<&str> for Id {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Id {
    /// The `id` of the object that starts `line`, even where the line breaks off or is wrong after it.
    #[must_use]
    pub fn find(line: &[u8]) -> Option<Self> {
        let mut id = None;
        let seeker = Seeker { found: &mut id };
        // The error was reported when the line was read as a case; here only the part before it counts.
        let _ = seeker.deserialize(&mut serde_json::Deserializer::from_slice(line));
        id
    }
}

/// Walks over the fields of an object and keeps the `id` it meets.
struct Seeker<'a> {
    found: &'a mut Option<Id>,
}

impl<'de> DeserializeSeed<'de> for Seeker<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Seeker<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(field) = map.next_key::<String>()? {
            if field == "id" {
                *self.found = Some(map.next_value()?);
                return Ok(());
            }
            map.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(line: &str) -> Option<String> {
        Id::find(line.as_bytes()).map(|id| serde_json::to_string(&id).unwrap())
    }

    #[test]
    fn an_id_before_the_damage_is_found() {
        assert_eq!(find(r#"{"id":"a1","receiver":{"position":[NaN,"#).as_deref(), Some(r#""a1""#));
        assert_eq!(find(r#"{"truth":{"deep":[1,{}]},"id":7,"receiver":"#).as_deref(), Some("7"));
        assert_eq!(find(r#"{"receiver":{"position":[1e999,0,0]},"id":-2.5}"#).as_deref(), Some("-2.5"));
    }

    #[test]
    fn where_none_can_be_read_none_is_made_up() {
        for line in [r#"{"receiver":1}"#, r#"{"id":null}"#, r#"{"id":["a"]}"#, r#"["id"]"#, r#"{"receiver":[NaN],"id":"a"}"#, ""]
        {
            assert_eq!(find(line), None, "{line}");
        }
    }
}
