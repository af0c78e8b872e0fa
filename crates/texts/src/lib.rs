//! Sentences with their codes and values, so that each can be said in another language too.
//!
//! A sentence is written once, in English, as the function that makes it. Its code is the name of its group and of the
//! function, its values have the names of the arguments:
//!
//! ```
//! mod evidence {
//!     encoring_texts::texts! {
//!         "evidence";
//!         fn stays(bit: u32, rows: usize) = "bit {bit} is the same in {rows} rows";
//!     }
//! }
//!
//! let said = evidence::stays(7, 120);
//! assert_eq!(said.to_string(), "bit 7 is the same in 120 rows");
//! assert_eq!(said.code(), "evidence.stays");
//! assert_eq!(serde_json::to_string(&said).unwrap(), r#"{"code":"evidence.stays","values":{"bit":7,"rows":120}}"#);
//! assert_eq!(evidence::TEXTS[0].values, ["bit", "rows"]);
//! ```

mod number;
mod own;
mod said;

pub use number::{Decimal, Hex};
pub use own::{OWN, own};
pub use said::{Said, SaidTemplate, SaidValue};

/// Makes functions of sentences, each of which gives a [`Said`], and `TEXTS`, a list of [`SaidTemplate`] with all of them.
///
/// The group comes first. A value is anything that becomes a [`SaidValue`] and can be displayed.
#[macro_export]
macro_rules! texts {
    ($group:literal; $($(#[$about:meta])* fn $name:ident($($value:ident: $type:ty),* $(,)?) = $english:literal;)+) => {
        /// All sentences of this group.
        pub(crate) const TEXTS: &[$crate::SaidTemplate] = &[$($crate::SaidTemplate {
            code: concat!($group, ".", stringify!($name)),
            english: $english,
            values: &[$(stringify!($value)),*],
        }),+];

        $($(#[$about])*
        pub(crate) fn $name($($value: $type),*) -> $crate::Said {
            let text = format!($english);
            let code = concat!($group, ".", stringify!($name));
            $crate::Said::new(code, text, vec![$((stringify!($value), $value.into())),*])
        })+
    };
}

/// The same for what another library says in its own words: each function takes that text first.
#[macro_export]
macro_rules! retold {
    ($group:literal; $($(#[$about:meta])* fn $name:ident($($value:ident: $type:ty),* $(,)?);)+) => {
        /// All sentences of this group.
        pub(crate) const RETOLD: &[$crate::SaidTemplate] = &[$($crate::SaidTemplate {
            code: concat!($group, ".", stringify!($name)),
            english: "",
            values: &[$(stringify!($value)),*],
        }),+];

        $($(#[$about])*
        pub(crate) fn $name(text: &(impl ToString + ?Sized), $($value: $type),*) -> $crate::Said {
            let code = concat!($group, ".", stringify!($name));
            $crate::Said::retold(code, text.to_string(), vec![$((stringify!($value), $value.into())),*])
        })+
    };
}
