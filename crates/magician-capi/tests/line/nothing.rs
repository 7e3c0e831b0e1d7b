// Every function about a connected arm, called with nothing but nulls and zeros; the file is included where `ids!` says
// how a family is called. The calls come from the table itself, so that none is forgotten.

/// Nothing, of a type that functions take.
trait Nothing {
    /// Whether nothing is a fault where it belongs to something.
    const IS_FAULT: bool = false;

    fn nothing() -> Self;
}

impl Nothing for u8 {
    fn nothing() -> Self {
        0
    }
}

impl Nothing for u32 {
    fn nothing() -> Self {
        0
    }
}

impl Nothing for i32 {
    fn nothing() -> Self {
        0
    }
}

impl Nothing for f32 {
    fn nothing() -> Self {
        0.0
    }
}

impl<T: Plain> Nothing for In<T> {
    const IS_FAULT: bool = true;

    fn nothing() -> Self {
        // SAFETY: null is allowed.
        unsafe { Self::new(std::ptr::null()) }
    }
}

impl<T: Plain> Nothing for Out<T> {
    const IS_FAULT: bool = true;

    fn nothing() -> Self {
        // SAFETY: as above.
        unsafe { Self::new(std::ptr::null_mut()) }
    }
}

impl Nothing for Text {
    const IS_FAULT: bool = true;

    fn nothing() -> Self {
        // SAFETY: as above.
        unsafe { Self::new(std::ptr::null()) }
    }
}

impl Nothing for Buffer {
    const IS_FAULT: bool = true;

    fn nothing() -> Self {
        // SAFETY: as above.
        unsafe { Self::new(std::ptr::null_mut()) }
    }
}

/// What is called, and what it came to.
struct Nought {
    name: &'static str,
    kind: Kind,
    /// A pointer other than that to the index of a queued command, which may always be null.
    needs: bool,
    call: fn() -> c_int,
}

/// A list of the rows that a family has and that are about an arm.
#[macro_export]
macro_rules! nought_rows {
    ($family:ident $(
        $(#[doc = $doc:literal])+
        $kind:ident $ids:ident $name:ident ( $($arg:ident : $type:ty),* $(,)? ) in [$($in:ident)*] = $body:expr;
    )*) => {{
        let mut rows: Vec<Nought> = Vec::new();
        $( $crate::nought_row!($family [$($in)*] rows $kind $ids $name ($($arg: $type),*)); )*
        rows
    }};
}

#[macro_export]
macro_rules! nought_row {
    // These end the connection, or are about none.
    ($family:ident $in:tt $rows:ident $kind:ident None $name:ident $args:tt) => {};
    ($family:ident $in:tt $rows:ident Host $ids:ident $name:ident $args:tt) => {};
    (v1 [v1 $($more:ident)*] $($row:tt)*) => { $crate::nought!([] $($row)*); };
    (v2 [v2 $($more:ident)*] $($row:tt)*) => { $crate::nought!([0] $($row)*); };
    (v3 [v3 $($more:ident)*] $($row:tt)*) => { $crate::nought!([0, 0] $($row)*); };
    ($family:ident [$other:ident $($more:ident)*] $($row:tt)*) => {
        $crate::nought_row!($family [$($more)*] $($row)*);
    };
    ($family:ident [] $($row:tt)*) => {};
}

#[macro_export]
macro_rules! nought {
    ([$($id:literal),*] $rows:ident $kind:ident $ids:ident $name:ident ($($arg:ident: $type:ty),*)) => {
        let arguments: &[(&str, bool)] = &[$((stringify!($arg), <$type as Nothing>::IS_FAULT)),*];
        let queued = arguments.iter().any(|(name, _)| *name == "queued");
        $rows.push(Nought {
            name: stringify!($name),
            kind: Kind::$kind,
            needs: arguments.iter().any(|(name, fault)| *fault && !(queued && *name == "index")),
            // SAFETY: null is allowed everywhere.
            call: || unsafe { exported::$name($($id,)* $(<$type as Nothing>::nothing()),*) },
        });
    };
}

/// Nulls where something is needed are a fault and nothing is sent; what this arm does not have is fine all the same.
fn hold_to_nothing(line: &Line, rows: &[Nought]) {
    assert!(rows.len() > 120);
    for Nought { name, kind, needs, call } in rows {
        line.passed();
        let code = call();
        let passed = line.passed();
        let expected = match kind {
            // It was not allowed.
            Kind::Guarded => 3,
            Kind::Neutral => 0,
            _ if *needs => 3,
            _ => 0,
        };
        assert_eq!(code, expected, "{name}");
        let sends = *kind == Kind::Command && !needs;
        assert_eq!(!passed.is_empty(), sends, "{name} sent {passed:02X?}");
    }
}
