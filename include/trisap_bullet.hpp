// trisap as a broad phase of Bullet: a btBroadphaseInterface over trisap.hpp. Needs Bullet's own headers.
//
//     trisap::BulletBroadphase broadphase;
//     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//
// Bullet keeps the pairs; trisap tells which are new and which are gone. Boxes are collected as Bullet sets them, and
// seen by one step for all of them. Rays and boxes ask trisap's tree. The world grows as bodies and pairs come.

#ifndef TRISAP_BULLET_HPP
#define TRISAP_BULLET_HPP

#include "trisap.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace trisap {

/// A broad phase for `btCollisionWorld` and what derives from it. Bullet knows no way to be refused: where there is no memory, or a box
/// has NaN in it, the program ends and says why.
class BulletBroadphase final : public btBroadphaseInterface {
public:
    /// With room for so many bodies at first. `pairs` is a pair cache of the caller's, or null for one of its own.
    explicit BulletBroadphase(std::uint32_t objects = 1024, btOverlappingPairCache *pairs = nullptr)
        : config_(trisap::config(objects)), pairs_(pairs == nullptr ? own_pairs_ : *pairs) {
        config_.events = 1;
        begin();
    }

    btBroadphaseProxy *createProxy(const btVector3 &min, const btVector3 &max, int /*shape*/, void *object, int group,
                                   int mask, btDispatcher * /*dispatcher*/) override {
        trisap::Status status = TRISAP_STATUS_OK;
        const trisap::Id id = world_.insert(box(min, max), &status);
        expect(status);
        const std::uint32_t slot = trisap::slot(id);
        if (slot >= proxies_.size()) {
            boxes_.resize(slot + 1);
            proxies_.resize(slot + 1);
            is_new_.resize(slot + 1);
        }
        proxies_[slot] = std::make_unique<Proxy>(min, max, object, group, mask, id);
        proxies_[slot]->m_uniqueId = ++last_unique_id_;
        boxes_[slot] = box(min, max);
        is_new_[slot] = 1;
        new_slots_.push_back(slot);
        return proxies_[slot].get();
    }

    void destroyProxy(btBroadphaseProxy *proxy, btDispatcher *dispatcher) override {
        pairs_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
        const trisap::Id id = static_cast<Proxy *>(proxy)->id;
        expect(world_.remove(id));
        proxies_[trisap::slot(id)].reset();
    }

    void setAabb(btBroadphaseProxy *proxy, const btVector3 &min, const btVector3 &max, btDispatcher *) override {
        proxy->m_aabbMin = min;
        proxy->m_aabbMax = max;
        const std::uint32_t slot = trisap::slot(static_cast<Proxy *>(proxy)->id);
        boxes_[slot] = box(min, max);
        set_slots_.push_back(slot);
    }

    void getAabb(btBroadphaseProxy *proxy, btVector3 &min, btVector3 &max) const override {
        min = proxy->m_aabbMin;
        max = proxy->m_aabbMax;
    }

    void calculateOverlappingPairs(btDispatcher *dispatcher) override {
        const trisap::Step step = world_.step_over(trisap::boxes(boxes_));
        expect(step.rejected == 0 ? step.status : TRISAP_STATUS_BAD_BOX);
        for (const auto &[a, b] : step.lost) {
            // The pairs of a removed object went with it, and its slot may hold another one by now.
            if (stayed(a) && stayed(b)) {
                pairs_.removeOverlappingPair(proxies_[a].get(), proxies_[b].get(), dispatcher);
            }
        }
        for (const auto &[a, b] : step.found) {
            pairs_.addOverlappingPair(proxies_[a].get(), proxies_[b].get());
        }
        for (const std::uint32_t slot : new_slots_) {
            is_new_[slot] = 0;
        }
        new_slots_.clear();
        set_slots_.clear();
    }

    /// A box that moves along the ray: `min` and `max` tell how far it reaches around the ray's point.
    void rayTest(const btVector3 &from, const btVector3 &to, btBroadphaseRayCallback &callback, const btVector3 &min,
                 const btVector3 &max) override {
        tell_boxes();
        // Bullet's own tests are in floats and round: nothing that they would meet is left out.
        const btScalar room = (from.absolute() + to.absolute())[(from.absolute() + to.absolute()).maxAxis()] * 1e-5f;
        const btVector3 around(room, room, room);
        const btVector3 direction = (to - from).fuzzyZero() ? btVector3(0, 0, 0) : (to - from).normalized();
        trisap::Cast cast = {};
        cast.start = box(from + min - around, from + max + around);
        for (int k = 0; k < 3; k++) {
            cast.direction[k] = static_cast<float>(direction[k]);
        }
        cast.distance = static_cast<float>(callback.m_lambda_max + room);
        expect(world_.visit_hits(cast, [&](trisap::Hit hit) { callback.process(proxy(hit.id)); }));
    }

    void aabbTest(const btVector3 &min, const btVector3 &max, btBroadphaseAabbCallback &callback) override {
        tell_boxes();
        const trisap::Region region = trisap::region(box(min, max));
        expect(world_.visit_overlaps(region, [&](trisap::Id id) { callback.process(proxy(id)); }));
    }

    btOverlappingPairCache *getOverlappingPairCache() override { return &pairs_; }
    const btOverlappingPairCache *getOverlappingPairCache() const override { return &pairs_; }

    void getBroadphaseAabb(btVector3 &min, btVector3 &max) const override {
        min.setValue(0, 0, 0);
        max.setValue(0, 0, 0);
        bool first = true;
        for (const auto &proxy : proxies_) {
            if (proxy) {
                first ? void(min = proxy->m_aabbMin) : min.setMin(proxy->m_aabbMin);
                first ? void(max = proxy->m_aabbMax) : max.setMax(proxy->m_aabbMax);
                first = false;
            }
        }
    }

    /// So that a scene that is built again runs as it did.
    void resetPool(btDispatcher *) override {
        if (world_.size() == 0) {
            begin();
            last_unique_id_ = 0;
        }
    }

    void printStats() override {
        const trisap::Stats stats = world_.stats();
        std::printf("trisap: %u objects, %u moved, %llu pairs\n", stats.objects, stats.moved,
                    static_cast<unsigned long long>(stats.pairs));
    }

private:
    void begin() {
        expect(world_.init(config_));
        world_.set_growing(true);
    }

    static void expect(Status status) {
        if (status != TRISAP_STATUS_OK) {
            std::fprintf(stderr, "trisap for Bullet: %s\n", text(status));
            std::abort();
        }
    }

    struct Proxy : btBroadphaseProxy {
        Proxy(const btVector3 &min, const btVector3 &max, void *object, int group, int mask, trisap::Id named)
            : btBroadphaseProxy(min, max, object, group, mask), id(named) {}
        trisap::Id id;
    };

    static trisap::Aabb box(const btVector3 &min, const btVector3 &max) {
        if constexpr (sizeof(btScalar) > sizeof(float)) {
            // Rounded outward, so that no pair is lost.
            return trisap::aabb_from_f64({min.x(), min.y(), min.z()}, {max.x(), max.y(), max.z()}, {0, 0, 0});
        } else {
            const auto same = [](btScalar x) { return static_cast<float>(x); };
            return {{same(min.x()), same(min.y()), same(min.z())}, {same(max.x()), same(max.y()), same(max.z())}};
        }
    }

    /// Questions are answered for the boxes as they are now, steps or not.
    void tell_boxes() {
        for (const std::uint32_t slot : set_slots_) {
            if (proxies_[slot] != nullptr) {
                expect(world_.update(proxies_[slot]->id, boxes_[slot]));
            }
        }
        set_slots_.clear();
    }

    btBroadphaseProxy *proxy(trisap::Id id) const { return proxies_[trisap::slot(id)].get(); }

    bool stayed(std::uint32_t slot) const { return proxies_[slot] != nullptr && is_new_[slot] == 0; }

    trisap::Config config_;
    trisap::World world_;
    btHashedOverlappingPairCache own_pairs_;
    btOverlappingPairCache &pairs_;
    // By slot.
    std::vector<trisap::Aabb> boxes_;
    std::vector<std::unique_ptr<Proxy>> proxies_;
    std::vector<char> is_new_;
    std::vector<std::uint32_t> new_slots_;
    // Boxes that Bullet has set since the last step, and that the world does not know yet.
    std::vector<std::uint32_t> set_slots_;
    int last_unique_id_ = 0;
};

} // namespace trisap

#endif // TRISAP_BULLET_HPP
