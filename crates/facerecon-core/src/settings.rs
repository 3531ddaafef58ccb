//! Parameters declared once: a struct declared with `settings!` carries its defaults,
//! ranges, units and documentation; the TOML file, the command line and Python are derived from it.

mod keys;
mod nearest;
mod text;
mod types;
mod value;

pub use keys::{from_sets, from_table, resolve_keys, set};
pub(crate) use nearest::nearest_name;
pub use text::{commented_toml, fields};
pub use types::{Field, Kind, SettingsError, UnknownChoice};
pub use value::Value;

/// Declares a parameter struct: `name: type = default, range low..=high, unit "px", alias "old";`
/// with doc comments. An alias is an earlier name of the field, which is still read. The macro
/// derives serde (missing fields take their default, unknown ones are refused), `Default`, and the
/// documentation and range checks of [`Value`](crate::settings::Value).
///
/// ```ignore
/// settings! {
///     /// Smoothing of a signal.
///     pub struct SmoothingParams {
///         /// Standard deviation of the kernel.
///         sigma_px: f64 = 1.5, range 0.0..=20.0, unit "px", alias "width_px";
///     }
/// }
/// ```
macro_rules! settings {
    (
        $(#[doc = $doc:literal])*
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $fdoc:literal])*
                $field:ident : $ty:ty = $default:expr
                $(, range $range:expr)? $(, unit $unit:literal)? $(, alias $alias:literal)? ;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        $vis struct $name {
            $(
                $(#[doc = $fdoc])*
                $(#[serde(alias = $alias)])?
                pub $field: $ty,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $crate::settings::Value for $name {
            fn kind() -> $crate::settings::Kind {
                $crate::settings::Kind::Group(vec![$(
                    $crate::settings::Field {
                        name: stringify!($field),
                        alias: $crate::settings::settings!(@text $($alias)?),
                        doc: [$($fdoc),*].map(str::trim).join("\n"),
                        unit: $crate::settings::settings!(@text $($unit)?),
                        range: $crate::settings::settings!(@range $($range)?),
                        kind: <$ty as $crate::settings::Value>::kind(),
                    },
                )*])
            }
            fn check(
                &self,
                name: &str,
                _: Option<&std::ops::RangeInclusive<f64>>,
            ) -> Result<(), $crate::settings::SettingsError> {
                let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
                $(
                    let range: Option<std::ops::RangeInclusive<f64>> = $crate::settings::settings!(@range $($range)?);
                    $crate::settings::Value::check(
                        &self.$field, &format!("{prefix}{}", stringify!($field)), range.as_ref())?;
                )*
                Ok(())
            }
        }
    };
    (@text) => { None };
    (@text $text:literal) => { Some($text) };
    (@range) => { None };
    (@range $range:expr) => { Some($range) };
}

/// Declares an enum of named choices for a `settings!` field: `Variant = "name",` with doc
/// comments that say what the choice means. The names are those of serde, `Display` and `from_name`.
macro_rules! choices {
    (
        $(#[doc = $doc:literal])*
        $vis:vis enum $name:ident {
            $( $(#[doc = $vdoc:literal])* $variant:ident = $text:literal, )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize)]
        $vis enum $name {
            $( $(#[doc = $vdoc])* #[serde(rename = $text)] $variant, )*
        }

        impl $crate::settings::Value for $name {
            fn kind() -> $crate::settings::Kind {
                $crate::settings::Kind::Choice(vec![
                    $( ($text, [$($vdoc),*].map(str::trim).join(" ")), )*
                ])
            }
            fn check(
                &self,
                _: &str,
                _: Option<&std::ops::RangeInclusive<f64>>,
            ) -> Result<(), $crate::settings::SettingsError> {
                Ok(())
            }
        }

        impl $name {
            /// Every choice with its name.
            pub const NAMED: &'static [(&'static str, Self)] = &[$( ($text, Self::$variant), )*];

            /// The choice with this name.
            ///
            /// # Errors
            /// `UnknownChoice` with the known names.
            pub fn from_name(name: &str) -> Result<Self, $crate::settings::UnknownChoice> {
                Self::named(name).ok_or_else(|| $crate::settings::UnknownChoice {
                    got: name.to_owned(),
                    expected: [$($text),*].join(", "),
                })
            }

            /// The choice with this name, if there is one.
            pub fn named(name: &str) -> Option<Self> {
                Self::NAMED.iter().find(|(n, _)| *n == name).map(|(_, v)| *v)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $( Self::$variant => $text, )* })
            }
        }
    };
}

pub(crate) use choices;
pub(crate) use settings;

#[cfg(test)]
mod tests {
    use super::*;

    choices! {
        /// A choice.
        pub enum Way {
            /// The first.
            One = "one",
            /// The second.
            Two = "two",
        }
    }
    settings! {
        /// Inner.
        pub struct Inner {
            /// A length.
            length_px: f64 = 2.0, range 0.0..=10.0, unit "px", alias "extent";
        }
    }
    settings! {
        /// Outer.
        pub struct Outer {
            /// How.
            way: Way = Way::One;
            /// Maybe.
            maybe: Option<usize> = None, alias "perhaps";
            /// The inner group.
            inner: Inner = Inner::default(), alias "within";
        }
    }

    #[test]
    fn printed_toml_reads_back_and_carries_the_documentation() {
        let text = commented_toml(&Outer::default()).unwrap();
        assert!(text.contains("# A length. [px, 0 to 10]"), "{text}");
        assert!(text.contains("\"two\": The second."), "{text}");
        assert_eq!(toml::from_str::<Outer>(&text).unwrap(), Outer::default());
    }

    #[test]
    fn ranges_unknown_names_and_choices_are_refused() {
        let mut table = toml::Table::new();
        set::<Outer>(&mut table, "inner.length_px", "11").unwrap();
        set::<Outer>(&mut table, "way", "two").unwrap();
        let outer: Outer = table.clone().try_into().unwrap();
        assert_eq!(outer.way, Way::Two);
        assert_eq!((Way::named("two"), Way::named("three")), (Some(Way::Two), None));
        assert_eq!(Way::NAMED[0].0, "one");
        for error in [outer.check("", None).unwrap_err(), from_table::<Outer>(table).unwrap_err()] {
            assert!(error.to_string().contains("inner.length_px is 11"), "{error}");
        }
        let error = set::<Outer>(&mut toml::Table::new(), "inner.size", "1").unwrap_err();
        assert!(error.to_string().contains("length_px"), "{error}");
        assert!(toml::from_str::<Outer>("surprise = 1").is_err());
        assert!(toml::from_str::<Outer>("way = \"three\"").is_err());
    }

    #[test]
    fn choices_are_parsed_from_their_names() {
        assert_eq!(Way::from_name("one"), Ok(Way::One));
        let error = Way::from_name("three").unwrap_err().to_string();
        assert!(error.contains("\"three\"") && error.contains("one, two"), "{error}");
    }

    #[test]
    fn earlier_names_are_read_from_files_and_settings() {
        let expected =
            Outer { maybe: Some(4), inner: Inner { length_px: 3.0 }, ..Outer::default() };
        let text = "perhaps = 4\n[within]\nextent = 3.0";
        assert_eq!(toml::from_str::<Outer>(text).unwrap(), expected);
        let table = text.parse::<toml::Table>().unwrap();
        assert_eq!(from_table::<Outer>(table.clone()).unwrap(), expected);

        let mut set_by_name = toml::Table::new();
        set::<Outer>(&mut set_by_name, "perhaps", "4").unwrap();
        set::<Outer>(&mut set_by_name, "within.extent", "3.0").unwrap();
        assert_eq!(from_table::<Outer>(set_by_name).unwrap(), expected);

        // A setting by the current name replaces a value that the file gives by the earlier one.
        let mut both = table;
        set::<Outer>(&mut both, "maybe", "5").unwrap();
        set::<Outer>(&mut both, "inner.length_px", "6").unwrap();
        let read: Outer = from_table(both).unwrap();
        assert_eq!((read.maybe, read.inner.length_px), (Some(5), 6.0));
        let twice = "perhaps = 4\nmaybe = 5".parse::<toml::Table>().unwrap();
        let error = from_table::<Outer>(twice).unwrap_err().to_string();
        assert!(error.contains("perhaps") && error.contains("maybe"), "{error}");
    }

    #[test]
    fn unknown_keys_of_a_file_are_named_with_the_nearest() {
        let read = |text: &str| from_table::<Outer>(text.parse().unwrap()).unwrap_err().to_string();
        assert!(
            read("[inner]\nlenght_px = 3")
                .contains("unknown key inner.lenght_px; did you mean inner.length_px?")
        );
        assert!(read("mabye = 3").contains("did you mean maybe?"));
        assert!(read("nothing_like_it = 3").contains("way, maybe, inner"));
        assert!(read("inner = 3").contains("inner is 3"));
        assert!(read("maybe = true").contains("maybe is true, but must be a whole number"));
        let mut table = toml::Table::new();
        let error = set::<Outer>(&mut table, "iner.length_px", "3").unwrap_err().to_string();
        assert!(error.contains("did you mean inner.length_px?"), "{error}");
        assert!(set::<Outer>(&mut table, "inner", "3").unwrap_err().to_string().contains("group"));
        assert!(set::<Outer>(&mut table, "way.one", "3").unwrap_err().to_string().contains("way"));
    }
}
