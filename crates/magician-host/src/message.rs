//! Sentences for people, each kept with its template and values, so that front ends can translate
//! it.
//!
//! The English template is the key of a sentence: front ends look up the translation by it and fill
//! in the values. So every sentence is written once, where its facts are known, and no front end
//! parses text.

use std::borrow::Cow;
use std::fmt;
use std::ops::Deref;

use crate::{Error, Setting};

/// A sentence for people. [`message!`](macro@crate::message) makes one from a template and values.
/// A message from plain text has no template and is the same in every language.
///
/// ```
/// use magician_host::message;
///
/// let height = -60.0;
/// let sentence = message!("a surface at z = {height:.1} cannot be reached", height);
/// assert_eq!(sentence.as_str(), "a surface at z = -60.0 cannot be reached");
/// let template = sentence.template().unwrap();
/// assert_eq!(template, "a surface at z = {height} cannot be reached");
/// assert_eq!(sentence.values()[0].1.to_string(), "-60.0");
/// ```
#[derive(Clone, Debug, Default)]
pub struct Message(Box<Parts>);

#[derive(Clone, Debug, Default)]
struct Parts {
    text: String,
    template: Cow<'static, str>,
    values: Vec<(Cow<'static, str>, MessageValue)>,
}

/// A value in a [`Message`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum MessageValue {
    /// Number or quotation as printed, the same in every language.
    Text(String),
    /// Words with a template of their own.
    Message(Message),
    /// Option by its name in `snake_case`. Front ends substitute their own name for it.
    Option(Cow<'static, str>),
}

impl Message {
    /// Creates a message from its parts; `text` is the template with the values filled in. Use
    /// [`message!`](macro@crate::message).
    #[must_use]
    pub fn from_parts(
        text: String,
        template: impl Into<Cow<'static, str>>,
        values: Vec<(Cow<'static, str>, MessageValue)>,
    ) -> Self {
        Self(Box::new(Parts {
            text,
            template: template.into(),
            values,
        }))
    }

    /// Creates a word for use in other messages, such as the name of a kind of shape.
    #[must_use]
    pub fn word(word: &'static str) -> Self {
        Self::from_parts(word.to_owned(), word, Vec::new())
    }

    /// Joins sentences with semicolons; `None` without any.
    #[must_use]
    pub fn joined(sentences: impl IntoIterator<Item = Self>) -> Option<Self> {
        { sentences.into_iter() }
            .reduce(|before, next| crate::message!("{before}; {next}", before, next))
    }

    /// English text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0.text
    }

    /// English text with names in braces in place of values: the key for translations. `None` for a
    /// text without a template.
    #[must_use]
    pub fn template(&self) -> Option<Cow<'_, str>> {
        let template = &self.0.template;
        (!template.is_empty()).then(|| without_formats(template))
    }

    /// Values by the names of their placeholders.
    #[must_use]
    pub fn values(&self) -> &[(Cow<'static, str>, MessageValue)] {
        &self.0.values
    }
}

/// Removes formats from placeholders: `{height:.1}` becomes `{height}`.
fn without_formats(template: &str) -> Cow<'_, str> {
    // Most templates have no placeholders: return them without a copy.
    if !template.contains(['{', '}']) {
        return template.into();
    }
    let mut out = String::with_capacity(template.len());
    let mut is_format = false;
    let mut is_place = false;
    for letter in template.chars() {
        match letter {
            '{' => is_place = true,
            '}' => (is_place, is_format) = (false, false),
            ':' if is_place => is_format = true,
            _ => {}
        }
        if !is_format {
            out.push(letter);
        }
    }
    out.into()
}

/// Returns the number of decimals that a template requests for a value. `None` if it does not.
#[doc(hidden)]
#[must_use]
pub fn message_decimals(template: &str, name: &str) -> Option<usize> {
    let (_, format) = { template.split('{') }
        .filter_map(|place| place.split('}').next()?.split_once(':'))
        .find(|(place, _)| *place == name)?;
    // Only decimals are supported: widths and signs have no meaning in other languages.
    format.strip_prefix('.')?.parse().ok()
}

/// A type whose values may be used in messages.
pub trait ToMessageValue {
    /// Returns the value, with this number of decimals if it is a number.
    fn to_message_value(&self, decimals: Option<usize>) -> MessageValue;
}

/// Types printed as numbers. Other types must be passed as `format_args!(..)`, so that words in
/// them are noticed as untranslated.
macro_rules! printed {
    ($($kind:ty),*) => {$(
        impl ToMessageValue for $kind {
            fn to_message_value(&self, decimals: Option<usize>) -> MessageValue {
                MessageValue::Text(match decimals {
                    Some(decimals) => format!("{self:.decimals$}"),
                    None => self.to_string(),
                })
            }
        }
    )*};
}

printed!(
    f32, f64, i8, i16, i32, i64, isize, u8, u16, u32, u64, usize, u128, char
);

/// Types printed as text. Decimals are ignored: as a precision they would truncate the text.
macro_rules! quoted {
    ($($kind:ty),*) => {$(
        impl ToMessageValue for $kind {
            fn to_message_value(&self, _decimals: Option<usize>) -> MessageValue {
                MessageValue::Text(self.to_string())
            }
        }
    )*};
}

quoted!(str, String, Cow<'_, str>, fmt::Arguments<'_>);

impl<T: ToMessageValue + ?Sized> ToMessageValue for &T {
    fn to_message_value(&self, decimals: Option<usize>) -> MessageValue {
        (**self).to_message_value(decimals)
    }
}

impl ToMessageValue for Message {
    fn to_message_value(&self, _decimals: Option<usize>) -> MessageValue {
        match self.template() {
            Some(_) => MessageValue::Message(self.clone()),
            // A quotation: front ends must not look for a translation of it.
            None => MessageValue::Text(self.as_str().to_owned()),
        }
    }
}

/// The sentence of the error, without the command that `Display` puts before it.
impl ToMessageValue for Error {
    fn to_message_value(&self, decimals: Option<usize>) -> MessageValue {
        self.sentence().to_message_value(decimals)
    }
}

impl ToMessageValue for Setting {
    fn to_message_value(&self, _decimals: Option<usize>) -> MessageValue {
        MessageValue::Option(self.name().into())
    }
}

/// An option as a value in a message, by its name in `snake_case`.
#[derive(Clone, Copy, Debug)]
pub struct OptionName(pub &'static str);

impl fmt::Display for OptionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl ToMessageValue for OptionName {
    fn to_message_value(&self, _decimals: Option<usize>) -> MessageValue {
        MessageValue::Option(self.0.into())
    }
}

/// Makes a [`Message`] from an English sentence and the values in it:
/// `message!("{count} of {all} steps", count, all = steps.len())`.
///
/// A placeholder may give its decimals: `{height:.1}`. Each template is a whole sentence, so that a
/// language with another word order can translate it; a word in it that varies is a message too.
#[macro_export]
macro_rules! message {
    ($template:literal $(, $name:ident $(= $value:expr)?)* $(,)?) => {
        match ($(&$crate::message!(@value $name $(, $value)?),)*) {
            ($($name,)*) => $crate::Message::from_parts(
                format!($template $(, $name = $name)*),
                $template,
                ::std::vec![$((
                    ::std::borrow::Cow::Borrowed(stringify!($name)),
                    $crate::ToMessageValue::to_message_value(
                        $name,
                        $crate::message_decimals($template, stringify!($name)),
                    ),
                )),*],
            ),
        }
    };
    (@value $name:ident) => { $name };
    (@value $name:ident, $value:expr) => { $value };
}

impl Deref for Message {
    type Target = str;

    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Ignores the caller's precision: decimals of a placeholder apply to numbers, not to text.
        f.write_str(self.as_str())
    }
}

impl fmt::Display for MessageValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Message(message) => message.fmt(f),
            Self::Option(name) => f.write_str(name),
        }
    }
}

/// Compares the text, which is what people read.
impl PartialEq for Message {
    fn eq(&self, other: &Self) -> bool {
        self.as_str() == other.as_str()
    }
}

impl Eq for Message {}

impl PartialEq<str> for Message {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for Message {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl PartialEq<String> for Message {
    fn eq(&self, other: &String) -> bool {
        self.as_str() == other
    }
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Self::from_parts(text, "", Vec::new())
    }
}

impl From<&str> for Message {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<&String> for Message {
    fn from(text: &String) -> Self {
        text.clone().into()
    }
}

impl From<Cow<'_, str>> for Message {
    fn from(text: Cow<'_, str>) -> Self {
        text.into_owned().into()
    }
}

impl From<Message> for String {
    fn from(message: Message) -> Self {
        message.0.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_keeps_template_values_and_text() {
        let names = ["a", "b"];
        let sentence = message!(
            "{count} of {all} ({share:.1} %)",
            count = names.len(),
            all = 3_u8,
            share = 200.0 / 3.0
        );
        assert_eq!(sentence, "2 of 3 (66.7 %)");
        assert_eq!(
            sentence.template().as_deref(),
            Some("{count} of {all} ({share} %)")
        );
        let values: Vec<String> = (sentence.values().iter())
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        assert_eq!(values, ["count=2", "all=3", "share=66.7"]);
    }

    #[test]
    fn value_that_is_a_message_keeps_its_template() {
        let side = message!("left edge");
        let sentence = message!("the {side} is short", side);
        assert_eq!(sentence, "the left edge is short");
        assert_eq!(sentence.values()[0].1, MessageValue::Message(side));
        let quoted = Message::from("left edge");
        let sentence = message!("the {quoted} is short", quoted);
        assert!(matches!(&sentence.values()[0].1, MessageValue::Text(text) if text == "left edge"));
    }

    #[test]
    fn text_alone_has_no_template() {
        assert_eq!(Message::from("as it is".to_owned()).template(), None);
    }
}
