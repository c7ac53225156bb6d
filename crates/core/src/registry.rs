//! A registry: the built-in entries of one kind, and those that other crates register.

use std::ops::Deref;
use std::slice::Iter;
use std::sync::{PoisonError, RwLock};

/// An entry of a [`Registry`].
pub trait RegistryEntry: Sync {
    /// The kind of thing that is registered, for messages: `effect`, `cleaner`.
    const KIND: &'static str;

    /// The name in configurations, unique in its registry.
    fn name(&self) -> &'static str;
}

/// Implements [`RegistryEntry`] for a type whose field `name` is the name, of a kind.
#[macro_export]
macro_rules! registry_entry {
    ($Entry:ty, $kind:literal) => {
        impl $crate::RegistryEntry for $Entry {
            const KIND: &'static str = $kind;

            fn name(&self) -> &'static str {
                self.name
            }
        }
    };
}

/// The entries of one kind, by unique names: the built-in ones in their order, then the registered
/// ones in the order in which they were registered.
///
/// It is a static that dereferences to the slice of its entries. A program registers its own at the
/// beginning of `main`, before configurations are read; entries are never removed, and those that
/// are there keep their positions.
///
/// ```
/// use evpose_core::{Registry, RegistryEntry};
///
/// struct Colour(&'static str);
///
/// impl RegistryEntry for Colour {
///     const KIND: &'static str = "colour";
///
///     fn name(&self) -> &'static str {
///         self.0
///     }
/// }
///
/// static COLOURS: Registry<Colour> = Registry::new(&[&Colour("red"), &Colour("green")]);
///
/// COLOURS.register(&[&Colour("blue")])?;
/// let names: Vec<_> = COLOURS.iter().map(|colour| colour.name()).collect();
/// assert_eq!(names, ["red", "green", "blue"]);
///
/// let error = COLOURS.register(&[&Colour("red")]).unwrap_err();
/// assert_eq!(error.to_string(), "a colour `red` is registered already");
/// # Ok::<(), evpose_core::RegistryError>(())
/// ```
#[derive(Debug)]
pub struct Registry<T: ?Sized + 'static> {
    entries: RwLock<&'static [&'static T]>,
}

/// An entry that a registry cannot take.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegistryError {
    /// Another entry has the name.
    #[error("a {kind} `{name}` is registered already")]
    Duplicate {
        /// The kind of the registry.
        kind: &'static str,
        /// The name of both.
        name: &'static str,
    },
    /// Configurations cannot spell the name.
    #[error("{kind} `{name}`: a name has letters, digits, `-` and `_` only")]
    Name {
        /// The kind of the registry.
        kind: &'static str,
        /// Name that the entry states.
        name: &'static str,
    },
}

impl<T: RegistryEntry + ?Sized> Registry<T> {
    /// A registry of built-in entries, whose names tests check.
    pub const fn new(built_in: &'static [&'static T]) -> Self {
        Self { entries: RwLock::new(built_in) }
    }

    /// All entries at this time.
    pub fn entries(&self) -> &'static [&'static T] {
        // The slice is replaced as a whole, so a panic elsewhere leaves nothing half-done.
        *self.entries.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The entry of the name `name`.
    pub fn find(&self, name: &str) -> Option<&'static T> {
        self.entries().iter().find(|entry| entry.name() == name).copied()
    }

    /// All names, in the order of the entries.
    pub fn names(&self) -> Vec<&'static str> {
        self.entries().iter().map(|entry| entry.name()).collect()
    }

    /// Appends entries, all or none.
    ///
    /// # Errors
    /// A name that another entry has, of the registry or of `own`; a name that configurations
    /// cannot spell.
    pub fn register(&self, own: &[&'static T]) -> Result<(), RegistryError> {
        let mut entries = self.entries.write().unwrap_or_else(PoisonError::into_inner);
        let mut all = entries.to_vec();
        for &entry in own {
            let (kind, name) = (T::KIND, entry.name());
            if name.is_empty() || !name.chars().all(is_of_names) {
                return Err(RegistryError::Name { kind, name });
            }
            // This covers duplicates within `own` too, for `all` grows with every entry.
            if all.iter().any(|other| other.name() == name) {
                return Err(RegistryError::Duplicate { kind, name });
            }
            all.push(entry);
        }
        // Entries are as static as the built-in ones; a program registers a few times.
        *entries = Vec::leak(all);
        Ok(())
    }
}

fn is_of_names(character: char) -> bool {
    character.is_ascii_alphanumeric() || "-_".contains(character)
}

impl<T: RegistryEntry + ?Sized> Deref for Registry<T> {
    type Target = [&'static T];

    fn deref(&self) -> &Self::Target {
        self.entries()
    }
}

impl<T: RegistryEntry + ?Sized> IntoIterator for &Registry<T> {
    type Item = &'static &'static T;
    type IntoIter = Iter<'static, &'static T>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries().iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Fruit(&'static str);

    impl RegistryEntry for Fruit {
        const KIND: &'static str = "fruit";

        fn name(&self) -> &'static str {
            self.0
        }
    }

    #[test]
    fn registered_entries_follow_the_built_in_ones_in_their_order() {
        static FRUITS: Registry<Fruit> = Registry::new(&[&Fruit("quince"), &Fruit("apple")]);
        let before = FRUITS.entries();
        assert_eq!(FRUITS.register(&[&Fruit("pear"), &Fruit("fig")]), Ok(()));
        assert_eq!(FRUITS.register(&[&Fruit("date")]), Ok(()));
        assert_eq!(FRUITS.names(), ["quince", "apple", "pear", "fig", "date"]);
        assert_eq!(FRUITS.find("fig").map(Fruit::name), Some("fig"));
        assert_eq!(before.len(), 2, "a slice from before is still what it was");
        assert_eq!((&FRUITS).into_iter().count(), FRUITS.len());
    }

    #[test]
    fn a_name_that_is_taken_or_cannot_be_spelt_registers_nothing() {
        static FRUITS: Registry<Fruit> = Registry::new(&[&Fruit("quince")]);
        let duplicate = |name| Err(RegistryError::Duplicate { kind: "fruit", name });
        assert_eq!(FRUITS.register(&[&Fruit("pear"), &Fruit("quince")]), duplicate("quince"));
        assert_eq!(FRUITS.register(&[&Fruit("pear"), &Fruit("pear")]), duplicate("pear"));
        static MISNAMED: [Fruit; 3] = [Fruit(""), Fruit("a pear"), Fruit("pear:ripe")];
        for fruit in &MISNAMED {
            let error = RegistryError::Name { kind: "fruit", name: fruit.0 };
            assert_eq!(FRUITS.register(&[fruit]), Err(error));
        }
        assert_eq!(FRUITS.names(), ["quince"]);
    }
}
