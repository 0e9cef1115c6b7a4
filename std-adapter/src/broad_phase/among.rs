//! Queries by key, about all boxes or about some of them.

use super::BroadPhase;
use core::hash::Hash;
use core::ops::ControlFlow;
use trisap_core::{Cast, Error, Executor, Hit, Id, Region, Serial, Volume};

/// Queries between two steps, about the boxes as they are now.
impl<K: Copy + Eq + Hash> BroadPhase<K> {
    /// The keys whose boxes overlap a region.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    #[doc(alias("query_aabb", "intersections_with_aabb"))]
    pub fn overlaps(&self, region: &Region) -> Result<Vec<K>, Error> {
        let mut keys = Vec::new();
        self.as_world().visit_overlaps(region, &mut |id| {
            keys.extend(self.key(id));
            ControlFlow::Continue(())
        })?;
        Ok(keys)
    }

    /// The first box that a ray or a moving box meets, and the distance.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    #[doc(alias("raycast", "ray_cast", "cast_ray"))]
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<(K, f64)>, Error> {
        Ok(self.as_world().first_hit(cast)?.and_then(|hit| self.named(hit)))
    }

    /// All boxes that a ray or a moving box meets, and the distances, the nearest first, equally near ones by slot.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn hits(&self, cast: &Cast) -> Result<Vec<(K, f64)>, Error> {
        self.among(|_| true).hits(cast)
    }

    /// [`first_hit`](Self::first_hit) of each cast, on the workers that steps have.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn first_hits(&self, casts: &[Cast]) -> Result<Vec<Option<(K, f64)>>, Error> {
        let mut hits = vec![None; casts.len()];
        self.as_world().among(|_| true).first_hits(casts, self.executor(), &mut hits)?;
        Ok(hits.into_iter().map(|hit| self.named(hit?)).collect())
    }

    /// [`overlaps`](Self::overlaps) of each region, on the workers that steps have.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn overlaps_many(&self, regions: &[Region]) -> Result<Vec<Vec<K>>, Error> {
        let mut ends = vec![0; regions.len()];
        let mut ids = vec![None; 16 * regions.len()];
        while let Err(error) =
            self.as_world().among(|_| true).overlaps_many(regions, self.executor(), &mut ids, &mut ends)
        {
            let Error::OutputFull { needed, .. } = error else { return Err(error) };
            ids.resize(needed as usize, None);
        }
        let mut ids = ids.iter();
        let mut start = 0;
        let of = |end: &usize| {
            let count = *end - core::mem::replace(&mut start, *end);
            ids.by_ref().take(count).filter_map(|id| self.key((*id)?)).collect()
        };
        Ok(ends.iter().map(of).collect())
    }

    /// Visits the keys whose boxes overlap a region, each once, until the visitor ends it.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn visit_overlaps(
        &self,
        region: &Region,
        visit: &mut dyn FnMut(K) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let mut visit = |id| self.key(id).map_or(ControlFlow::Continue(()), &mut *visit);
        self.as_world().visit_overlaps(region, &mut visit)
    }

    /// Visits the keys that a cast meets; the visitor gets the distance, and says how far to look on: see [`trisap_core::World::visit_hits`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn visit_hits(&self, cast: &Cast, visit: &mut dyn FnMut(K, f64) -> f64) -> Result<(), Error> {
        let mut visit = |hit| self.named(hit).map_or(f64::INFINITY, |(key, far)| visit(key, far));
        self.as_world().visit_hits(cast, &mut visit)
    }

    /// Visits the keys within a distance of a point; the visitor says how far to look on: see [`trisap_core::World::visit_nearest`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn visit_nearest(
        &self,
        point: [f32; 3],
        distance: f64,
        visit: &mut dyn FnMut(K, f64) -> f64,
    ) -> Result<(), Error> {
        let mut visit = |hit| self.named(hit).map_or(f64::INFINITY, |(key, far)| visit(key, far));
        self.as_world().visit_nearest(point, distance, &mut visit)
    }

    /// The boxes nearest to a point, as many as wanted or as there are, by ascending distance.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    #[doc(alias("closest", "knn", "project_point"))]
    pub fn nearest(&self, point: [f32; 3], count: usize) -> Result<Vec<(K, f64)>, Error> {
        let mut hits = vec![None; count.min(self.len())];
        self.as_world().nearest(point, &mut hits)?;
        Ok(hits.into_iter().flatten().filter_map(|hit| self.named(hit)).collect())
    }

    /// [`nearest`](Self::nearest) to each point, on the workers that steps have.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn nearest_many(&self, points: &[[f32; 3]], count: usize) -> Result<Vec<Vec<(K, f64)>>, Error> {
        let count = count.min(self.len());
        let mut hits = vec![None; count * points.len()];
        self.as_world().among(|_| true).nearest_many(points, self.executor(), &mut hits)?;
        let of =
            |at: usize| hits[at * count..][..count].iter().filter_map(|hit| self.named((*hit)?)).collect();
        Ok((0..points.len()).map(of).collect())
    }

    /// The keys whose boxes are inside a part of space of the caller's own, or across its border: see
    /// [`trisap_core::World::visit_within`].
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase, Planes};
    ///
    /// let mut broad_phase = BroadPhase::new();
    /// broad_phase.insert("near", Aabb::from_center([1.0, 0.0, 0.0], [0.5; 3]))?;
    /// broad_phase.insert("far", Aabb::from_center([9.0, 0.0, 0.0], [0.5; 3]))?;
    /// // x <= 5, as one side of a frustum would be.
    /// assert_eq!(broad_phase.within(&Planes(&[[1.0, 0.0, 0.0, 5.0]])), ["near"]);
    /// # Ok::<(), trisap::Error>(())
    /// ```
    #[doc(alias("frustum", "cull"))]
    #[must_use]
    pub fn within(&self, volume: &dyn Volume) -> Vec<K> {
        let mut keys = Vec::new();
        self.as_world().visit_within(volume, &mut |id| {
            keys.extend(self.key(id));
            ControlFlow::Continue(())
        });
        keys
    }

    /// Asks queries as if there were only the boxes for whose keys a condition holds: without one's own, by filters, by
    /// what they are. The condition is asked in any order, only about boxes that the query has found. It has to answer
    /// the same for the same key.
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase, Cast, Config, Filter};
    ///
    /// const WALLS: u32 = 1;
    /// const BALLS: u32 = 2;
    /// let mut broad_phase = BroadPhase::with_config(&Config::default().with_filters())?;
    /// for (key, x, group) in [("ball", 0.0, BALLS), ("other ball", 2.0, BALLS), ("wall", 5.0, WALLS)] {
    ///     broad_phase.insert(key, Aabb::from_center([x, 0.0, 0.0], [0.5; 3]))?;
    ///     broad_phase.set_filter(&key, Filter::groups(group, u32::MAX))?;
    /// }
    /// let nearest = broad_phase.among(|key| key != "ball").nearest([0.0; 3], 1)?;
    /// assert_eq!(nearest, [("other ball", 1.5)]);
    ///
    /// let sees = Filter::groups(u32::MAX, WALLS);
    /// let ray = Cast::ray([0.0; 3], [1.0, 0.0, 0.0], 100.0);
    /// let hit = broad_phase.among(|key| broad_phase.meets(&key, &sees)).first_hit(&ray)?;
    /// assert_eq!(hit, Some(("wall", 4.5)));
    /// # Ok::<(), trisap::Error>(())
    /// ```
    pub fn among<C: Fn(K) -> bool>(&self, condition: C) -> AmongKeys<'_, K, C> {
        AmongKeys { broad_phase: self, condition }
    }

    fn executor(&self) -> &dyn Executor {
        #[cfg(feature = "rayon")]
        if self.config.workers > 1 {
            return &self.executor;
        }
        &Serial
    }

    fn named(&self, hit: Hit) -> Option<(K, f64)> {
        Some((self.key(hit.id)?, hit.distance))
    }
}

/// Queries that only boxes with a condition can answer: made by [`BroadPhase::among`].
#[must_use = "does nothing until a query is asked"]
pub struct AmongKeys<'b, K, C> {
    broad_phase: &'b BroadPhase<K>,
    condition: C,
}

impl<K: Copy + Eq + Hash, C: Fn(K) -> bool> AmongKeys<'_, K, C> {
    /// See [`BroadPhase::overlaps`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn overlaps(&self, region: &Region) -> Result<Vec<K>, Error> {
        let mut keys = self.broad_phase.overlaps(region)?;
        keys.retain(|key| (self.condition)(*key));
        Ok(keys)
    }

    /// See [`BroadPhase::first_hit`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<(K, f64)>, Error> {
        let hit = self.broad_phase.as_world().among(self.by_id()).first_hit(cast)?;
        Ok(hit.and_then(|hit| self.broad_phase.named(hit)))
    }

    /// See [`BroadPhase::hits`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn hits(&self, cast: &Cast) -> Result<Vec<(K, f64)>, Error> {
        let mut hits = Vec::new();
        self.broad_phase.as_world().visit_hits(cast, &mut |hit| {
            if self.by_id()(hit.id) {
                hits.push(hit);
            }
            f64::INFINITY
        })?;
        hits.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.id.slot().cmp(&b.id.slot())));
        Ok(hits.into_iter().filter_map(|hit| self.broad_phase.named(hit)).collect())
    }

    /// See [`BroadPhase::nearest`].
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn nearest(&self, point: [f32; 3], count: usize) -> Result<Vec<(K, f64)>, Error> {
        let mut hits = vec![None; count.min(self.broad_phase.len())];
        self.broad_phase.as_world().among(self.by_id()).nearest(point, &mut hits)?;
        Ok(hits.into_iter().flatten().filter_map(|hit| self.broad_phase.named(hit)).collect())
    }

    fn by_id(&self) -> impl Fn(Id) -> bool {
        |id| self.broad_phase.key(id).is_some_and(&self.condition)
    }
}

impl<K, C> core::fmt::Debug for AmongKeys<'_, K, C> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("AmongKeys").field("broad_phase", self.broad_phase).finish_non_exhaustive()
    }
}
