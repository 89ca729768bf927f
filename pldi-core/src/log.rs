//! What the stages say while they run: through defmt with the feature `defmt`, nothing without it.

/// Logs at a level of defmt: `event!(debug, "text {}", value)`. Without the feature the values are checked for their
/// types, but not computed.
macro_rules! event {
    ($level:ident, $text:literal $(, $value:expr)* $(,)?) => {{
        #[cfg(feature = "defmt")]
        defmt::$level!($text $(, $value)*);
        #[cfg(not(feature = "defmt"))]
        if false {
            let _ = ($(&$value,)*);
        }
    }};
}

/// What can be logged: with the feature `defmt` what has its `Format`, else everything.
#[cfg(feature = "defmt")]
pub trait Loggable: defmt::Format {}
#[cfg(feature = "defmt")]
impl<T: defmt::Format> Loggable for T {}

/// What can be logged: with the feature `defmt` what has its `Format`, else everything.
#[cfg(not(feature = "defmt"))]
pub trait Loggable {}
#[cfg(not(feature = "defmt"))]
impl<T> Loggable for T {}
