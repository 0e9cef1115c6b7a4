// trisap as a broad phase of Bullet: a btBroadphaseInterface over trisap.hpp. Needs Bullet's own headers.
//
//     trisap::BulletBroadphase broadphase;
//     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//
// Bullet keeps the pairs; trisap tells which are new and which are gone. Boxes are collected as Bullet sets them, and
// seen by one step for all of them. Rays and boxes ask trisap's tree, which the first question after a change brings up to
// date, steps or not. The world grows as bodies and pairs come.

#ifndef TRISAP_BULLET_HPP
#define TRISAP_BULLET_HPP

#include "trisap.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <vector>

namespace trisap {

/// A broad phase for `btCollisionWorld` and what derives from it. Bullet knows no way to be refused: where there is no memory, the
/// program ends and says why. A box with NaN in it, or turned inside out, is refused and counted, and the function of
/// `trisap_set_report` hears of it: the body keeps its last box, and a new one meets nobody until it has one.
///
/// Any number of threads may call `rayTest` and `aabbTest` at once, also for boxes that were set since the last step; what changes
/// the broad phase has to come from one thread at a time, while nobody asks.
class BulletBroadphase final : public btBroadphaseInterface {
public:
    /// With room for so many bodies at first. `pairs` is a pair cache of the caller's that removes pairs when it is told, as Bullet's
    /// hashed one does, or null for one of its own.
    explicit BulletBroadphase(std::uint32_t objects = 1024, btOverlappingPairCache *pairs = nullptr)
        : config_(trisap::config(objects)), pairs_(pairs == nullptr ? own_pairs_ : *pairs) {
        config_.events = 1;
        begin();
    }

    btBroadphaseProxy *createProxy(const btVector3 &min, const btVector3 &max, int /*shape*/, void *object, int group,
                                   int mask, btDispatcher * /*dispatcher*/) override {
        auto proxy = std::make_unique<Proxy>(min, max, object, group, mask);
        proxy->m_uniqueId = ++last_unique_id_;
        without_box_.push_back(std::move(proxy));
        return admit(without_box_.size() - 1, box(min, max));
    }

    void destroyProxy(btBroadphaseProxy *proxy, btDispatcher *dispatcher) override {
        pairs_.removeOverlappingPairsContainingProxy(proxy, dispatcher);
        const trisap::Id id = static_cast<Proxy *>(proxy)->id;
        if (id == trisap::null_id) {
            without_box_.erase(without_box_.begin() + static_cast<std::ptrdiff_t>(place_without_box(proxy)));
            return;
        }
        expect(world_.remove(id));
        has_unknown_.store(true, std::memory_order_release);
        proxies_[trisap::slot(id)].reset();
    }

    void setAabb(btBroadphaseProxy *proxy, const btVector3 &written_min, const btVector3 &written_max, btDispatcher *) override {
        const btVector3 min = read(written_min), max = read(written_max);
        Proxy &its = *static_cast<Proxy *>(proxy);
        const trisap::Aabb aabb = box(min, max);
        if (its.id == trisap::null_id) {
            proxy->m_aabbMin = min;
            proxy->m_aabbMax = max;
            admit(place_without_box(proxy), aabb);
            return;
        }
        if (!is_box(aabb)) {
            refused_boxes_++;
            // For the report.
            static_cast<void>(world_.update(its.id, aabb));
            return;
        }
        // What Bullet sets is in the proxy's lines of the cache: nothing else is read for a body.
        if (!same(proxy->m_aabbMin, min) || !same(proxy->m_aabbMax, max)) {
            proxy->m_aabbMin = min;
            proxy->m_aabbMax = max;
            boxes_[its.slot] = aabb;
            its.moved_at = steps_;
            unknown_slots_.push_back(its.slot);
            has_unknown_.store(true, std::memory_order_release);
        } else if (steps_ - its.set_at >= 2) {
            // DBVT takes a body for a resting one by then, and looks for its pairs when it wakes.
            its.moved_at = steps_;
        }
        its.set_at = steps_;
    }

    void getAabb(btBroadphaseProxy *proxy, btVector3 &min, btVector3 &max) const override {
        min = proxy->m_aabbMin;
        max = proxy->m_aabbMax;
    }

    void calculateOverlappingPairs(btDispatcher *dispatcher) override {
        const trisap::Step step = world_.step_over(trisap::boxes(boxes_));
        expect(step.status);
        for (const auto &[a, b] : step.lost) {
            // The pairs of a removed object went with it, and its slot may hold another one by now.
            if (stayed(a) && stayed(b)) {
                pairs_.removeOverlappingPair(proxies_[a].get(), proxies_[b].get(), dispatcher);
            }
        }
        offer_again();
        for (const auto &[a, b] : step.found) {
            offer(a, b);
        }
        if (static_cast<std::size_t>(pairs_.getNumOverlappingPairs()) + not_taken_.size() != step.pairs.size()) {
            look_for_removed(step.pairs);
        }
        unknown_slots_.clear();
        has_unknown_.store(false, std::memory_order_relaxed);
        steps_++;
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
        // What cannot be cast, NaN and the like, meets nothing, and is reported.
        static_cast<void>(world_.visit_hits(cast, [&](trisap::Hit hit) { callback.process(proxy(hit.id)); }));
    }

    void aabbTest(const btVector3 &min, const btVector3 &max, btBroadphaseAabbCallback &callback) override {
        tell_boxes();
        const trisap::Region region = trisap::region(box(min, max));
        static_cast<void>(world_.visit_overlaps(region, [&](trisap::Id id) { callback.process(proxy(id)); }));
    }

    /// Boxes that were refused since the broad phase was made.
    std::uint64_t refused_boxes() const { return refused_boxes_; }

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
            not_taken_.clear();
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
        Proxy(const btVector3 &min, const btVector3 &max, void *object, int group, int mask)
            : btBroadphaseProxy(min, max, object, group, mask) {}
        /// Null until it has a box.
        trisap::Id id = trisap::null_id;
        std::uint32_t slot = 0;
        // How many steps there were when it came, when its box was set last, and when it was set to another one.
        std::uint32_t came_at = 0, set_at = 0, moved_at = 0;
    };

    /// Number by number, as Bullet has just written it: a wider load would wait until all of it has reached the cache.
    static btVector3 read(const btVector3 &corner) {
        const volatile btScalar *numbers = corner.m_floats;
        const btScalar x = numbers[0], y = numbers[1], z = numbers[2];
        return {x, y, z};
    }

    static trisap::Aabb box(const btVector3 &min, const btVector3 &max) {
        if constexpr (sizeof(btScalar) > sizeof(float)) {
            // Rounded outward, so that no pair is lost.
            return trisap::aabb_from_f64({min.x(), min.y(), min.z()}, {max.x(), max.y(), max.z()}, {0, 0, 0});
        } else {
            const auto same = [](btScalar x) { return static_cast<float>(x); };
            return {{same(min.x()), same(min.y()), same(min.z())}, {same(max.x()), same(max.y()), same(max.z())}};
        }
    }

    static bool same(const btVector3 &a, const btVector3 &b) { return a.x() == b.x() && a.y() == b.y() && a.z() == b.z(); }

    static bool is_box(const trisap::Aabb &aabb) {
        return aabb.min[0] <= aabb.max[0] && aabb.min[1] <= aabb.max[1] && aabb.min[2] <= aabb.max[2];
    }

    std::size_t place_without_box(const btBroadphaseProxy *proxy) const {
        const auto found = std::find_if(without_box_.begin(), without_box_.end(), [&](const auto &one) { return one.get() == proxy; });
        return static_cast<std::size_t>(found - without_box_.begin());
    }

    /// Takes a body into the world, if its box is one.
    Proxy *admit(std::size_t place, const trisap::Aabb &aabb) {
        Proxy *proxy = without_box_[place].get();
        trisap::Status status = TRISAP_STATUS_OK;
        proxy->id = world_.insert(aabb, &status);
        if (status == TRISAP_STATUS_BAD_BOX) {
            refused_boxes_++;
            return proxy;
        }
        expect(status);
        const std::uint32_t slot = trisap::slot(proxy->id);
        if (slot >= proxies_.size()) {
            boxes_.resize(slot + 1);
            proxies_.resize(slot + 1);
        }
        proxies_[slot] = std::move(without_box_[place]);
        without_box_.erase(without_box_.begin() + static_cast<std::ptrdiff_t>(place));
        boxes_[slot] = aabb;
        proxy->slot = slot;
        proxy->came_at = proxy->set_at = proxy->moved_at = steps_;
        has_unknown_.store(true, std::memory_order_release);
        return proxy;
    }

    /// Questions are answered for the boxes as they are now, steps or not: the first one after a change tells the world, and brings its
    /// tree up to date.
    void tell_boxes() {
        if (!has_unknown_.load(std::memory_order_acquire)) {
            return;
        }
        const std::lock_guard<std::mutex> lock(telling_);
        if (has_unknown_.load(std::memory_order_relaxed)) {
            while (!unknown_slots_.empty()) {
                const std::uint32_t slot = unknown_slots_.back();
                // Busy inside of a callback that has set boxes: these are for the next question.
                if (proxies_[slot] != nullptr && world_.update(proxies_[slot]->id, boxes_[slot]) != TRISAP_STATUS_OK) {
                    return;
                }
                unknown_slots_.pop_back();
            }
            if (world_.refresh() != TRISAP_STATUS_OK) {
                return;
            }
            has_unknown_.store(false, std::memory_order_release);
        }
    }

    /// The cache may refuse by masks, groups and a filter of the caller's.
    void offer(std::uint32_t a, std::uint32_t b) {
        if (pairs_.addOverlappingPair(proxies_[a].get(), proxies_[b].get()) == nullptr) {
            not_taken_.push_back({proxies_[a]->id, proxies_[b]->id});
        }
    }

    /// Offers what the cache does not have once more where one of the two has moved, as DBVT does: what it goes by may have changed.
    void offer_again() {
        const auto is_done = [&](const trisap::IdPair &pair) {
            Proxy *a = proxies_[trisap::slot(pair.a)].get(), *b = proxies_[trisap::slot(pair.b)].get();
            if (a == nullptr || b == nullptr || a->id != pair.a || b->id != pair.b) {
                return true;
            }
            return has_moved(a->slot, b->slot) &&
                   (!overlap(boxes_[a->slot], boxes_[b->slot]) || pairs_.addOverlappingPair(a, b) != nullptr);
        };
        not_taken_.erase(std::remove_if(not_taken_.begin(), not_taken_.end(), is_done), not_taken_.end());
    }

    /// Somebody else has removed pairs from the cache: notes which, to offer them when they move.
    void look_for_removed(trisap::View<const trisap::Pair> pairs) {
        not_taken_.clear();
        for (const auto &[a, b] : pairs) {
            if (pairs_.findPair(proxies_[a].get(), proxies_[b].get()) != nullptr) {
                continue;
            }
            if (has_moved(a, b)) {
                offer(a, b);
            } else {
                not_taken_.push_back({proxies_[a]->id, proxies_[b]->id});
            }
        }
    }

    static bool overlap(const trisap::Aabb &a, const trisap::Aabb &b) {
        bool all = true;
        for (int k = 0; k < 3; k++) {
            all = all && a.min[k] <= b.max[k] && b.min[k] <= a.max[k];
        }
        return all;
    }

    btBroadphaseProxy *proxy(trisap::Id id) const { return proxies_[trisap::slot(id)].get(); }

    bool stayed(std::uint32_t slot) const { return proxies_[slot] != nullptr && proxies_[slot]->came_at != steps_; }

    bool has_moved(std::uint32_t a, std::uint32_t b) const { return proxies_[a]->moved_at == steps_ || proxies_[b]->moved_at == steps_; }

    trisap::Config config_;
    trisap::World world_;
    btHashedOverlappingPairCache own_pairs_;
    btOverlappingPairCache &pairs_;
    // By slot.
    std::vector<trisap::Aabb> boxes_;
    std::vector<std::unique_ptr<Proxy>> proxies_;
    // Those whose boxes the world does not know yet.
    std::vector<std::uint32_t> unknown_slots_;
    std::atomic<bool> has_unknown_{false};
    std::mutex telling_;
    // Bodies whose boxes were refused when they came.
    std::vector<std::unique_ptr<Proxy>> without_box_;
    // Pairs of the last step that the cache does not have.
    std::vector<trisap::IdPair> not_taken_;
    std::uint32_t steps_ = 0;
    std::uint64_t refused_boxes_ = 0;
    int last_unique_id_ = 0;
};

} // namespace trisap

#endif // TRISAP_BULLET_HPP
