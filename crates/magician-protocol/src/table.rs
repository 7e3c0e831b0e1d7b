//! Macros that turn the rows of [`commands`](crate::commands) into code: structs, codec, the
//! request enums and the description as constants. Their order matters: each is used by those below
//! it.

/// Implements `Readable` for the value of a row, if it has one.
macro_rules! readable {
    ($id:literal [] []) => {};
    ($id:literal [] [$value:ident]) => {
        readable! { $id [NoArgs] [$value] }
    };
    ($id:literal [$query:ident] [$value:ident]) => {
        impl Readable for $value {
            type Query = $query;
            const ROW: &'static Row = Row::of($id);
        }
    };
}

/// Implements `Writable` for what a row can set, and `Queueable` if the row says so.
macro_rules! writable {
    ($id:literal $queue:ident []) => {};
    ($id:literal yes [$set:ident]) => {
        writable! { $id no [$set] }
        impl Queueable for $set {}
    };
    ($id:literal $queue:ident [$set:ident]) => {
        impl Writable for $set {
            const ROW: &'static Row = Row::of($id);
        }
    };
}

/// Picks one item of a row's origin, `[Chapter "section" Source Confidence, errata "E22"]`.
macro_rules! origin {
    (chapter [$chapter:ident $($rest:tt)*]) => {
        Chapter::$chapter
    };
    (section [$chapter:ident $section:literal $($rest:tt)*]) => {
        $section
    };
    (source [$chapter:ident $section:literal $source:ident $($rest:tt)*]) => {
        Source::$source
    };
    (confidence [$chapter:ident $section:literal $source:ident $confidence:ident $($rest:tt)*]) => {
        Confidence::$confidence
    };
    (errata [$chapter:ident $section:literal $source:ident $confidence:ident $(, errata $errata:literal)?]) => {
        concat!($($errata)?)
    };
    (citation [$chapter:ident $section:literal $source:ident $confidence:ident $(, errata $errata:literal)?]) => {
        concat!("section ", $section $(, ", errata ", $errata)?)
    };
}

/// True if a word of a row is the expected one.
macro_rules! is_word {
    (yes yes) => {
        true
    };
    (ignored ignored) => {
        true
    };
    (burn burn) => {
        true
    };
    ($asked:ident $($other:ident)?) => {
        false
    };
}

/// The name given in a row, or the default.
macro_rules! name_or_default {
    ($default:expr) => {
        $default
    };
    ($default:expr, $name:literal) => {
        $name
    };
}

/// Declares a struct from its fields, with its wire layout.
macro_rules! layout {
    ($doc:expr, $name:ident $body:tt) => { layout! { $doc, $name $body [] } };
    (
        $doc:expr, $name:ident {
            $( $field:ident : $type:ty $(= $default:literal)? $(| $required:ident)?,
               $unit:literal, $range:tt, $about:literal; )*
        }
        [ $( $len:literal $kind:ident $(($skip:literal))? $note:literal ),* ]
    ) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $( #[doc = concat!($about, " Unit: ", $unit, ".", range_doc!($range))] pub $field: $type, )*
        }

        impl Layout for $name {
            const INFO: &'static LayoutInfo = &LayoutInfo {
                name: stringify!($name),
                fields: &[ $( Field {
                    name: crate::layout::field_name(stringify!($field)),
                    ty: <$type as Wire>::TYPE,
                    unit: $unit,
                    range: range!($range),
                    doc: $about,
                    optional: (<$type as Wire>::OPTIONAL || is_present!($($default)?)) && !is_present!($($required)?),
                    omittable: <$type as Wire>::OPTIONAL || is_present!($($default)?),
                    default: default_of!($($default)?),
                }, )* ],
                forms: &[ $( Form {
                    len: $len,
                    kind: FormKind::$kind $(($skip))?,
                    note: $note,
                }, )* ],
            };

            #[inline]
            #[allow(unused_variables)]
            fn decode(params: &[u8]) -> Result<Self, DecodeError> {
                const SIZE: Option<usize> = $name::INFO.size();
                let read = |reader: &mut Reader<'_>| {
                    Ok(Self { $( $field: read_field!(reader, $type $(, $default)?), )* })
                };
                // Fast path: almost every frame has the exact form.
                if SIZE == Some(params.len()) {
                    return read(&mut Reader::new(params));
                }
                Self::INFO.read_form(params, read)
            }

            #[inline]
            #[allow(unused_variables)]
            fn encode(&self, writer: &mut Writer<'_>) {
                $( self.$field.write(writer); )*
            }

            #[inline]
            #[allow(unused_variables)]
            fn check_fields(&self, wanted: impl Fn(&Field) -> bool) -> Result<(), RangeError> {
                let [$( $field ),*] = Self::INFO.fields else {
                    return Ok(());
                };
                $( if wanted($field) {
                    self.$field.check($field, range_beside!(self $range))?;
                } )*
                Ok(())
            }
        }

        #[cfg(feature = "serde")]
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                crate::serialize::serialize_layout(self, serializer)
            }
        }
    };
}

/// Range of a field as a [`Range`](crate::Range).
macro_rules! range {
    ([]) => {
        $crate::Range::Any
    };
    ([$least:literal..=$most:literal]) => {
        $crate::Range::Within($least, $most)
    };
    ([$least:literal..=$most:literal where absolute]) => {
        $crate::Range::Absolute($least, $most)
    };
    ([above $limit:literal]) => {
        $crate::Range::Above($limit)
    };
    ([$least:literal..=$most:literal capped]) => {
        $crate::Range::Capped($least, $most)
    };
    ([at most $count:literal $of:literal]) => {
        $crate::Range::AtMost($count, $of)
    };
    ([$( $field:ident $is:literal $name:literal $least:literal..=$most:literal $($unit:literal)? ),+]) => {
        $crate::Range::By(&[$(
            case! { $field $is $name $least $most $($unit)? }
        ),+])
    };
}

/// A [`Case`](crate::Case) of a range that depends on another field.
macro_rules! case {
    ($field:ident $is:literal $name:literal $least:literal $most:literal $($unit:literal)?) => {
        $crate::Case {
            field: stringify!($field),
            is: $is,
            name: $name,
            least: $least,
            most: $most,
            unit: concat!($($unit)?),
        }
    };
}

/// Range in force for a field, given the other fields of the struct:
/// [`Range::By`](crate::Range::By) becomes the matching case.
macro_rules! range_beside {
    ($value:ident [$( $field:ident $is:literal $name:literal $least:literal..=$most:literal $($unit:literal)? ),+]) => {
        $( if u8::from($value.$field) == $is {
            Range::By(&[case! { $field $is $name $least $most $($unit)? }])
        } else )+ {
            Range::Any
        }
    };
    ($value:ident $range:tt) => {
        range!($range)
    };
}

/// Range of a field as a sentence for the documentation.
macro_rules! range_doc {
    ([]) => {
        ""
    };
    ([$least:literal..=$most:literal]) => {
        concat!(" Range: ", $least, " to ", $most, ".")
    };
    ([$least:literal..=$most:literal where absolute]) => {
        concat!(" Range: ", $least, " to ", $most, " in absolute modes.")
    };
    ([above $limit:literal]) => {
        concat!(" Range: above ", $limit, ".")
    };
    ([$least:literal..=$most:literal capped]) => {
        concat!(" Range: ", $least, " to ", $most, "; the arm clamps larger values to ", $most, ".")
    };
    ([at most $count:literal $of:literal]) => {
        concat!(" At most ", $count, " ", $of, ".")
    };
    ([$( $field:ident $is:literal $name:literal $least:literal..=$most:literal $($unit:literal)? ),+]) => {
        concat!(" Range:" $(, " ", $least, " to ", $most, $(" ", $unit,)? " in ", $name, ";")+)
    };
}

/// True if there are any tokens.
macro_rules! is_present {
    () => {
        false
    };
    ($($any:tt)+) => {
        true
    };
}

/// The default of a field, as an `Option`.
macro_rules! default_of {
    () => {
        None
    };
    ($default:literal) => {
        Some($default)
    };
}

/// Reads a field, or takes its default at the end of the parameters.
macro_rules! read_field {
    ($reader:ident, $type:ty) => {
        <$type as Wire>::read($reader)?
    };
    ($reader:ident, $type:ty, $default:literal) => {
        if $reader.is_empty() {
            <$type as From<u8>>::from($default)
        } else {
            <$type as Wire>::read($reader)?
        }
    };
}

/// Declares the command table. A row is
///
/// ```text
/// ID "VendorName" "purpose" [Chapter "section" Source Confidence]
///               or with errata: [Chapter "section" Source Confidence, errata "E22"]
///     [queue yes|no|ignored, resend yes|no, danger yes|no, effect Effect]
///     query Args { fields }     parameters of a get, if it has any
///     state Value { fields }    a value with a get
///     param Value { fields }    a value with a get and a set
///     action Order { fields }   parameters of a set
/// ```
///
/// Any of the four forms may be absent. `, may burn` after the effect marks commands whose
/// parameters can switch the laser on; `queue ignored` marks commands that act at once whatever the
/// queued bit says. Each form may be followed by its tolerated forms:
/// `forms [ 14 Zeros "who sends it" ]`.
///
/// A field is `name: type, "unit", [range], "meaning";`. Ranges are
///
/// * `[]`: any value;
/// * `[0..=9]`, and `[0..=9 where absolute]` if the range holds only in absolute modes;
/// * `[above 0]`: exclusive lower bound;
/// * `[1..=100 capped]`: the arm clamps larger values;
/// * `[at most 23 "bytes"]`: length of a text or list;
/// * `[mode 0 "level mode" 0..=1, mode 1 "analog mode" 0..=3 "counts"]`: depends on another field.
///
/// The type may be followed by `= 0` (default of a field that the host leaves out) or by
/// `| required` (only a lenient controller accepts a frame without the field). An `Option` is a
/// field whose absence has a meaning.
macro_rules! commands {
    ($(
        $id:literal $vendor:literal $doc:literal $origin:tt
        [queue $queue:ident, resend $resend:ident, danger $danger:ident, effect $effect:ident $(, may $may:ident)?]
        $( query $query:ident $query_body:tt $( forms $query_forms:tt )? )?
        $( state $state:ident $state_body:tt $( forms $state_forms:tt )? )?
        $( param $param:ident $param_body:tt $( forms $param_forms:tt )? )?
        $( action $action:ident $( named $action_name:literal )? { $($action_body:tt)* } $( forms $action_forms:tt )? )?
    )+) => {
        $(
            $( layout! { concat!("Parameters of a get of ", $vendor, " (", origin!(citation $origin), ")."), $query $query_body $($query_forms)? } )?
            $( layout! { concat!($doc, "\n\nId ", $id, ", ", origin!(citation $origin), "; the reply to a get."), $state $state_body $($state_forms)? } )?
            $( layout! { concat!($doc, "\n\nId ", $id, ", ", origin!(citation $origin), "; readable and writable."), $param $param_body $($param_forms)? } )?
            $( layout! { concat!($doc, "\n\nId ", $id, ", ", origin!(citation $origin), "; the parameters of a set."), $action { $($action_body)* } $($action_forms)? } )?

            readable! { $id [ $($query)? ] [ $($state)? $($param)? ] }
            writable! { $id $queue [ $($param)? $($action)? ] }
        )+

        /// Section number in the vendor's document. The table writes `none` for a command that is
        /// not in the document.
        const fn section(name: &'static str) -> &'static str {
            match name.as_bytes() {
                b"none" => "",
                _ => name,
            }
        }

        /// All commands of the Magician, ordered by id.
        pub const TABLE: &[Row] = &[ $( Row {
            id: $id,
            name: $vendor,
            doc: $doc,
            chapter: origin!(chapter $origin),
            section: section(origin!(section $origin)),
            source: origin!(source $origin),
            confidence: origin!(confidence $origin),
            errata: origin!(errata $origin),
            queueable: is_word!(yes $queue),
            controls_queue: is_word!(ignored $queue),
            resendable: is_word!(yes $resend),
            dangerous: is_word!(yes $danger),
            effect: Effect::$effect,
            may_burn: is_word!(burn $($may)?),
            get_name: concat!("Get", $vendor),
            set_name: name_or_default!(concat!("Set", $vendor) $( $(, $action_name)? )?),
            query: some_if_present!( $( <$state as Readable>::Query::INFO )? $( <$param as Readable>::Query::INFO )? ),
            value: some_if_present!( $( $state::INFO )? $( $param::INFO )? ),
            set: some_if_present!( $( $param::INFO )? $( $action::INFO )? ),
        }, )+ ];

        /// A get request; each variant carries the parameters of its query.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(not(magician_workspace), non_exhaustive)]
        pub enum Get {
            $( $( #[doc = concat!("Reads [`", stringify!($state), "`].")]
                  $state(<$state as Readable>::Query), )?
               $( #[doc = concat!("Reads [`", stringify!($param), "`].")]
                  $param(<$param as Readable>::Query), )? )+
        }

        impl Get {
            /// Decodes the get request of an id.
            ///
            /// # Errors
            /// [`DecodeError::NoSuchForm`] if the id has no get, and the errors of the layout.
            pub fn decode(id: u8, params: &[u8]) -> Result<Self, DecodeError> {
                match id {
                    $( $( $id => Layout::decode(params).map(Self::$state), )?
                       $( $id => Layout::decode(params).map(Self::$param), )? )+
                    _ => Err(DecodeError::NoSuchForm(id)),
                }
            }

            /// Row of the command.
            #[must_use]
            pub fn row(&self) -> &'static Row {
                match self {
                    $( $( Self::$state(_) => <$state as Readable>::ROW, )?
                       $( Self::$param(_) => <$param as Readable>::ROW, )? )+
                }
            }

            /// Encodes the parameters.
            pub fn encode(&self, writer: &mut Writer<'_>) {
                match self {
                    $( $( Self::$state(query) => query.encode(writer), )?
                       $( Self::$param(query) => query.encode(writer), )? )+
                }
            }
        }

        /// A set or an action: the content of a set request, and of an element of the controller's
        /// queue.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(not(magician_workspace), non_exhaustive)]
        pub enum Set {
            $( $( #[doc = concat!("Sets [`", stringify!($param), "`].")] $param($param), )?
               $( #[doc = concat!("Performs [`", stringify!($action), "`].")] $action($action), )? )+
        }

        impl Set {
            /// Decodes the set request of an id.
            ///
            /// # Errors
            /// [`DecodeError::NoSuchForm`] if the id has no set, and the errors of the layout.
            pub fn decode(id: u8, params: &[u8]) -> Result<Self, DecodeError> {
                match id {
                    $( $( $id => $param::decode(params).map(Self::$param), )?
                       $( $id => $action::decode(params).map(Self::$action), )? )+
                    _ => Err(DecodeError::NoSuchForm(id)),
                }
            }

            /// Row of the command.
            #[must_use]
            pub fn row(&self) -> &'static Row {
                match self {
                    $( $( Self::$param(_) => <$param as Writable>::ROW, )?
                       $( Self::$action(_) => <$action as Writable>::ROW, )? )+
                }
            }

            /// Encodes the parameters.
            pub fn encode(&self, writer: &mut Writer<'_>) {
                match self {
                    $( $( Self::$param(value) => value.encode(writer), )?
                       $( Self::$action(value) => value.encode(writer), )? )+
                }
            }

            /// Checks all fields against their ranges; see [`Layout::check`].
            ///
            /// # Errors
            /// [`RangeError`] for the first field out of range.
            #[inline]
            pub fn check(&self) -> Result<(), RangeError> {
                self.check_fields(|_| true)
            }

            /// Checks the fields selected by `wanted`.
            ///
            /// # Errors
            /// Same as [`check`](Self::check).
            #[inline]
            pub fn check_fields(&self, wanted: impl Fn(&Field) -> bool) -> Result<(), RangeError> {
                match self {
                    $( $( Self::$param(value) => value.check_fields(wanted), )?
                       $( Self::$action(value) => value.check_fields(wanted), )? )+
                }
            }
        }

        $( $( impl From<$param> for Set { fn from(value: $param) -> Self { Self::$param(value) } } )?
           $( impl From<$action> for Set { fn from(value: $action) -> Self { Self::$action(value) } } )? )+

        for_each! { ($) [ $( $( $state )? $( $param )? )+ ] [ $( $( $param )? $( $action )? )+ ] }
    };
}

/// The alternative that is present, as an `Option`. Two at once do not compile.
macro_rules! some_if_present {
    () => { None };
    ($($any:tt)+) => { Some($($any)+) };
}

/// Exports two macros for crates that must handle every command.
///
/// `for_each_readable!(callback)` and `for_each_writable!(callback)` call `callback!` with the
/// names of all layouts of that kind, so that a match over [`Get`](crate::Get) or
/// [`Set`](crate::Set) cannot miss one.
macro_rules! for_each {
    (($d:tt) [ $($readable:ident)+ ] [ $($writable:ident)+ ]) => {
        /// Calls a macro with the names of all values that have a get.
        #[macro_export]
        macro_rules! for_each_readable {
            ($d callback:ident) => { $d callback! { $($readable)+ } };
        }

        /// Calls a macro with the names of all layouts that have a set.
        #[macro_export]
        macro_rules! for_each_writable {
            ($d callback:ident) => { $d callback! { $($writable)+ } };
        }
    };
}
