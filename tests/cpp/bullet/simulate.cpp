// Bullet simulates four scenes on trisap and on its own btDbvtBroadphase.
//
// In each scene either works while the other is told the same: after every step, both hand the same overlapping pairs to the
// narrow phase, in every tenth step compared with brute force; trisap hands over nothing else. A narrow phase of its own for each finds the same
// contacts, point by point. Then each works alone but in the pile, and the time of the broad phase is printed.

#include "mirror.hpp"

#include <array>
#include <btBulletDynamicsCommon.h>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <trisap_bullet.hpp>

using Seconds = std::chrono::duration<double>;

/// A world that measures the broad phase of each step, and looks at its pairs before the narrow phase does.
class World final : public btDiscreteDynamicsWorld {
public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

    void performDiscreteCollisionDetection() override {
        const auto start = std::chrono::steady_clock::now();
        updateAabbs();
        computeOverlappingPairs();
        broadphase_time += std::chrono::steady_clock::now() - start;
        if (auto *mirror = dynamic_cast<Mirror *>(getBroadphase())) {
            inspect(*mirror);
        }
        getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
        if (auto *mirror = dynamic_cast<Mirror *>(getBroadphase())) {
            btOverlappingPairCache *pairs = mirror->other().getOverlappingPairCache();
            other_dispatcher->dispatchAllCollisionPairs(pairs, getDispatchInfo(), other_dispatcher);
            const std::vector<Contact> expected = contacts_of(*getDispatcher());
            CHECK(contacts_of(*other_dispatcher) == expected);
            contacts += expected.size();
        }
    }

    Seconds broadphase_time{};
    std::size_t steps = 0, overlapping = 0, contacts = 0, surplus_of_trisap = 0, surplus_of_bullet = 0;
    /// For the pairs of the broad phase that does not work. Its contacts do not get to the solver.
    btDispatcher *other_dispatcher = nullptr;

private:
    /// Two bodies, where they touch, and how deep.
    using Contact = std::array<btScalar, 6>;

    static std::vector<Contact> contacts_of(btDispatcher &dispatcher) {
        std::vector<Contact> contacts;
        const auto name = [](const btCollisionObject &object) { return static_cast<btScalar>(object.getUserIndex()); };
        for (int i = 0; i < dispatcher.getNumManifolds(); i++) {
            const btPersistentManifold &manifold = *dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold.getNumContacts(); k++) {
                const btManifoldPoint &point = manifold.getContactPoint(k);
                const btVector3 &at = point.getPositionWorldOnB();
                contacts.push_back({name(*manifold.getBody0()), name(*manifold.getBody1()), at.x(), at.y(), at.z(), point.getDistance()});
            }
        }
        std::sort(contacts.begin(), contacts.end());
        return contacts;
    }

    void inspect(Mirror &mirror) {
        const HandedOver working = handed_over(mirror.working()), other = handed_over(mirror.other());
        CHECK(working.overlapping == other.overlapping);
        // Brute force takes as long as all the rest.
        if (steps % 10 == 0) {
            CHECK(working.overlapping == by_brute_force());
        }
        const bool trisap_works = dynamic_cast<trisap::BulletBroadphase *>(&mirror.working()) != nullptr;
        surplus_of_trisap += trisap_works ? working.surplus : other.surplus;
        surplus_of_bullet += trisap_works ? other.surplus : working.surplus;
        overlapping += working.overlapping.size();
        steps++;
    }

    std::vector<SlotPair> by_brute_force() {
        std::vector<SlotPair> expected;
        const btCollisionObjectArray &objects = getCollisionObjectArray();
        for (int i = 0; i < objects.size(); i++) {
            const btBroadphaseProxy &a = *objects[i]->getBroadphaseHandle();
            for (int j = i + 1; j < objects.size(); j++) {
                const btBroadphaseProxy &b = *objects[j]->getBroadphaseHandle();
                const bool wanted = (a.m_collisionFilterGroup & b.m_collisionFilterMask) != 0 &&
                                    (b.m_collisionFilterGroup & a.m_collisionFilterMask) != 0;
                if (wanted && overlap(a, b)) {
                    expected.emplace_back(std::min(name_of(a), name_of(b)), std::max(name_of(a), name_of(b)));
                }
            }
        }
        std::sort(expected.begin(), expected.end());
        return expected;
    }
};

/// A simulation and all that Bullet wants to be kept alive for it.
class Simulation {
public:
    explicit Simulation(btBroadphaseInterface &broadphase)
        : dispatcher_(&configuration_), other_dispatcher_(&configuration_),
          world(&dispatcher_, &broadphase, &solver_, &configuration_) {
        world.other_dispatcher = &other_dispatcher_;
        world.setGravity({0, -9.81f, 0});
    }

    ~Simulation() {
        while (!bodies.empty()) {
            remove(bodies.size() - 1);
        }
    }

    btRigidBody &add(const btVector3 &half, const btVector3 &at, btScalar mass) {
        auto shape = std::make_unique<btBoxShape>(half);
        btVector3 inertia(0, 0, 0);
        if (mass > 0) {
            shape->calculateLocalInertia(mass, inertia);
        }
        auto body = std::make_unique<btRigidBody>(mass, nullptr, shape.get(), inertia);
        body->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        body->setUserIndex(next_name_++);
        world.addRigidBody(body.get());
        bodies.push_back(std::move(body));
        shapes_.push_back(std::move(shape));
        return *bodies.back();
    }

    void remove(std::size_t index) {
        world.removeRigidBody(bodies[index].get());
        std::swap(bodies[index], bodies.back());
        std::swap(shapes_[index], shapes_.back());
        bodies.pop_back();
        shapes_.pop_back();
    }

    void step() { world.stepSimulation(1.0f / 60.0f, 0); }

    /// How fast moving bodies are, the slowest first.
    std::vector<btScalar> speeds() const {
        std::vector<btScalar> speeds;
        for (const auto &body : bodies) {
            if (!body->isStaticObject()) {
                speeds.push_back(body->isActive() ? body->getLinearVelocity().length() : 0);
            }
        }
        std::sort(speeds.begin(), speeds.end());
        return speeds;
    }

    /// A floor and four walls around a square.
    void add_box(btScalar half) {
        add({half + 1, 0.5f, half + 1}, {0, -0.5f, 0}, 0);
        for (const btScalar side : {-1.0f, 1.0f}) {
            add({0.5f, 40, half + 1}, {side * (half + 0.5f), 40, 0}, 0);
            add({half + 1, 40, 0.5f}, {0, 40, side * (half + 0.5f)}, 0);
        }
    }

private:
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_, other_dispatcher_;
    btSequentialImpulseConstraintSolver solver_;
    std::vector<std::unique_ptr<btBoxShape>> shapes_;
    int next_name_ = 0;

public:
    World world;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
};

/// A pile of 2,000 boxes falls into a walled box.
static void pile(Simulation &simulation) {
    simulation.add_box(8);
    std::mt19937 random(1);
    const auto jitter = [&random] { return static_cast<btScalar>(random() % 100) / 500.0f; };
    for (int i = 0; i < 2000; i++) {
        const btVector3 place(btScalar(i % 12), btScalar(i / 144), btScalar(i / 12 % 12));
        const btVector3 at = place * 1.25f + btVector3(jitter() - 7.0f, 0.6f + jitter(), jitter() - 7.0f);
        simulation.add({0.5f, 0.5f, 0.5f}, at, 1).setDamping(0.2f, 0.2f);
    }
    for (int step = 0; step < 300; step++) {
        simulation.step();
    }
    const std::vector<btScalar> speeds = simulation.speeds();
    const btScalar median = speeds[speeds.size() / 2], slow = speeds[speeds.size() * 95 / 100];
    std::printf("    at the end: median speed %.4f, 95th percentile %.4f, fastest %.4f\n", median, slow, speeds.back());
    CHECK(speeds.size() == 2000 && median < 0.1f && slow < 0.5f);
    for (const auto &body : simulation.bodies) {
        const btVector3 &at = body->getWorldTransform().getOrigin();
        CHECK(body->isStaticObject() || (at.y() > 0 && std::fabs(at.x()) < 8 && std::fabs(at.z()) < 8));
    }
}

/// Stacks of boxes stand.
static void stack(Simulation &simulation) {
    simulation.add({50, 0.5f, 50}, {0, -0.5f, 0}, 0);
    for (int tower = 0; tower < 16; tower++) {
        for (int level = 0; level < 12; level++) {
            const btVector3 at(btScalar(tower % 4) * 2.5f, 0.5f + btScalar(level), btScalar(tower / 4) * 2.5f);
            simulation.add({0.5f, 0.5f, 0.5f}, at, 1);
        }
    }
    for (int step = 0; step < 300; step++) {
        simulation.step();
    }
    const btScalar fastest = simulation.speeds().back();
    btScalar highest = 0;
    for (const auto &body : simulation.bodies) {
        highest = std::max(highest, body->getWorldTransform().getOrigin().y());
    }
    std::printf("    at the end: fastest %.4f, top at %.3f\n", fastest, highest);
    CHECK(fastest < 0.05f && std::fabs(highest - 11.5f) < 0.1f);
}

/// Boxes rain, 40 in each of 50 steps: the world grows from 64 to 2,000 bodies while it steps.
static void rain(Simulation &simulation) {
    simulation.add_box(8);
    std::mt19937 random(3);
    const auto within = [&random](btScalar half) {
        return (static_cast<btScalar>(random() % 10000) / 5000.0f - 1) * half;
    };
    for (int step = 0; step < 100; step++) {
        for (int i = 0; i < 40 && step < 50; i++) {
            const btVector3 at(btScalar(i % 8) * 1.8f - 6.3f, 6 + 1.2f * btScalar(step), btScalar(i / 8) * 3.0f - 6);
            simulation.add({0.5f, 0.5f, 0.5f}, at + btVector3(within(0.3f), within(0.3f), within(0.9f)), 1);
        }
        simulation.step();
    }
    CHECK(simulation.bodies.size() == 2005);
}

/// 500 bodies, of which some are removed and others added while rays and boxes ask for them.
static void rays_and_removals(Simulation &simulation) {
    simulation.add_box(8);
    std::mt19937 random(2);
    const auto within = [&random](btScalar half) {
        return (static_cast<btScalar>(random() % 10000) / 5000.0f - 1) * half;
    };
    const auto drop = [&] {
        const btVector3 half(0.4f + within(0.2f), 0.4f + within(0.2f), 0.4f + within(0.2f));
        simulation.add(half, {within(7), 10 + within(9), within(7)}, 1);
    };
    for (int i = 0; i < 500; i++) {
        drop();
    }
    struct Count final : btBroadphaseAabbCallback {
        bool process(const btBroadphaseProxy *) override { return ++count, true; }
        std::size_t count = 0;
    } in_boxes;
    std::size_t hits = 0;
    for (int step = 0; step < 300; step++) {
        simulation.step();
        for (int i = 0; i < 8; i++) {
            const btVector3 from(within(9), 30, within(9)), to(within(9), -3, within(9));
            btCollisionWorld::ClosestRayResultCallback closest(from, to);
            simulation.world.rayTest(from, to, closest);
            hits += closest.hasHit() && !closest.m_collisionObject->isStaticObject();
            const btVector3 at(within(8), 5 + within(5), within(8));
            simulation.world.getBroadphase()->aabbTest(at, at + btVector3(2, 2, 2), in_boxes);
        }
        // Several at once, so that slots are used again before the next step.
        for (int i = 0; i < 3 && step % 3 == 0; i++) {
            simulation.remove(5 + random() % (simulation.bodies.size() - 5));
            drop();
        }
    }
    std::printf("    rays that hit a body: %zu of 2400, objects met by boxes: %zu\n", hits, in_boxes.count);
    CHECK(hits > 1000 && in_boxes.count > 100);
    btVector3 low, high;
    simulation.world.getBroadphase()->getBroadphaseAabb(low, high);
    CHECK(low.x() <= -8 && high.y() >= 80);
}

using Scene = void (*)(Simulation &);

static std::size_t steps_of(Scene scene) { return scene == rain ? 100 : 300; }

static void compare(const char *name, Scene scene) {
    for (const bool trisap_works : {true, false}) {
        trisap::BulletBroadphase ours(64); // grows
        btDbvtBroadphase dbvt;
        std::printf("%s: %s works\n", name, trisap_works ? "trisap" : "btDbvtBroadphase");
        Mirror mirror(trisap_works ? static_cast<btBroadphaseInterface &>(ours) : dbvt,
                      trisap_works ? static_cast<btBroadphaseInterface &>(dbvt) : ours);
        Simulation simulation(mirror);
        scene(simulation);
        const World &world = simulation.world;
        CHECK(world.steps == steps_of(scene) && world.overlapping > world.steps && world.surplus_of_trisap == 0);
        CHECK(world.contacts > world.steps);
        CHECK(scene != rays_and_removals || (mirror.rays_met > 0 && mirror.boxes_met > 0));
        std::printf("    %zu steps, %zu overlapping pairs handed over by both, %zu contact points; surplus: trisap %zu, btDbvtBroadphase %zu\n",
                    world.steps, world.overlapping, world.contacts, world.surplus_of_trisap, world.surplus_of_bullet);
    }
}

static void measure(const char *name, Scene scene) {
    const auto alone = [&](btBroadphaseInterface &broadphase) {
        Simulation simulation(broadphase);
        scene(simulation);
        return simulation.world.broadphase_time.count() * 1e3 / static_cast<double>(steps_of(scene));
    };
    trisap::BulletBroadphase ours(64); // grows
    btDbvtBroadphase dbvt;
    const double trisap_time = alone(ours), dbvt_time = alone(dbvt);
    std::printf("%s: broad phase a step: trisap %.3f ms, btDbvtBroadphase %.3f ms\n", name, trisap_time, dbvt_time);
    btVector3 low, high;
    ours.getBroadphaseAabb(low, high);
    CHECK(low == high);
    ours.resetPool(nullptr);
    ours.printStats();
}

int main() {
    const struct {
        const char *name;
        Scene scene;
    } scenes[] = {{"pile", pile}, {"stack", stack}, {"rain", rain}, {"rays and removals", rays_and_removals}};
    for (const auto &[name, scene] : scenes) {
        compare(name, scene);
        if (scene != pile) { // steps.cpp does
            measure(name, scene);
        }
        std::fflush(stdout);
    }
    return 0;
}
