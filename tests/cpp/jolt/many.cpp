// Many moving bodies, which hardly touch, in a Jolt world: `many BODIES THREADS STEPS` prints the processor time of a step. Built with
// Jolt's own broad phase and with trisap.

#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

using namespace JPH;

struct Layers final : BroadPhaseLayerInterface, ObjectVsBroadPhaseLayerFilter, ObjectLayerPairFilter {
    uint GetNumBroadPhaseLayers() const override { return 1; }
    BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer) const override { return BroadPhaseLayer(0); }
    bool ShouldCollide(ObjectLayer, BroadPhaseLayer) const override { return true; }
    bool ShouldCollide(ObjectLayer, ObjectLayer) const override { return true; }
};

static double processor_time() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

int main(int count, char **arguments) {
    if (count != 4) {
        std::fputs("usage: many BODIES THREADS STEPS\n", stderr);
        return 2;
    }
    const int bodies = std::atoi(arguments[1]), threads = std::atoi(arguments[2]), steps = std::atoi(arguments[3]);
    RegisterDefaultAllocator();
    Factory::sInstance = new Factory();
    RegisterTypes();
    const Layers layers;
    TempAllocatorImpl memory(256 << 20);
    JobSystemThreadPool jobs(cMaxPhysicsJobs, cMaxPhysicsBarriers, threads - 1);
    PhysicsSystem world;
    world.Init(65536, 0, 262144, 65536, layers, layers, layers);
    world.SetGravity(Vec3::sZero());
    std::mt19937 random(1);
    const auto within = [&](float half) { return (float(random() % 20001) / 10000.0f - 1) * half; };
    const auto place = [&](float half) { return Vec3(within(half), within(half), within(half)); };
    const RefConst<Shape> box = new BoxShape(Vec3(0.5f, 0.5f, 0.5f));
    BodyInterface &interface = world.GetBodyInterface();
    BodyIDVector ids;
    for (int i = 0; i < bodies; i++) {
        BodyCreationSettings settings(box, RVec3(place(1.6f * std::cbrt(float(bodies)))), Quat::sIdentity(), EMotionType::Dynamic, 0);
        settings.mLinearVelocity = place(5);
        settings.mLinearDamping = 0;
        settings.mAllowSleeping = false;
        ids.push_back(interface.CreateBody(settings)->GetID());
    }
    BodyInterface::AddState state = interface.AddBodiesPrepare(ids.data(), bodies);
    interface.AddBodiesFinalize(ids.data(), bodies, state, EActivation::Activate);
    std::vector<double> times;
    for (int i = 0; i < steps; i++) {
        const double start = processor_time();
        world.Update(1.0f / 60, 1, &memory, &jobs);
        times.push_back(processor_time() - start);
    }
    std::sort(times.begin(), times.end());
    std::printf("%d bodies, %d threads: %.2f ms of processor time a step\n", bodies, threads, times[times.size() / 2]);
}
