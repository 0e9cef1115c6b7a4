// What Bullet's hosts do to a broad phase between its steps: rays from several threads after boxes were set, masks, groups and filters
// that change while bodies overlap, pairs that are taken out of the cache, boxes with NaN in them. Beside btDbvtBroadphase or brute force.

#include "mirror.hpp"

#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>
#include <thread>
#include <trisap_bullet.hpp>

/// How far DBVT lets a body move before it looks for its pairs.
extern btScalar gDbvtMargin;

namespace {

std::mt19937 randomness(1);
unsigned below(unsigned end) { return static_cast<unsigned>(randomness() % end); }
/// Of few digits, so that what moves keeps its size.
btScalar within(int half) { return static_cast<btScalar>(static_cast<int>(below(static_cast<unsigned>(half) * 128 + 1)) - half * 64) / 64; }
btVector3 place(int half) { return {within(half), within(half), within(half)}; }

/// Counts whom it is called for, of those that a box truly meets.
struct Count final : btBroadphaseAabbCallback {
    Count(const btVector3 &low, const btVector3 &high) : min(low), max(high) {}
    bool process(const btBroadphaseProxy *proxy) override {
        met += share_a_point(min, max, proxy->m_aabbMin, proxy->m_aabbMax);
        return true;
    }
    btVector3 min, max;
    std::size_t met = 0;
};

struct Ray final : btBroadphaseRayCallback {
    Ray(const btVector3 &from, const btVector3 &to) : start(from) {
        const btVector3 direction = (to - from).normalized();
        for (int k = 0; k < 3; k++) {
            m_rayDirectionInverse[k] = direction[k] == 0 ? BT_LARGE_FLOAT : 1 / direction[k];
            m_signs[k] = m_rayDirectionInverse[k] < 0;
        }
        m_lambda_max = direction.dot(to - from);
    }
    bool meets(const btBroadphaseProxy &proxy) const {
        const btVector3 bounds[2] = {proxy.m_aabbMin, proxy.m_aabbMax};
        btScalar entry = 0;
        return btRayAabb2(start, m_rayDirectionInverse, m_signs, bounds, entry, 0, m_lambda_max);
    }
    bool process(const btBroadphaseProxy *proxy) override {
        met += meets(*proxy);
        return true;
    }
    btVector3 start;
    std::size_t met = 0;
};

void ask(btBroadphaseInterface &broadphase, Ray &ray, const btVector3 &to) { broadphase.rayTest(ray.start, to, ray); }

/// Four threads ask at once, right after boxes were set: each sees all of these, and none writes where others read.
void rays_from_threads() {
    trisap::BulletBroadphase broadphase;
    std::vector<btBroadphaseProxy *> proxies;
    for (int i = 0; i < 3000; i++) {
        const btVector3 at = place(15);
        proxies.push_back(broadphase.createProxy(at, at + btVector3(1, 1, 1), 0, nullptr, 1, -1, nullptr));
    }
    std::size_t met = 0;
    for (int round = 0; round < 8; round++) {
        // In the first round there has been no step yet; and in every other one boxes are set for the second time.
        if (round % 2 == 1) {
            broadphase.calculateOverlappingPairs(nullptr);
        }
        for (std::size_t i = 0; i < (round % 4 < 2 ? proxies.size() : 100); i++) {
            const btVector3 at = place(15);
            broadphase.setAabb(proxies[i], at, at + btVector3(1, 1, 1), nullptr);
        }
        struct Question {
            btVector3 from, to;
            std::size_t by_ray = 0, by_box = 0;
        };
        std::vector<Question> questions(64);
        for (Question &question : questions) {
            question.from = place(18);
            question.to = place(18);
        }
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < 4; t++) {
            threads.emplace_back([&, t] {
                for (std::size_t i = t; i < questions.size(); i += 4) {
                    Ray ray(questions[i].from, questions[i].to);
                    ask(broadphase, ray, questions[i].to);
                    questions[i].by_ray = ray.met;
                    Count count(questions[i].from, questions[i].from + btVector3(5, 5, 5));
                    broadphase.aabbTest(count.min, count.max, count);
                    questions[i].by_box = count.met;
                }
            });
        }
        for (std::thread &thread : threads) {
            thread.join();
        }
        for (const Question &question : questions) {
            const Ray ray(question.from, question.to);
            Count count(question.from, question.from + btVector3(5, 5, 5));
            std::size_t by_ray = 0;
            for (const btBroadphaseProxy *proxy : proxies) {
                by_ray += ray.meets(*proxy);
                count.process(proxy);
            }
            CHECK(question.by_ray == by_ray && question.by_box == count.met);
            met += by_ray + count.met;
        }
    }
    CHECK(met > 1000);
}

/// Lets pairs pass by the sum of two numbers of the host's, which change without a word.
struct Moody final : btOverlapFilterCallback {
    bool needBroadphaseCollision(btBroadphaseProxy *a, btBroadphaseProxy *b) const override {
        return mood == 0 || (name_of(*a) + name_of(*b)) % mood != 0;
    }
    unsigned mood = 0;
};

/// trisap and DBVT, told the same. Moved bodies keep their sizes, so DBVT looks for the pairs of each that has moved.
class Both {
public:
    Both() {
        for (auto *cache : {ours_.getOverlappingPairCache(), dbvt_.getOverlappingPairCache()}) {
            cache->setOverlapFilterCallback(nullptr);
        }
        for (int i = 0; i < 60; i++) {
            objects_[i].setUserIndex(i);
            create(i);
        }
        step();
    }

    ~Both() {
        for (int i = 0; i < 60; i++) {
            destroy(i);
        }
    }

    void change_a_rule() {
        const int one = static_cast<int>(below(60));
        switch (below(5)) {
        case 0: set_masks(one, 1 << below(3), static_cast<int>(below(8))); break;
        case 1: set_masks(one, 1 << below(3), 7); break;
        case 2: each(one, [&](auto &, auto *cache, auto *proxy) { cache->removeOverlappingPairsContainingProxy(proxy, &dispatcher_); }); break;
        case 3: each(one, [&](auto &, auto *cache, auto *proxy) { cache->cleanProxyFromPairs(proxy, &dispatcher_); }); break;
        default:
            moody_.mood = below(4);
            for (auto *cache : {ours_.getOverlappingPairCache(), dbvt_.getOverlappingPairCache()}) {
                cache->setOverlapFilterCallback(moody_.mood == 3 ? nullptr : &moody_);
            }
        }
    }

    void move_one() {
        const int one = static_cast<int>(below(60));
        switch (below(8)) {
        case 0: // As btCollisionWorld::refreshBroadphaseProxy.
            destroy(one);
            create(one);
            break;
        // Set, but as it was.
        case 1: move(one, btVector3(0, 0, 0)); break;
        default: move(one, place(1)); break;
        }
    }

    std::size_t step() {
        ours_.calculateOverlappingPairs(&dispatcher_);
        // All pairs that have parted go at once, and not a tenth of them: kept ones would not be asked about again.
        dbvt_.m_cupdates = 100;
        dbvt_.m_cid = 0;
        dbvt_.calculateOverlappingPairs(&dispatcher_);
        const HandedOver first = handed_over(ours_), second = handed_over(dbvt_);
        CHECK(first.surplus == 0 && first.overlapping == second.overlapping);
        return first.overlapping.size();
    }

    void move(int one, const btVector3 &by) {
        each(one, [&](auto &broadphase, auto *, auto *proxy) { broadphase.setAabb(proxy, proxy->m_aabbMin + by, proxy->m_aabbMax + by, &dispatcher_); });
    }

    void set_masks(int one, int group, int mask) {
        each(one, [&](auto &, auto *, auto *proxy) {
            proxy->m_collisionFilterGroup = group;
            proxy->m_collisionFilterMask = mask;
        });
    }

private:
    void create(int one) {
        const btVector3 at = place(5);
        for (btBroadphaseInterface *broadphase : {static_cast<btBroadphaseInterface *>(&ours_), static_cast<btBroadphaseInterface *>(&dbvt_)}) {
            proxies_[broadphase == &dbvt_][one] =
                broadphase->createProxy(at, at + btVector3(2, 2, 2), 0, &objects_[one], 1, 7, &dispatcher_);
        }
    }

    void destroy(int one) {
        each(one, [&](auto &broadphase, auto *, auto *proxy) { broadphase.destroyProxy(proxy, &dispatcher_); });
    }

    template <class Call> void each(int one, Call call) {
        call(static_cast<btBroadphaseInterface &>(ours_), ours_.getOverlappingPairCache(), proxies_[0][one]);
        call(static_cast<btBroadphaseInterface &>(dbvt_), dbvt_.getOverlappingPairCache(), proxies_[1][one]);
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    Moody moody_;
    btCollisionObject objects_[60];
    trisap::BulletBroadphase ours_{16};
    btDbvtBroadphase dbvt_;
    btBroadphaseProxy *proxies_[2][60] = {};
};

void rules_that_change() {
    gDbvtMargin = 0;
    std::size_t pairs = 0;
    for (int life = 0; life < 12; life++) {
        Both both;
        for (int step = 0; step < 250; step++) {
            // Rules first, as DBVT asks about them when a body moves, and trisap in the step.
            for (unsigned left = below(3); left > 0; left--) {
                both.change_a_rule();
            }
            // Sometimes nothing moves, or little, so that DBVT takes bodies for resting ones.
            for (unsigned left = below(3) == 0 ? below(40) : below(3); left > 0; left--) {
                both.move_one();
            }
            pairs += both.step();
        }
    }
    std::printf("rules that change: %zu pairs as DBVT has them\n", pairs);
    CHECK(pairs > 10000);
}

/// The case that players see: two bodies overlap, and only then may they meet.
void masks_that_allow_later() {
    trisap::BulletBroadphase broadphase;
    btOverlappingPairCache &cache = *broadphase.getOverlappingPairCache();
    btBroadphaseProxy *proxies[2];
    for (auto &proxy : proxies) {
        proxy = broadphase.createProxy({0, 0, 0}, {4, 4, 4}, 0, nullptr, 1, 0, nullptr);
    }
    auto step_after_move = [&, at = btScalar(0)]() mutable {
        at += 0.5f;
        for (auto *proxy : proxies) {
            broadphase.setAabb(proxy, {at, at, at}, {at + 4, at + 4, at + 4}, nullptr);
        }
        broadphase.calculateOverlappingPairs(nullptr);
        return cache.getNumOverlappingPairs();
    };
    CHECK(step_after_move() == 0);
    for (auto *proxy : proxies) {
        proxy->m_collisionFilterMask = 1;
    }
    CHECK(step_after_move() == 1);
    // A mask that refuses lets a pair be until it is taken out; and then it does not come back.
    proxies[0]->m_collisionFilterMask = 0;
    CHECK(step_after_move() == 1);
    cache.removeOverlappingPairsContainingProxy(proxies[0], nullptr);
    CHECK(step_after_move() == 0 && step_after_move() == 0);
    proxies[0]->m_collisionFilterMask = -1;
    CHECK(step_after_move() == 1);
    broadphase.destroyProxy(proxies[0], nullptr);
    CHECK(cache.getNumOverlappingPairs() == 0);
    broadphase.destroyProxy(proxies[1], nullptr);
}

unsigned reports = 0;

/// Nothing ends; the body keeps its last box, or meets nobody until it has one.
void boxes_with_nan() {
    trisap_set_report([](void *, trisap_status status, std::uint64_t, const char *) { reports += status == TRISAP_STATUS_BAD_BOX; }, nullptr);
    trisap::BulletBroadphase broadphase;
    btOverlappingPairCache &cache = *broadphase.getOverlappingPairCache();
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    const btVector3 low(0, 0, 0), high(1, 1, 1), bad(0, nan, 0);
    btBroadphaseProxy *good = broadphase.createProxy(low, high, 0, nullptr, 1, -1, nullptr);
    btBroadphaseProxy *late = broadphase.createProxy(bad, high, 0, nullptr, 1, -1, nullptr);
    btBroadphaseProxy *never = broadphase.createProxy(high, low, 0, nullptr, 1, -1, nullptr);
    const auto pairs = [&] {
        broadphase.calculateOverlappingPairs(nullptr);
        return cache.getNumOverlappingPairs();
    };
    CHECK(pairs() == 0 && broadphase.refused_boxes() == 2 && reports == 2);
    broadphase.setAabb(late, low, bad, nullptr);
    CHECK(pairs() == 0 && broadphase.refused_boxes() == 3 && reports == 3);
    broadphase.setAabb(late, low, high, nullptr);
    CHECK(pairs() == 1 && reports == 3);
    // As it was, for steps, rays and whoever asks.
    broadphase.setAabb(good, bad, high, nullptr);
    btVector3 min, max;
    broadphase.getAabb(good, min, max);
    CHECK(min == low && max == high && pairs() == 1 && broadphase.refused_boxes() == 4 && reports == 4);
    Count count(low, high);
    broadphase.aabbTest(low, high, count);
    CHECK(count.met == 2);
    // Questions without sense have no answer.
    Count none(low, bad);
    broadphase.aabbTest(low, bad, none);
    Ray ray(low, high);
    ask(broadphase, ray, bad);
    CHECK(none.met == 0 && ray.met == 0);
    for (btBroadphaseProxy *proxy : {never, good, late}) {
        broadphase.destroyProxy(proxy, nullptr);
    }
    CHECK(pairs() == 0);
    trisap_set_report(nullptr, nullptr);
}

/// The same through a whole world: others go on.
void a_body_with_nan_in_a_world() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btSequentialImpulseConstraintSolver solver;
    trisap::BulletBroadphase broadphase;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    btBoxShape box({0.5f, 0.5f, 0.5f}), floor({10, 1, 10});
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    const auto add = [&](btCollisionShape &shape, const btVector3 &at, btScalar mass) {
        bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, &shape, btVector3(mass, mass, mass)));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        world.addRigidBody(bodies.back().get());
    };
    add(floor, {0, -1, 0}, 0);
    add(box, {0, 2, 0}, 1);
    add(box, {0, std::numeric_limits<btScalar>::quiet_NaN(), 0}, 1);
    for (int step = 0; step < 120; step++) {
        world.stepSimulation(1.0f / 60.0f, 0);
    }
    CHECK(std::fabs(bodies[1]->getWorldTransform().getOrigin().y() - 0.5f) < 0.1f && broadphase.refused_boxes() > 0);
    for (const auto &body : bodies) {
        world.removeRigidBody(body.get());
    }
}

} // namespace

int main(int count, char **) {
    rays_from_threads();
    // With an argument what runs on threads, for ThreadSanitizer.
    if (count == 1) {
        masks_that_allow_later();
        rules_that_change();
        boxes_with_nan();
        a_body_with_nan_in_a_world();
    }
    std::puts("passed");
    return 0;
}
