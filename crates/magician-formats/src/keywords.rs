//! Enums whose values options and files name by a word.

/// Gives an enum its words: `ALL`, `NAMES`, `name`, and the conversions between a value and its
/// word, including JSON. `$what` names the value in the message about an unknown word.
#[doc(hidden)]
#[macro_export]
macro_rules! keywords {
    ($kind:ident, $what:literal: $($variant:ident = $name:literal),* $(,)?) => {
        impl $kind {
            /// All values.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];
            /// Their names, in the same order.
            pub const NAMES: &'static [&'static str] = &[$($name),*];

            /// Name in options and files.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl serde::Serialize for $kind {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $kind {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = String::deserialize(deserializer)?;
                text.parse().map_err(serde::de::Error::custom)
            }
        }

        impl std::str::FromStr for $kind {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                let named = Self::ALL.into_iter().find(|one| one.name() == text);
                named.ok_or_else(|| $crate::keywords::unknown($what, Self::NAMES, text))
            }
        }
    };
}

pub use keywords;

/// Message that `text` is not one of these words.
pub fn unknown(what: &str, names: &[&str], text: &str) -> String {
    let (last, rest) = names.split_last().unwrap_or((&"", &[]));
    let rest: Vec<_> = rest.iter().map(|name| format!("'{name}'")).collect();
    format!("{what} is {} or '{last}', not '{text}'", rest.join(", "))
}
