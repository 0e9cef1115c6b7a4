//! What an object is made of when it comes.

use crate::config::{Config, Margin, with};
use crate::error::Error;
use crate::filter::{CLASSES, Filter};
use crate::geometry::aabb::Aabb;
use crate::geometry::key::KeyBox;

/// A new object: its box, and what else it has from the beginning. A box alone is one, too.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, Filter, InlineWorld, Object, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_filters().with_values();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// let cube = Aabb::new([0.0; 3], [1.0; 3]);
/// world.insert(cube)?;
/// let id = world.insert(Object::new(cube).with_filter(Filter::class(1)).with_value(4711))?;
/// assert_eq!((world.value(id), world.step()?.pairs()), (Some(4711), &[[0, 1]][..]));
/// # Ok::<(), Error>(())
/// ```
#[doc(alias("ColliderBuilder", "BodyCreationSettings", "ProxyDef"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Object {
    /// Its box.
    pub aabb: Aabb,
    /// Whom it meets; else everybody.
    pub filter: Option<Filter>,
    /// Its value; else 0.
    pub value: Option<u64>,
    /// How far it may move before it counts as moved; else the world's margin.
    pub margin: Option<f32>,
}

impl Object {
    /// An object with nothing but a box.
    #[must_use]
    pub const fn new(aabb: Aabb) -> Self {
        Self { aabb, filter: None, value: None, margin: None }
    }

    with! {
        with_filter(filter: Filter), filter = Some(filter);
        with_value(value: u64), value = Some(value);
        with_margin(length: f32), margin = Some(length);
    }

    /// Whether a world of this configuration takes it.
    ///
    /// # Errors
    /// [`Error::BadBox`], [`Error::NoFilters`], [`Error::BadClass`], [`Error::NoValues`],
    /// [`Error::NoMargins`], [`Error::BadMargin`].
    pub fn check(&self, config: &Config) -> Result<(), Error> {
        self.bounds(config).map(drop)
    }

    /// Its box, if a world of this configuration takes all that it has.
    pub(crate) fn bounds(&self, config: &Config) -> Result<KeyBox, Error> {
        match self.filter {
            Some(_) if !config.filters => return Err(Error::NoFilters),
            Some(Filter { class, .. }) if class as usize >= CLASSES => return Err(Error::BadClass { class }),
            _ => {}
        }
        if self.value.is_some() && !config.values {
            return Err(Error::NoValues);
        }
        if let Some(length) = self.margin {
            Margin::length(length).check()?;
            config.margin.ok_or(Error::NoMargins)?;
        }
        KeyBox::from_aabb(&self.aabb).ok_or(Error::BadBox { index: 0 })
    }
}

impl From<Aabb> for Object {
    fn from(aabb: Aabb) -> Self {
        Self::new(aabb)
    }
}
