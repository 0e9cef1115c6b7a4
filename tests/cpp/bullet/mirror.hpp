// Two broad phases side by side: one works for Bullet, the other is told the same and must know the same.

#ifndef MIRROR_HPP
#define MIRROR_HPP

#include "../recording.hpp"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <LinearMath/btAabbUtil2.h>
#include <map>
#include <vector>

/// The number that the scene has given to the object of a proxy.
inline std::uint32_t name_of(const btBroadphaseProxy &proxy) {
    return static_cast<std::uint32_t>(static_cast<const btCollisionObject *>(proxy.m_clientObject)->getUserIndex());
}

inline bool overlap(const btBroadphaseProxy &a, const btBroadphaseProxy &b) {
    return share_a_point(a.m_aabbMin, a.m_aabbMax, b.m_aabbMin, b.m_aabbMax);
}

/// What the narrow phase gets, and how much of it truly overlaps.
struct HandedOver {
    std::vector<SlotPair> overlapping;
    std::size_t surplus = 0;
};

inline HandedOver handed_over(btBroadphaseInterface &broadphase) {
    HandedOver handed;
    const btBroadphasePairArray &pairs = broadphase.getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); i++) {
        const btBroadphaseProxy &a = *pairs[i].m_pProxy0, &b = *pairs[i].m_pProxy1;
        if (overlap(a, b)) {
            const std::uint32_t first = name_of(a), second = name_of(b);
            handed.overlapping.emplace_back(std::min(first, second), std::max(first, second));
        } else {
            handed.surplus++;
        }
    }
    std::sort(handed.overlapping.begin(), handed.overlapping.end());
    return handed;
}

class Mirror final : public btBroadphaseInterface {
public:
    /// Neither is owned.
    Mirror(btBroadphaseInterface &working, btBroadphaseInterface &other) : working_(working), other_(other) {}

    btBroadphaseProxy *createProxy(const btVector3 &min, const btVector3 &max, int shape, void *object, int group,
                                   int mask, btDispatcher *dispatcher) override {
        btBroadphaseProxy *proxy = working_.createProxy(min, max, shape, object, group, mask, dispatcher);
        others_[proxy] = other_.createProxy(min, max, shape, object, group, mask, dispatcher);
        return proxy;
    }

    void destroyProxy(btBroadphaseProxy *proxy, btDispatcher *dispatcher) override {
        other_.destroyProxy(others_.at(proxy), dispatcher);
        others_.erase(proxy);
        working_.destroyProxy(proxy, dispatcher);
    }

    void setAabb(btBroadphaseProxy *proxy, const btVector3 &min, const btVector3 &max,
                 btDispatcher *dispatcher) override {
        working_.setAabb(proxy, min, max, dispatcher);
        other_.setAabb(others_.at(proxy), min, max, dispatcher);
    }

    void getAabb(btBroadphaseProxy *proxy, btVector3 &min, btVector3 &max) const override {
        working_.getAabb(proxy, min, max);
        btVector3 same_min, same_max;
        other_.getAabb(others_.at(proxy), same_min, same_max);
        CHECK(min == same_min && max == same_max);
    }

    void calculateOverlappingPairs(btDispatcher *dispatcher) override {
        working_.calculateOverlappingPairs(dispatcher);
        other_.calculateOverlappingPairs(dispatcher);
    }

    void rayTest(const btVector3 &from, const btVector3 &to, btBroadphaseRayCallback &callback, const btVector3 &min,
                 const btVector3 &max) override {
        // A tree may offer more than the ray meets; what it meets counts.
        Collect first(callback), second(callback);
        const auto meets = [&](const btBroadphaseProxy &proxy) {
            const btVector3 bounds[2] = {proxy.m_aabbMin - max, proxy.m_aabbMax - min};
            btScalar entry = 0;
            return btRayAabb2(from, callback.m_rayDirectionInverse, callback.m_signs, bounds, entry, 0,
                              callback.m_lambda_max);
        };
        working_.rayTest(from, to, first, min, max);
        other_.rayTest(from, to, second, min, max);
        CHECK(first.names(meets) == second.names(meets));
        rays_met += first.names(meets).size();
        working_.rayTest(from, to, callback, min, max);
    }

    void aabbTest(const btVector3 &min, const btVector3 &max, btBroadphaseAabbCallback &callback) override {
        Collect first, second;
        const auto meets = [&](const btBroadphaseProxy &proxy) {
            return share_a_point(min, max, proxy.m_aabbMin, proxy.m_aabbMax);
        };
        working_.aabbTest(min, max, first);
        other_.aabbTest(min, max, second);
        CHECK(first.names(meets) == second.names(meets));
        boxes_met += first.names(meets).size();
        working_.aabbTest(min, max, callback);
    }

    btOverlappingPairCache *getOverlappingPairCache() override { return working_.getOverlappingPairCache(); }
    const btOverlappingPairCache *getOverlappingPairCache() const override {
        return working_.getOverlappingPairCache();
    }
    void getBroadphaseAabb(btVector3 &min, btVector3 &max) const override { working_.getBroadphaseAabb(min, max); }
    void resetPool(btDispatcher *dispatcher) override {
        working_.resetPool(dispatcher);
        other_.resetPool(dispatcher);
    }
    void printStats() override { working_.printStats(); }

    btBroadphaseInterface &working() { return working_; }
    btBroadphaseInterface &other() { return other_; }

    std::size_t rays_met = 0, boxes_met = 0;

private:
    /// Notes whom it is called for, and leaves the ray as long as it is.
    struct Collect final : btBroadphaseRayCallback {
        Collect() = default;
        explicit Collect(const btBroadphaseRayCallback &ray) : btBroadphaseRayCallback(ray) {}

        bool process(const btBroadphaseProxy *proxy) override {
            met.push_back(proxy);
            return true;
        }

        template <class Meets> std::vector<std::uint32_t> names(Meets meets) const {
            std::vector<std::uint32_t> names;
            for (const btBroadphaseProxy *proxy : met) {
                if (meets(*proxy)) {
                    names.push_back(name_of(*proxy));
                }
            }
            std::sort(names.begin(), names.end());
            return names;
        }

        std::vector<const btBroadphaseProxy *> met;
    };

    btBroadphaseInterface &working_, &other_;
    std::map<const btBroadphaseProxy *, btBroadphaseProxy *> others_;
};

#endif
