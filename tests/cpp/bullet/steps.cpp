// Whole steps of btDiscreteDynamicsWorld with Bullet's DBVT, its axis sweep and trisap: processor time of the step, of its broad phase,
// and of that of handing over boxes. `steps [SCENE] [BODIES ...]`; all scenes, and 2,000, 8,000 and 20,000 bodies, if none are given.
// In the scene "raining" bodies come in each counted step, and the worlds grow meanwhile.
//
// The broad phases take turns, step by step, each with a world of its own. That all hand over the same pairs is what simulate.cpp
// looks at: here the order of pairs differs, so piles come to rest in other ways, and what is printed beside the times says how
// much work the rest of the step had.

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <algorithm>
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <trisap_bullet.hpp>
#include <vector>

/// The processor time that this thread has had, in milliseconds.
static double now() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}

class World final : public btDiscreteDynamicsWorld {
public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

    void performDiscreteCollisionDetection() override {
        const double start = now();
        updateAabbs();
        boxes_time = now() - start;
        computeOverlappingPairs();
        broadphase_time = now() - start;
        getDispatcher()->dispatchAllCollisionPairs(getPairCache(), getDispatchInfo(), getDispatcher());
    }

    double boxes_time = 0, broadphase_time = 0;
};

enum class Scene { falling, piled, resting, raining };

class Simulation {
public:
    Simulation(const char *called, Scene scene, int count) : name(called), dispatcher_(&configuration_), box_({0.5f, 0.5f, 0.5f}) {
        if (name[0] == 'D') {
            broadphase_ = std::make_unique<btDbvtBroadphase>(&pairs_);
        } else if (name[0] == 'a') {
            const auto handles = static_cast<unsigned>(count + 64);
            broadphase_ = std::make_unique<bt32BitAxisSweep3>(btVector3(-500, -500, -500), btVector3(500, 2000, 500), handles, &pairs_);
        } else {
            broadphase_ = std::make_unique<trisap::BulletBroadphase>(1024u, &pairs_);
        }
        world_ = std::make_unique<World>(&dispatcher_, broadphase_.get(), &solver_, &configuration_);
        world_->setGravity({0, -9.81f, 0});
        add(floor_, {0, -50, 0}, 0);
        const int side = std::max(4, static_cast<int>(std::cbrt(count / (scene == Scene::falling ? 1.0 : 2.0))));
        // Apart in the air; a loose pile that settles; or on the ground, each on its own.
        const btScalar gap = scene == Scene::falling ? 2.0f : 1.1f;
        const int flat = static_cast<int>(std::sqrt(double(count)));
        for (int i = 0; i < count && scene != Scene::raining; i++) {
            const int row = scene == Scene::resting ? flat : side;
            const btScalar jitter = 0.05f * btScalar(i % 7);
            btVector3 at(btScalar(i % row) * gap + jitter, btScalar(i / row / row) * gap + 0.6f, btScalar(i / row % row) * gap + jitter);
            if (scene == Scene::resting) {
                at = {btScalar(i % row) * 1.5f, 0.5f, btScalar(i / row) * 1.5f};
            } else if (scene == Scene::falling) {
                at += btVector3(0, 400, 0);
            }
            add(box_, at - btVector3(btScalar(row) / 2, 0, btScalar(row) / 2), 1).setDamping(0.1f, 0.1f);
        }
    }

    ~Simulation() {
        for (const auto &body : bodies_) {
            world_->removeRigidBody(body.get());
        }
    }

    /// So many bodies more, a layer above the others; the time counts for the next step.
    void rain(int more) {
        const double start = now();
        const int row = static_cast<int>(std::ceil(std::sqrt(double(more))));
        const btScalar height = 10 + 1.1f * btScalar(layers_++);
        for (int i = 0; i < more; i++) {
            const btScalar jitter = 0.05f * btScalar((i + layers_) % 7);
            add(box_, {(btScalar(i % row) - btScalar(row) / 2) * 1.3f + jitter, height, (btScalar(i / row) - btScalar(row) / 2) * 1.3f + jitter}, 1)
                .setDamping(0.1f, 0.1f);
        }
        rained_ = now() - start;
    }

    void step(bool counted) {
        const double start = now();
        world_->stepSimulation(1.0f / 60.0f, 0);
        if (counted) {
            steps.push_back(now() - start + rained_);
            broadphases.push_back(world_->broadphase_time);
            boxes.push_back(world_->boxes_time);
        }
    }

    int asleep() const {
        return static_cast<int>(std::count_if(bodies_.begin(), bodies_.end(), [](const auto &body) { return !body->isActive(); }));
    }
    int pairs() { return pairs_.getNumOverlappingPairs(); }
    int touching() {
        int touching = 0;
        for (int i = 0; i < dispatcher_.getNumManifolds(); i++) {
            touching += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts() > 0;
        }
        return touching;
    }

    const char *name;
    std::vector<double> steps, broadphases, boxes;

private:
    btRigidBody &add(btBoxShape &shape, const btVector3 &at, btScalar mass) {
        btVector3 inertia(0, 0, 0);
        if (mass > 0) {
            shape.calculateLocalInertia(mass, inertia);
        }
        bodies_.push_back(std::make_unique<btRigidBody>(mass, nullptr, &shape, inertia));
        bodies_.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        world_->addRigidBody(bodies_.back().get());
        return *bodies_.back();
    }

    int layers_ = 0;
    double rained_ = 0;
    btHashedOverlappingPairCache pairs_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btSequentialImpulseConstraintSolver solver_;
    btBoxShape box_, floor_{{400, 50, 400}};
    std::unique_ptr<btBroadphaseInterface> broadphase_;
    std::unique_ptr<World> world_;
    std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

static double median(std::vector<double> times) {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

int main(int count, char **arguments) {
    std::vector<int> sizes;
    std::string only;
    for (int i = 1; i < count; i++) {
        const int size = std::atoi(arguments[i]);
        size > 0 ? sizes.push_back(size) : void(only = arguments[i]);
    }
    if (sizes.empty()) {
        sizes = {2000, 8000, 20000};
    }
    const struct {
        const char *name;
        Scene scene;
        int before, steps;
    } scenes[] = {{"falling", Scene::falling, 10, 60}, {"piled", Scene::piled, 60, 60}, {"resting", Scene::resting, 150, 60}, {"raining", Scene::raining, 0, 60}};
    std::printf("| scene | bodies | broad phase | step, ms | broad phase, ms | of it boxes, ms | slowest step, ms | pairs | touching | asleep |\n");
    std::printf("|---|---:|---|---:|---:|---:|---:|---:|---:|---:|\n");
    for (const int size : sizes) {
        for (const auto &[name, scene, before, steps] : scenes) {
            if (!only.empty() && only != name) {
                continue;
            }
            Simulation simulations[3] = {{"DBVT", scene, size}, {"axis sweep", scene, size}, {"trisap", scene, size}};
            for (int step = 0; step < before + steps; step++) {
                for (Simulation &simulation : simulations) {
                    if (scene == Scene::raining) {
                        simulation.rain(size / steps);
                    }
                    simulation.step(step >= before);
                }
            }
            for (Simulation &its : simulations) {
                std::printf("| %s | %d | %s | %.2f | %.2f | %.2f | %.2f | %d | %d | %d |\n", name, size, its.name, median(its.steps),
                            median(its.broadphases), median(its.boxes), *std::max_element(its.steps.begin(), its.steps.end()),
                            its.pairs(), its.touching(), its.asleep());
            }
            std::fflush(stdout);
        }
    }
    return 0;
}
