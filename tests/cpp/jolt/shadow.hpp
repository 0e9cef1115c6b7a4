// Jolt's own broad phase beside trisap: both are told the same, and have to say the same, of pairs and of queries. trisap works.

#ifndef SHADOW_HPP
#define SHADOW_HPP

#include <trisap_jolt.hpp>

#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseQuadTree.h>

#define CHECK(what) ((what) ? void() : (std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #what), std::abort()))

class Shadow final : public JPH::BroadPhase {
public:
    JPH_OVERRIDE_NEW_DELETE

    ~Shadow() override {
        std::printf("the same: %llu pairs in %llu calls, %llu answers to %llu queries\n", pairs_.load(), calls_.load(), answers_.load(),
                    queries_.load());
    }

    void Init(JPH::BodyManager *manager, const JPH::BroadPhaseLayerInterface &layers) override {
        BroadPhase::Init(manager, layers);
        tree_.Init(manager, layers);
        ours_.Init(manager, layers);
    }
    void Optimize() override {
        tree_.Optimize();
        ours_.Optimize();
    }
    void FrameSync() override {
        tree_.FrameSync();
        ours_.FrameSync();
    }
    void LockModifications() override {
        tree_.LockModifications();
        ours_.LockModifications();
    }
    UpdateState UpdatePrepare() override { return tree_.UpdatePrepare(); }
    void UpdateFinalize(const UpdateState &state) override { tree_.UpdateFinalize(state); }
    void UnlockModifications() override {
        ours_.UnlockModifications();
        tree_.UnlockModifications();
    }

    // The tree puts them into another order.
    AddState AddBodiesPrepare(JPH::BodyID *bodies, int count) override { return tree_.AddBodiesPrepare(bodies, count); }
    void AddBodiesFinalize(JPH::BodyID *bodies, int count, AddState state) override {
        tree_.AddBodiesFinalize(bodies, count, state);
        ours_.AddBodiesFinalize(bodies, count, nullptr);
    }
    void AddBodiesAbort(JPH::BodyID *bodies, int count, AddState state) override { tree_.AddBodiesAbort(bodies, count, state); }
    void RemoveBodies(JPH::BodyID *bodies, int count) override {
        tree_.RemoveBodies(bodies, count);
        ours_.RemoveBodies(bodies, count);
    }
    void NotifyBodiesAABBChanged(JPH::BodyID *bodies, int count, bool take_lock) override {
        tree_.NotifyBodiesAABBChanged(bodies, count, take_lock);
        ours_.NotifyBodiesAABBChanged(bodies, count, take_lock);
    }
    void NotifyBodiesLayerChanged(JPH::BodyID *bodies, int count) override {
        std::vector<JPH::BodyID> all(bodies, bodies + count);
        tree_.NotifyBodiesLayerChanged(bodies, count);
        ours_.NotifyBodiesLayerChanged(all.data(), count);
    }

    void FindCollidingPairs(JPH::BodyID *active, int count, float distance, const JPH::ObjectVsBroadPhaseLayerFilter &broad_filter,
                            const JPH::ObjectLayerPairFilter &filter, JPH::BodyPairCollector &collector) const override {
        std::vector<JPH::BodyID> all(active, active + count);
        Collect<JPH::BodyPairCollector> theirs, ours;
        tree_.FindCollidingPairs(active, count, distance, broad_filter, filter, theirs);
        ours_.FindCollidingPairs(all.data(), count, distance, broad_filter, filter, ours);
        // Boxes in the tree have grown since it was built.
        const auto are_apart = [&](const JPH::BodyPair &pair) {
            JPH::AABox bounds = bounds_of(pair.mBodyA);
            bounds.ExpandBy(JPH::Vec3::sReplicate(distance));
            return !bounds.Overlaps(bounds_of(pair.mBodyB));
        };
        theirs.hits.erase(std::remove_if(theirs.hits.begin(), theirs.hits.end(), are_apart), theirs.hits.end());
        pairs_ += theirs.hits.size();
        calls_++;
        CHECK(in_order(ours.hits) == in_order(theirs.hits));
        for (const JPH::BodyPair &pair : ours.hits) {
            collector.AddHit(pair);
        }
    }

    void CastRay(const JPH::RayCast &ray, JPH::RayCastBodyCollector &collector, const JPH::BroadPhaseLayerFilter &broad_filter,
                 const JPH::ObjectLayerFilter &filter) const override {
        Collect<JPH::RayCastBodyCollector> theirs, ours;
        tree_.CastRay(ray, theirs, broad_filter, filter);
        ours_.CastRay(ray, ours, broad_filter, filter);
        compare_hits(theirs.hits, ours.hits, ray.mOrigin, JPH::Vec3::sZero(), ray.mDirection);
        ours_.CastRay(ray, collector, broad_filter, filter);
    }
    void CastAABoxNoLock(const JPH::AABoxCast &box, JPH::CastShapeBodyCollector &collector,
                         const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        Collect<JPH::CastShapeBodyCollector> theirs, ours;
        tree_.CastAABoxNoLock(box, theirs, broad_filter, filter);
        ours_.CastAABoxNoLock(box, ours, broad_filter, filter);
        compare_hits(theirs.hits, ours.hits, box.mBox.GetCenter(), box.mBox.GetExtent(), box.mDirection);
        ours_.CastAABoxNoLock(box, collector, broad_filter, filter);
    }
    void CastAABox(const JPH::AABoxCast &box, JPH::CastShapeBodyCollector &collector, const JPH::BroadPhaseLayerFilter &broad_filter,
                   const JPH::ObjectLayerFilter &filter) const override {
        CastAABoxNoLock(box, collector, broad_filter, filter);
    }

    void CollideAABox(const JPH::AABox &box, JPH::CollideShapeBodyCollector &collector, const JPH::BroadPhaseLayerFilter &broad_filter,
                      const JPH::ObjectLayerFilter &filter) const override {
        compare([&](const JPH::BroadPhase &asked, JPH::CollideShapeBodyCollector &all) { asked.CollideAABox(box, all, broad_filter, filter); },
                [&](const JPH::AABox &bounds) { return bounds.Overlaps(box); }, collector);
    }
    void CollideSphere(JPH::Vec3Arg center, float radius, JPH::CollideShapeBodyCollector &collector,
                       const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        compare([&](const JPH::BroadPhase &asked, JPH::CollideShapeBodyCollector &all) { asked.CollideSphere(center, radius, all, broad_filter, filter); },
                [&](const JPH::AABox &bounds) { return bounds.GetSqDistanceTo(center) <= radius * radius; }, collector);
    }
    void CollidePoint(JPH::Vec3Arg point, JPH::CollideShapeBodyCollector &collector, const JPH::BroadPhaseLayerFilter &broad_filter,
                      const JPH::ObjectLayerFilter &filter) const override {
        compare([&](const JPH::BroadPhase &asked, JPH::CollideShapeBodyCollector &all) { asked.CollidePoint(point, all, broad_filter, filter); },
                [&](const JPH::AABox &bounds) { return bounds.Contains(point); }, collector);
    }
    void CollideOrientedBox(const JPH::OrientedBox &box, JPH::CollideShapeBodyCollector &collector,
                            const JPH::BroadPhaseLayerFilter &broad_filter, const JPH::ObjectLayerFilter &filter) const override {
        compare([&](const JPH::BroadPhase &asked, JPH::CollideShapeBodyCollector &all) { asked.CollideOrientedBox(box, all, broad_filter, filter); },
                [&](const JPH::AABox &bounds) { return box.Overlaps(bounds); }, collector);
    }
    JPH::AABox GetBounds() const override { return ours_.GetBounds(); }

private:
    template <class Collector> struct Collect final : Collector {
        using Result = typename Collector::ResultType;
        void AddHit(const Result &hit) override { hits.push_back(hit); }
        std::vector<Result> hits;
    };

    /// As numbers: Jolt compares its pairs through a pointer to another type, which a compiler may take amiss in a sort.
    static std::vector<std::uint64_t> in_order(const std::vector<JPH::BodyPair> &pairs) {
        std::vector<std::uint64_t> numbers;
        for (const JPH::BodyPair &pair : pairs) {
            numbers.push_back(std::uint64_t(pair.mBodyA.GetIndexAndSequenceNumber()) << 32 | pair.mBodyB.GetIndexAndSequenceNumber());
        }
        std::sort(numbers.begin(), numbers.end());
        return numbers;
    }

    const JPH::AABox &bounds_of(JPH::BodyID id) const { return mBodyManager->GetBody(id).GetWorldSpaceBounds(); }

    /// Without those that the tree's larger boxes alone have met.
    void compare_hits(const std::vector<JPH::BroadPhaseCastResult> &theirs, const std::vector<JPH::BroadPhaseCastResult> &ours,
                      JPH::Vec3Arg center, JPH::Vec3Arg extent, JPH::Vec3Arg direction) const {
        const JPH::RayInvDirection inverse(direction);
        std::vector<JPH::BodyID> expected, told;
        for (const JPH::BroadPhaseCastResult &hit : theirs) {
            const JPH::AABox &bounds = bounds_of(hit.mBodyID);
            if (JPH::RayAABox(center, inverse, bounds.mMin - extent, bounds.mMax + extent) < 1.0f + FLT_EPSILON) {
                expected.push_back(hit.mBodyID);
            }
        }
        float before = -FLT_MAX;
        for (const JPH::BroadPhaseCastResult &hit : ours) {
            CHECK(hit.mFraction >= before);
            before = hit.mFraction;
            told.push_back(hit.mBodyID);
        }
        compare_ids(expected, told);
    }

    template <class Ask, class Overlaps>
    void compare(Ask ask, Overlaps overlaps, JPH::CollideShapeBodyCollector &collector) const {
        Collect<JPH::CollideShapeBodyCollector> theirs, ours;
        ask(tree_, theirs);
        ask(ours_, ours);
        std::vector<JPH::BodyID> expected;
        std::copy_if(theirs.hits.begin(), theirs.hits.end(), std::back_inserter(expected), [&](JPH::BodyID id) { return overlaps(bounds_of(id)); });
        compare_ids(expected, ours.hits);
        ask(ours_, collector);
    }

    void compare_ids(std::vector<JPH::BodyID> expected, std::vector<JPH::BodyID> told) const {
        std::sort(expected.begin(), expected.end());
        std::sort(told.begin(), told.end());
        CHECK(expected == told);
        answers_ += told.size();
        queries_++;
    }

    JPH::BroadPhaseQuadTree tree_;
    trisap::JoltBroadPhase ours_;
    mutable std::atomic<unsigned long long> pairs_{0}, calls_{0}, answers_{0}, queries_{0};
};

#endif
