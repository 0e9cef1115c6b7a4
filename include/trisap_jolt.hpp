// trisap as the broad phase of Jolt, over trisap.hpp. Needs Jolt's own headers; written for Jolt 5.0, and so for later ones whose
// `JPH::BroadPhase` is the same.
//
// Jolt chooses its broad phase by two lines of Jolt/Physics/PhysicsSystem.cpp, which become these:
//
//     #include <trisap_jolt.hpp>                   // for <Jolt/Physics/Collision/BroadPhase/BroadPhaseQuadTree.h>
//     #define BROAD_PHASE trisap::JoltBroadPhase   // for BroadPhaseQuadTree
//
// One step of trisap for each step of Jolt finds the pairs of all bodies; Jolt is told those of its active bodies that its own tests
// let through, so that none is missing and none is surplus. The world grows as bodies and pairs come.

#ifndef TRISAP_JOLT_HPP
#define TRISAP_JOLT_HPP

#include <Jolt/Jolt.h>

#include <Jolt/Geometry/OrientedBox.h>
#include <Jolt/Geometry/RayAABox.h>
#include <Jolt/Physics/Body/BodyManager.h>
#include <Jolt/Physics/Body/BodyPair.h>
#include <Jolt/Physics/Collision/AABoxCast.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhase.h>
#include <Jolt/Physics/Collision/CastResult.h>
#include <Jolt/Physics/Collision/RayCast.h>

#include "trisap.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>
#include <shared_mutex>
#include <vector>

namespace trisap {

/// A broad phase for `JPH::PhysicsSystem`. Jolt knows no way to be refused: where there is no memory, or a box has NaN in it, the
/// program ends and says why.
///
/// Queries and changes may come from any threads, as with Jolt's own. No lock is held while a collector or a filter of a query is
/// called; so what a query finds is what there was when it began.
class JoltBroadPhase final : public JPH::BroadPhase {
public:
    JPH_OVERRIDE_NEW_DELETE

    void Init(JPH::BodyManager *manager, const JPH::BroadPhaseLayerInterface &layers) override {
        JPH::BroadPhase::Init(manager, layers);
        trisap::Config config = trisap::config(std::min<std::uint32_t>(manager->GetMaxBodies(), 1024));
        config.filters = 1;
        expect(world_.init(config));
        world_.set_growing(true);
        ids_.assign(manager->GetMaxBodies(), trisap::null_id);
        std::fill(std::begin(meets_), std::end(meets_), ~0u);
    }

    /// While Jolt steps, nobody adds or removes.
    void LockModifications() override { modifications_.lock(); }
    void UnlockModifications() override { modifications_.unlock(); }

    void AddBodiesFinalize(JPH::BodyID *bodies, int count, AddState) override {
        const std::shared_lock<std::shared_mutex> modifications(modifications_);
        const std::lock_guard<std::shared_mutex> lock(world_lock_);
        for (const JPH::BodyID *id = bodies; id != bodies + count; id++) {
            JPH::Body &body = body_of(*id);
            trisap::Status status = TRISAP_STATUS_OK;
            const trisap::Id ours = world_.insert(box(body.GetWorldSpaceBounds()), &status);
            expect(status);
            ids_[id->GetIndex()] = ours;
            const std::uint32_t slot = trisap::slot(ours);
            if (slot >= bodies_.size()) {
                bodies_.resize(slot + 1);
            }
            bodies_[slot].id = *id;
            bodies_[slot].bounds = body.GetWorldSpaceBounds();
            set_layers(bodies_[slot], ours, body);
            body.SetInBroadPhaseInternal(true);
        }
        is_stale_ = is_unsettled_ = true;
    }

    void RemoveBodies(JPH::BodyID *bodies, int count) override {
        const std::shared_lock<std::shared_mutex> modifications(modifications_);
        const std::lock_guard<std::shared_mutex> lock(world_lock_);
        for (const JPH::BodyID *id = bodies; id != bodies + count; id++) {
            trisap::Id &ours = ids_[id->GetIndex()];
            expect(world_.remove(ours));
            bodies_[trisap::slot(ours)].id = JPH::BodyID();
            ours = trisap::null_id;
            body_of(*id).SetInBroadPhaseInternal(false);
        }
        is_stale_ = is_unsettled_ = true;
    }

    void NotifyBodiesAABBChanged(JPH::BodyID *bodies, int count, bool take_lock) override {
        std::shared_lock<std::shared_mutex> modifications(modifications_, std::defer_lock);
        if (take_lock) {
            modifications.lock();
        }
        const std::lock_guard<std::shared_mutex> lock(world_lock_);
        for (const JPH::BodyID *id = bodies; id != bodies + count; id++) {
            update(body_of(*id));
        }
        is_stale_ = is_unsettled_ = true;
    }

    void NotifyBodiesLayerChanged(JPH::BodyID *bodies, int count) override {
        const std::shared_lock<std::shared_mutex> modifications(modifications_);
        const std::lock_guard<std::shared_mutex> lock(world_lock_);
        for (const JPH::BodyID *id = bodies; id != bodies + count; id++) {
            const trisap::Id ours = ids_[id->GetIndex()];
            const JPH::Body &body = body_of(*id);
            update(body);
            set_layers(bodies_[trisap::slot(ours)], ours, body);
        }
        is_stale_ = is_unsettled_ = true;
    }

    void FindCollidingPairs(JPH::BodyID *active, int count, float distance, const JPH::ObjectVsBroadPhaseLayerFilter &broad_filter,
                            const JPH::ObjectLayerPairFilter &filter, JPH::BodyPairCollector &collector) const override {
        if (is_stale_.load(std::memory_order_acquire)) {
            find_partners(distance, filter);
        }
        // Jolt changes no body until it has all pairs.
        const JPH::BodyVector &bodies = mBodyManager->GetBodies();
        for (const JPH::BodyID *id = active; id != active + count; id++) {
            const JPH::Body &body = *bodies[id->GetIndex()];
            JPH::AABox bounds = body.GetWorldSpaceBounds();
            bounds.ExpandBy(JPH::Vec3::sReplicate(distance));
            const std::uint32_t slot = trisap::slot(ids_[id->GetIndex()]);
            const JPH::ObjectLayer layer = bodies_[slot].object_layer;
            for (std::uint32_t at = starts_[slot]; at < starts_[slot + 1]; at++) {
                const Told &told = bodies_[partners_[at]];
                const JPH::Body &partner = *bodies[told.id.GetIndex()];
                if (JPH::Body::sFindCollidingPairsCanCollide(body, partner) && bounds.Overlaps(partner.GetWorldSpaceBounds()) &&
                    broad_filter.ShouldCollide(layer, told.broad_layer) && filter.ShouldCollide(layer, told.object_layer)) {
                    collector.AddHit({*id, told.id});
                }
            }
        }
    }

    void CastRay(const JPH::RayCast &ray, JPH::RayCastBodyCollector &collector, const JPH::BroadPhaseLayerFilter &broad_filter,
                 const JPH::ObjectLayerFilter &filter) const override {
        tell_hits(ray.mOrigin, JPH::Vec3::sZero(), ray.mDirection, broad_filter, filter, collector,
                  [&] { return collector.GetEarlyOutFraction(); });
    }

    void CastAABoxNoLock(const JPH::AABoxCast &moved, JPH::CastShapeBodyCollector &collector,
                         const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        tell_hits(moved.mBox.GetCenter(), moved.mBox.GetExtent(), moved.mDirection, broad_filter, filter, collector,
                  [&] { return collector.GetPositiveEarlyOutFraction(); });
    }

    void CastAABox(const JPH::AABoxCast &moved, JPH::CastShapeBodyCollector &collector,
                   const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        CastAABoxNoLock(moved, collector, broad_filter, filter);
    }

    void CollideAABox(const JPH::AABox &box, JPH::CollideShapeBodyCollector &collector,
                      const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        tell_overlaps(box, broad_filter, filter, collector, [&](const JPH::AABox &bounds) { return bounds.Overlaps(box); });
    }

    void CollideSphere(JPH::Vec3Arg center, float radius, JPH::CollideShapeBodyCollector &collector,
                       const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        const JPH::Vec3 half = JPH::Vec3::sReplicate(radius);
        tell_overlaps(JPH::AABox(center - half, center + half), broad_filter, filter, collector,
                      [&](const JPH::AABox &bounds) { return bounds.GetSqDistanceTo(center) <= radius * radius; });
    }

    void CollidePoint(JPH::Vec3Arg point, JPH::CollideShapeBodyCollector &collector,
                      const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        tell_overlaps(JPH::AABox(point, point), broad_filter, filter, collector,
                      [&](const JPH::AABox &bounds) { return bounds.Contains(point); });
    }

    void CollideOrientedBox(const JPH::OrientedBox &oriented, JPH::CollideShapeBodyCollector &collector,
                            const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        const JPH::AABox around = JPH::AABox(-oriented.mHalfExtents, oriented.mHalfExtents).Transformed(oriented.mOrientation);
        tell_overlaps(around, broad_filter, filter, collector, [&](const JPH::AABox &bounds) { return oriented.Overlaps(bounds); });
    }

    /// Newer versions of Jolt do not ask for it, so it does not say that it overrides.
    virtual JPH::AABox GetBounds() const {
        const std::shared_lock<std::shared_mutex> lock(world_lock_);
        JPH::AABox bounds;
        for (const Told &told : bodies_) {
            if (!told.id.IsInvalid()) {
                bounds.Encapsulate(told.bounds);
            }
        }
        return bounds;
    }

private:
    /// What the world was told of the body in a slot; the id is invalid where there is none.
    struct Told {
        JPH::AABox bounds;
        JPH::BodyID id;
        JPH::ObjectLayer object_layer = 0;
        JPH::BroadPhaseLayer broad_layer = JPH::BroadPhaseLayer(0);
    };

    struct Hit {
        Told told;
        float fraction;
    };

    static void expect(Status status) {
        if (status != TRISAP_STATUS_OK) {
            std::fprintf(stderr, "trisap for Jolt: %s\n", text(status));
            std::abort();
        }
    }

    JPH::Body &body_of(JPH::BodyID id) const { return *mBodyManager->GetBodies()[id.GetIndex()]; }

    static trisap::Aabb exact(const JPH::AABox &bounds) {
        return {{bounds.mMin.GetX(), bounds.mMin.GetY(), bounds.mMin.GetZ()}, {bounds.mMax.GetX(), bounds.mMax.GetY(), bounds.mMax.GetZ()}};
    }

    /// Larger by half of the distance at which Jolt wants pairs, and a little more: so two of these overlap where Jolt's test of one
    /// box that is larger by all of it says so.
    trisap::Aabb box(const JPH::AABox &bounds) const {
        trisap::Aabb larger = exact(bounds);
        const float infinity = std::numeric_limits<float>::infinity();
        for (int k = 0; k < 3; k++) {
            larger.min[k] = std::nextafter(larger.min[k] - reach_, -infinity);
            larger.max[k] = std::nextafter(larger.max[k] + reach_, infinity);
        }
        return larger;
    }

    void update(const JPH::Body &body) const {
        const trisap::Id ours = ids_[body.GetID().GetIndex()];
        bodies_[trisap::slot(ours)].bounds = body.GetWorldSpaceBounds();
        expect(world_.update(ours, box(body.GetWorldSpaceBounds())));
    }

    /// Classes are object layers. The last one is for all that have no class of their own, and meets all.
    static std::uint32_t class_of(JPH::ObjectLayer layer) {
        return std::min<std::uint32_t>(static_cast<std::uint32_t>(layer), TRISAP_CLASSES - 1);
    }

    void set_layers(Told &told, trisap::Id ours, const JPH::Body &body) {
        told.object_layer = body.GetObjectLayer();
        told.broad_layer = body.GetBroadPhaseLayer();
        used_ |= 1u << class_of(told.object_layer);
        expect(world_.set_filter(ours, trisap::object_class(class_of(told.object_layer))));
    }

    /// Which layers meet: those that Jolt's filter lets meet in either order.
    void set_classes(const JPH::ObjectLayerPairFilter &filter) const {
        std::uint32_t meets[TRISAP_CLASSES];
        for (std::uint32_t a = 0; a < TRISAP_CLASSES; a++) {
            meets[a] = meets_[a];
            for (std::uint32_t b = 0; b < TRISAP_CLASSES - 1; b++) {
                if (a < TRISAP_CLASSES - 1 && (used_ >> a & used_ >> b & 1) != 0) {
                    const auto one = static_cast<JPH::ObjectLayer>(a), other = static_cast<JPH::ObjectLayer>(b);
                    const bool meet = filter.ShouldCollide(one, other) || filter.ShouldCollide(other, one);
                    meets[a] = (meets[a] & ~(1u << b)) | (meet ? 1u << b : 0);
                }
            }
        }
        if (std::memcmp(meets, meets_, sizeof meets) != 0) {
            std::memcpy(meets_, meets, sizeof meets);
            expect(world_.set_classes(meets));
        }
    }

    /// Steps, and sorts the pairs by body.
    void find_partners(float distance, const JPH::ObjectLayerPairFilter &filter) const {
        const std::lock_guard<std::shared_mutex> lock(world_lock_);
        if (!is_stale_) {
            return; // another thread has done it
        }
        if (0.5f * distance != reach_) {
            reach_ = 0.5f * distance;
            for (const Told &told : bodies_) {
                if (!told.id.IsInvalid()) {
                    update(body_of(told.id));
                }
            }
        }
        set_classes(filter);
        const trisap::Step step = world_.step();
        expect(step.status);
        is_unsettled_.store(false, std::memory_order_release);
        // Counted one place further on than they start, so that filling in moves each start to where it belongs.
        starts_.assign(bodies_.size() + 2, 0);
        for (const auto &[a, b] : step.pairs) {
            starts_[a + 2]++;
            starts_[b + 2]++;
        }
        for (std::size_t slot = 2; slot < starts_.size(); slot++) {
            starts_[slot] += starts_[slot - 1];
        }
        partners_.resize(starts_.back());
        for (const auto &[a, b] : step.pairs) {
            partners_[starts_[a + 1]++] = b;
            partners_[starts_[b + 1]++] = a;
        }
        is_stale_.store(false, std::memory_order_release);
    }

    /// The lock for a query. The first one after a change brings the tree up to date, steps or not.
    std::shared_lock<std::shared_mutex> for_queries() const {
        if (is_unsettled_.load(std::memory_order_acquire)) {
            const std::lock_guard<std::shared_mutex> lock(world_lock_);
            if (is_unsettled_) {
                expect(world_.refresh());
                is_unsettled_.store(false, std::memory_order_release);
            }
        }
        return std::shared_lock<std::shared_mutex>(world_lock_);
    }

    static bool passes(const Told &told, const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) {
        return broad_filter.ShouldCollide(told.broad_layer) && filter.ShouldCollide(told.object_layer);
    }

    /// So much larger that Jolt's tests, which are in floats and round, let nothing through that trisap has not found.
    static trisap::Aabb with_room(const JPH::AABox &bounds) {
        const JPH::Vec3 farthest = JPH::Vec3::sMax(bounds.mMin.Abs(), bounds.mMax.Abs());
        const JPH::Vec3 room = JPH::Vec3::sReplicate(1e-5f * farthest.ReduceMax());
        return exact(JPH::AABox(bounds.mMin - room, bounds.mMax + room));
    }

    /// The nearest first, by Jolt's own test of a ray with the boxes. What cannot be cast, NaN and the like, meets nothing.
    template <class Collector, class Far>
    void tell_hits(JPH::Vec3Arg center, JPH::Vec3Arg extent, JPH::Vec3Arg direction, const JPH::BroadPhaseLayerFilter &broad_filter,
                   const JPH::ObjectLayerFilter &filter, Collector &collector, Far far) const {
        trisap::Cast cast = {};
        cast.start = with_room(JPH::AABox(center - extent, center + extent));
        direction.StoreFloat3(reinterpret_cast<JPH::Float3 *>(cast.direction));
        cast.distance = std::max(far(), 0.0f);
        const JPH::RayInvDirection inverse(direction);
        std::vector<Hit> hits;
        {
            const std::shared_lock<std::shared_mutex> lock = for_queries();
            (void)world_.visit_hits(cast, [&](const trisap::Hit &hit) {
                const Told &told = bodies_[trisap::slot(hit.id)];
                const float fraction = JPH::RayAABox(center, inverse, told.bounds.mMin - extent, told.bounds.mMax + extent);
                if (fraction < cast.distance) {
                    hits.push_back({told, fraction});
                }
            });
        }
        std::sort(hits.begin(), hits.end(), [](const Hit &a, const Hit &b) { return a.fraction < b.fraction; });
        for (const Hit &hit : hits) {
            if (collector.ShouldEarlyOut() || hit.fraction >= far()) {
                return;
            }
            if (passes(hit.told, broad_filter, filter)) {
                collector.AddHit({hit.told.id, hit.fraction});
            }
        }
    }

    template <class Overlaps>
    void tell_overlaps(const JPH::AABox &box, const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter,
                       JPH::CollideShapeBodyCollector &collector, Overlaps overlaps) const {
        std::vector<Told> found;
        {
            const std::shared_lock<std::shared_mutex> lock = for_queries();
            (void)world_.visit_overlaps(trisap::region(with_room(box)), [&](trisap::Id id) {
                const Told &told = bodies_[trisap::slot(id)];
                if (overlaps(told.bounds)) {
                    found.push_back(told);
                }
            });
        }
        for (const Told &told : found) {
            if (passes(told, broad_filter, filter)) {
                collector.AddHit(told.id);
                if (collector.ShouldEarlyOut()) {
                    return;
                }
            }
        }
    }

    /// Shared by what adds, removes and notifies; exclusive while Jolt steps.
    std::shared_mutex modifications_;
    /// Of the world and of all that follows: shared by queries. Taken last, and given back before anything of others is called.
    mutable std::shared_mutex world_lock_;
    mutable trisap::World world_;
    /// Whether anything has changed since the last step.
    mutable std::atomic<bool> is_stale_{true};
    /// And since the tree was brought up to date.
    mutable std::atomic<bool> is_unsettled_{true};
    mutable float reach_ = 0;
    mutable std::uint32_t meets_[TRISAP_CLASSES] = {};
    std::uint32_t used_ = 0;
    /// By the index of a body.
    std::vector<trisap::Id> ids_;
    /// By slot.
    mutable std::vector<Told> bodies_;
    /// The partners of the body in slot `s` stand from `starts_[s]` to `starts_[s + 1]`.
    mutable std::vector<std::uint32_t> starts_, partners_;
};

} // namespace trisap

#endif // TRISAP_JOLT_HPP
