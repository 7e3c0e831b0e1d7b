//! Flags for drawing options, generated from the option table.
//!
//! A verb is a type that implements [`OptionSubset`] and says which rows of the table it takes.
//! [`OptionFlags`] collects the values as JSON fields and lets the table parse them, so that flags,
//! presets and the station's API accept the same values with the same messages.

use std::fmt;
use std::io::Read;
use std::marker::PhantomData;
use std::path::Path;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, ValueHint};
use magician_program::{
    DefaultValue, FontChoice, Format, OptionError, OptionGroup, OptionKind, OptionSpec,
    SetupOptions, WorkOption,
};
use serde_json::{Map, Value};

use crate::failure::Failure;

/// Largest font file, bytes. A choice; the largest CJK fonts are smaller.
const MAX_FONT_SIZE: u64 = 128 << 20;
/// Longest list of choices shown as a value's placeholder, in characters.
const MAX_CHOICES_WIDTH: usize = 26;
/// Additional names of flags.
const ALIASES: [(&str, &str); 1] = [("grid", "pallet")];
/// Formats whose coordinates are the arm's own.
const ARM_COORDINATE_FORMATS: [Format; 4] = [
    Format::Playback,
    Format::Blockly,
    Format::Points,
    Format::Plan,
];

/// Verb with flags for drawing options.
pub(crate) trait OptionSubset {
    /// True if the verb has flags for this option.
    fn accepts(option: &OptionSpec) -> bool;
}

/// Declares marker types for verbs and the options they take.
macro_rules! verbs {
    ($($(#[$doc:meta])* $verb:ident: $takes:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $verb;

        impl OptionSubset for $verb {
            fn accepts(option: &OptionSpec) -> bool {
                let takes: fn(&OptionSpec) -> bool = $takes;
                // The verb itself decides between drawing and engraving.
                option.name != "work" && takes(option)
            }
        }
    )*};
}

verbs! {
    /// `draw`. Outlines are the verb `frame`.
    Draws: |option| option.work != Some(WorkOption::Engrave) && !is_frame(option);
    /// `engrave`.
    Engraves: |option| option.work != Some(WorkOption::Draw);
    /// `frame`, which has its own flag for the shape.
    Frames: |option| option.name != "frame";
    /// `write`.
    Writes: |option| Draws::accepts(option) && option.counts_for(Format::Text);
    /// `play`.
    Plays: |option| !is_frame(option) && ARM_COORDINATE_FORMATS.iter().any(|format| option.counts_for(*format));
    /// `testgrid`, which determines powers and speeds itself.
    Grids: |option| option.counts_for(Format::TestGrid)
        || ["tool", "width", "height", "stay"].contains(&option.name);
    /// `run` and `convert`.
    RunsAll: |_| true;
    /// `preset save`. A preset does not decide whether only the outline is traced.
    Makes: |option| !is_frame(option);
}

fn is_frame(option: &OptionSpec) -> bool {
    option.name.starts_with("frame")
}

/// Option values from the flags of a verb.
pub(crate) struct OptionFlags<V> {
    fields: Map<String, Value>,
    /// Path of a font file, if the font is not built in.
    font: Option<String>,
    pens: Option<String>,
    verb: PhantomData<V>,
}

impl<V> fmt::Debug for OptionFlags<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("OptionFlags").field(&self.fields).finish()
    }
}

impl<V> OptionFlags<V> {
    /// Sets an option that has no flag here.
    pub(crate) fn set_option(&mut self, name: &str, value: impl Into<Value>) {
        self.fields.insert(name.to_owned(), value.into());
    }

    /// Returns the options. With a preset the check that they agree is left for later, since the
    /// preset fills in the rest.
    pub(crate) fn options(&self, has_preset: bool) -> Result<SetupOptions, Failure> {
        let mut fields = self.fields.clone();
        if let Some(path) = &self.pens {
            let pens = magician_job::pens::read(Path::new(path)).map_err(Failure::invalid)?;
            let pens =
                serde_json::to_value(pens).map_err(|error| Failure::invalid(error.to_string()))?;
            fields.insert("pens".to_owned(), pens);
        }
        let options = if has_preset {
            SetupOptions::from_partial_fields(&fields)
        } else {
            SetupOptions::from_fields(&fields)
        };
        let mut options = options.map_err(|error| refused(&error, &fields))?;
        if let Some(path) = &self.font {
            options.font = Some(font(path)?);
        }
        Ok(options)
    }
}

/// Converts a rejected option into a failure that names its flag. The sentence is the same in all
/// front ends.
fn refused(error: &OptionError, fields: &Map<String, Value>) -> Failure {
    let flag = |name: &str| name.replace('_', "-");
    let key = flag(&error.key);
    if let Some(need) = error.needs {
        let partner = flag(need.name);
        let needs = need
            .to_string()
            .replacen(need.name, &format!("`--{partner}`"), 1);
        let failure = Failure::usage(format!("`--{key}` needs {needs}"));
        return match SetupOptions::option(need.name).filter(|_| need.values.is_empty()) {
            Some(row) => failure.hint(format!("--{partner} takes {}", row.accepted())),
            None => failure,
        };
    }
    let no = match fields.get(&error.key) {
        Some(Value::Bool(false)) => "no-",
        _ => "",
    };
    Failure::usage(format!("--{no}{key}: {}", error.message))
}

/// Loads a font file.
fn font(path: &str) -> Result<FontChoice, Failure> {
    let read = std::fs::File::open(path).and_then(|file| {
        let mut bytes = Vec::new();
        file.take(MAX_FONT_SIZE).read_to_end(&mut bytes)?;
        Ok(bytes)
    });
    let bytes = read.map_err(|error| {
        let row = SetupOptions::option("font");
        let refusal = row.map(|row| String::from(row.refusal(&path.into())));
        let refusal = refusal.unwrap_or_default();
        Failure::usage(format!("--font: {refusal}; as a file: {error}"))
    })?;
    Ok(FontChoice::file(path, bytes))
}

/// Returns the flags of an option: one to set it and one to switch it off.
fn flags_of(row: &'static OptionSpec) -> Vec<Arg> {
    let (name, heading) = (row.name, heading(row.group));
    let flag = |no: &str| {
        let long = format!("{no}{}", name.replace('_', "-"));
        Arg::new(long.replace('-', "_"))
            .long(long)
            .help_heading(heading)
    };
    if row.kind == OptionKind::Switch {
        let on = || flag("").action(ArgAction::SetTrue).help(help(row));
        let off = || flag("no-").action(ArgAction::SetTrue).help(row.off);
        return match (row.is_off(), row.has_both_positions()) {
            (true, _) => vec![on()],
            (false, false) => vec![off()],
            (false, true) => vec![on().conflicts_with(format!("no_{name}")), off()],
        };
    }
    let mut arg = flag("")
        .help(help(row))
        .value_name(placeholder(row))
        .value_parser(CompletingParser(completions(row)))
        .hide_possible_values(true);
    arg = match row.kind {
        OptionKind::List => arg.action(ArgAction::Append),
        OptionKind::Number | OptionKind::Integer => arg.allow_negative_numbers(true),
        OptionKind::Point | OptionKind::Place | OptionKind::Area | OptionKind::Text => {
            arg.allow_hyphen_values(true)
        }
        OptionKind::Choice | OptionKind::Switch | OptionKind::Pens => arg,
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    // The bias of a tool has negative numbers.
    if name == "tool" {
        arg = arg.allow_hyphen_values(true);
    }
    // A bare `--frame` means the default shape; without `=` the next word is the file.
    if name == "frame" {
        arg = arg
            .num_args(0..=1)
            .require_equals(true)
            .default_missing_value("box");
    }
    if placeholder(row).contains("FILE") {
        arg = arg.value_hint(ValueHint::FilePath);
    }
    let aliases = ALIASES.iter().filter(|(of, _)| *of == name);
    vec![aliases.fold(arg, |arg, (_, alias)| arg.visible_alias(*alias))]
}

/// Returns the heading of a group in the help.
const fn heading(group: OptionGroup) -> &'static str {
    match group {
        OptionGroup::Place => "Tool and placement",
        OptionGroup::Fill => "Fill",
        OptionGroup::Text => "Text",
        OptionGroup::Parts => "Layers, pens and colours",
        OptionGroup::Image => "Images",
        OptionGroup::Laser => "Laser",
        OptionGroup::Pen => "Lines and pen",
        OptionGroup::More => "Run",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Returns the words for completion; empty if other values are accepted too.
fn completions(row: &OptionSpec) -> &'static [&'static str] {
    match row.expects {
        "" => row.choices,
        _ => &[],
    }
}

fn placeholder(row: &OptionSpec) -> String {
    let of_kind = match row.kind {
        OptionKind::Choice => {
            let words = row.choices.join("|");
            return match words.len() {
                _ if !row.placeholder.is_empty() => row.placeholder.to_owned(),
                0..=MAX_CHOICES_WIDTH => words,
                _ => "WORD".to_owned(),
            };
        }
        OptionKind::Number if row.unit == "mm" => "MM",
        OptionKind::Number if row.unit == "mm/s" => "MM/S",
        OptionKind::Number if row.unit == "deg" => "DEGREES",
        OptionKind::Number if row.unit == "%" => "PERCENT",
        OptionKind::Number | OptionKind::Integer => "N",
        OptionKind::Point => "X,Y",
        OptionKind::Place => "X,Y,Z",
        OptionKind::Area => "X,Y,W,H",
        OptionKind::Text | OptionKind::List => "TEXT",
        OptionKind::Pens => "FILE",
        OptionKind::Switch => "",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    match row.placeholder {
        "" => of_kind.to_owned(),
        own => own.to_owned(),
    }
}

/// Returns the help text of an option with its default.
fn help(row: &OptionSpec) -> String {
    let mut help = row.about.to_owned();
    if placeholder(row) == "WORD" {
        help += &format!(": {}", row.choices.join(", "));
    }
    if row.kind == OptionKind::Pens {
        help += ": a TOML file of [[pen]] tables";
    }
    if !row.detail.is_empty() {
        help += &format!(". {}", row.detail.trim_end_matches('.'));
    }
    let default = match row.default {
        _ if !row.usually.is_empty() => row.usually.to_owned(),
        Some(DefaultValue::Number(number)) => number.to_string(),
        Some(DefaultValue::Word(word)) if row.name != "tool" => word.to_owned(),
        _ => return help,
    };
    format!("{help} [default: {default}]")
}

impl<V: OptionSubset> Args for OptionFlags<V> {
    fn augment_args(command: Command) -> Command {
        let rows = SetupOptions::OPTIONS.iter().filter(|row| V::accepts(row));
        let mut rows: Vec<_> = rows.collect();
        rows.sort_by_key(|row| row.group);
        let flags = rows.into_iter().flat_map(flags_of);
        flags.fold(command, Command::arg)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<V: OptionSubset> FromArgMatches for OptionFlags<V> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut flags = Self {
            fields: Map::new(),
            font: None,
            pens: None,
            verb: PhantomData,
        };
        flags.update_from_arg_matches(matches)?;
        Ok(flags)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let is_on = |id: &str| matches.try_get_one(id).ok().flatten() == Some(&true);
        for row in SetupOptions::OPTIONS.iter().filter(|row| V::accepts(row)) {
            let name = row.name;
            if row.kind == OptionKind::Switch {
                for (id, position) in [(name.to_owned(), true), (format!("no_{name}"), false)] {
                    if is_on(&id) {
                        self.set_option(name, position);
                    }
                }
                continue;
            }
            let texts = matches.get_many::<String>(name).into_iter().flatten();
            for text in texts {
                match (row.kind, row.value_of(text)) {
                    (OptionKind::Pens, _) => self.pens = Some(text.clone()),
                    _ if name == "font" && text.parse::<FontChoice>().is_err() => {
                        self.font = Some(text.clone());
                    }
                    (OptionKind::List, Value::Array(mut items)) => {
                        match self.fields.get_mut(name).and_then(Value::as_array_mut) {
                            Some(all) => all.append(&mut items),
                            None => self.set_option(name, items),
                        }
                    }
                    (_, value) => self.set_option(name, value),
                }
            }
        }
        Ok(())
    }
}

/// Value parser that accepts any text and completes these words. The option table validates the
/// value.
#[derive(Clone, Debug)]
struct CompletingParser(&'static [&'static str]);

impl TypedValueParser for CompletingParser {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let words = self.0.iter().copied().map(PossibleValue::new);
        (!self.0.is_empty()).then(|| Box::new(words) as Box<dyn Iterator<Item = PossibleValue>>)
    }
}
