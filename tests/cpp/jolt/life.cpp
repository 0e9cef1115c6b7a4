// Bodies of three layers come, go, change their layer and their kind, sleep and wake in a Jolt world, and queries of all kinds are asked
// between its steps. Built with the shadow, which compares each answer; here is only counted that there are some.

#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Geometry/OrientedBox.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/AABoxCast.h>
#include <Jolt/Physics/Collision/CastResult.h>
#include <Jolt/Physics/Collision/CollisionCollectorImpl.h>
#include <Jolt/Physics/Collision/RayCast.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>
#include <cstdio>
#include <cstdlib>
#include <random>

using namespace JPH;

// Walls, things, and ghosts that meet walls alone.
enum : ObjectLayer { walls, things, ghosts };

struct Layers final : BroadPhaseLayerInterface, ObjectVsBroadPhaseLayerFilter, ObjectLayerPairFilter {
    uint GetNumBroadPhaseLayers() const override { return 2; }
    BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer layer) const override { return BroadPhaseLayer(layer == walls ? 0 : 1); }
    bool ShouldCollide(ObjectLayer layer, BroadPhaseLayer other) const override { return layer != walls || other != BroadPhaseLayer(0); }
    bool ShouldCollide(ObjectLayer a, ObjectLayer b) const override {
        return a == walls ? b != walls : a == things ? b != ghosts : b == walls;
    }
};

int main() {
    RegisterDefaultAllocator();
    Factory::sInstance = new Factory();
    RegisterTypes();
    std::size_t answers = 0, bodies_at_most = 0;
    {
        const Layers layers;
        TempAllocatorImpl memory(32 << 20);
        JobSystemThreadPool jobs(cMaxPhysicsJobs, cMaxPhysicsBarriers, 2);
        PhysicsSystem world;
        world.Init(4096, 0, 65536, 20480, layers, layers, layers);
        BodyInterface &interface = world.GetBodyInterface();
        std::mt19937 random(1);
        const auto below = [&](unsigned end) { return static_cast<unsigned>(random() % end); };
        const auto within = [&](float half) { return (float(below(20001)) / 10000.0f - 1) * half; };
        const auto place = [&](float half) { return Vec3(within(half), 5 + within(5), within(half)); };
        interface.CreateAndAddBody(BodyCreationSettings(new BoxShape(Vec3(60, 1, 60)), RVec3(0, -1, 0), Quat::sIdentity(), EMotionType::Static, walls),
                                   EActivation::DontActivate);
        BodyIDVector bodies;
        const auto come = [&] {
            const Vec3 half(0.3f + float(below(10)) / 20, 0.3f + float(below(10)) / 20, 0.3f + float(below(10)) / 20);
            const ObjectLayer layer = below(8) == 0 ? walls : below(5) == 0 ? ghosts : things;
            BodyCreationSettings settings(new BoxShape(half), RVec3(place(16)), Quat::sIdentity(), layer == walls ? EMotionType::Static : EMotionType::Dynamic, layer);
            settings.mAllowDynamicOrKinematic = true;
            settings.mMotionQuality = below(4) == 0 ? EMotionQuality::LinearCast : EMotionQuality::Discrete;
            bodies.push_back(interface.CreateAndAddBody(settings, EActivation::Activate));
        };
        for (int step = 0; step < 240; step++) {
            // Beyond the 1,024 that there is room for at first.
            for (int i = 0; i < 12 && bodies.size() < 1500; i++) {
                come();
            }
            for (int i = 0; i < 4; i++) {
                const unsigned at = below(unsigned(bodies.size()));
                interface.RemoveBody(bodies[at]);
                interface.DestroyBody(bodies[at]);
                bodies[at] = bodies.back();
                bodies.pop_back();
                const BodyID body = bodies[below(unsigned(bodies.size()))];
                switch (below(5)) {
                case 0:
                    if (interface.GetMotionType(body) != EMotionType::Static) {
                        interface.SetObjectLayer(body, below(2) == 0 ? things : ghosts);
                    }
                    break;
                case 1: // without a change of its layer
                    if (interface.GetObjectLayer(body) == things) {
                        const bool moves = interface.GetMotionType(body) == EMotionType::Dynamic;
                        interface.SetMotionType(body, moves ? EMotionType::Static : EMotionType::Dynamic, moves ? EActivation::DontActivate : EActivation::Activate);
                    }
                    break;
                case 2: interface.SetPosition(body, RVec3(place(16)), EActivation::Activate); break;
                case 3: interface.DeactivateBody(body); break;
                default: interface.SetLinearVelocity(body, 20 * place(1)); break;
                }
            }
            bodies_at_most = std::max(bodies_at_most, bodies.size());
            if (world.Update(1.0f / 60, 1 + step % 2, &memory, &jobs) != EPhysicsUpdateError::None) {
                std::fprintf(stderr, "Jolt has not enough room\n");
                return 1;
            }
            const BroadPhaseQuery &query = world.GetBroadPhaseQuery();
            for (int i = 0; i < 4; i++) {
                AllHitCollisionCollector<RayCastBodyCollector> rays;
                ClosestHitCollisionCollector<RayCastBodyCollector> first;
                AllHitCollisionCollector<CastShapeBodyCollector> casts;
                AllHitCollisionCollector<CollideShapeBodyCollector> overlaps;
                const SpecifiedObjectLayerFilter only(below(2) == 0 ? things : ghosts);
                const RayCast ray{place(20), 20 * place(1)};
                const Vec3 at = place(16), half(1 + within(1), 1 + within(1), 1 + within(1));
                query.CastRay(ray, rays, {}, only);
                query.CastRay(ray, first);
                query.CastAABox({AABox(at - half, at + half), Vec3(within(9), within(9), within(9))}, casts);
                query.CollideAABox(AABox(at - half, at + half), overlaps, SpecifiedBroadPhaseLayerFilter(BroadPhaseLayer(1)));
                query.CollideSphere(at, 2 + within(2), overlaps);
                query.CollidePoint(at, overlaps);
                query.CollideOrientedBox(OrientedBox(Mat44::sRotationTranslation(Quat::sRotation(Vec3::sAxisX(), within(3)), at), half), overlaps);
                answers += rays.mHits.size() + first.HadHit() + casts.mHits.size() + overlaps.mHits.size();
            }
        }
    }
    std::printf("%zu answers, %zu bodies at most\n", answers, bodies_at_most);
    UnregisterTypes();
    delete Factory::sInstance;
    return answers > 1000 && bodies_at_most > 1024 ? 0 : 1;
}
