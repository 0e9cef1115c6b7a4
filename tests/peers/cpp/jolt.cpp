// Jolt: its quad tree broad phase over bodies that are all dynamic and active.
#include <Jolt/Jolt.h>

#include "peer.h"

#include <Jolt/Core/Factory.h>
#include <Jolt/Physics/Body/Body.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Body/BodyManager.h>
#include <Jolt/Physics/Body/BodyPair.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseQuadTree.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/RegisterTypes.h>
#include <vector>

using namespace JPH;

namespace
{

// Jolt asks a shape for its box in the world; this one has been told.
class Told : public Shape
{
public:
	Told() : Shape(EShapeType::User1, EShapeSubType::User1)
	{
	}
	AABox GetWorldSpaceBounds(Mat44Arg, Vec3Arg) const override
	{
		return m_box;
	}
	AABox GetLocalBounds() const override
	{
		return m_box;
	}

	AABox m_box{Vec3::sZero(), Vec3::sReplicate(1)};

	// What a broad phase has no use for.
	uint GetSubShapeIDBitsRecursive() const override
	{
		return 0;
	}
	float GetInnerRadius() const override
	{
		return 1;
	}
	MassProperties GetMassProperties() const override
	{
		MassProperties mass;
		mass.SetMassAndInertiaOfSolidBox(Vec3::sReplicate(1), 1);
		return mass;
	}
	const PhysicsMaterial* GetMaterial(const SubShapeID&) const override
	{
		return nullptr;
	}
	Vec3 GetSurfaceNormal(const SubShapeID&, Vec3Arg) const override
	{
		return Vec3::sAxisX();
	}
	void GetSubmergedVolume(Mat44Arg, Vec3Arg, const Plane&, float&, float&, Vec3&) const override
	{
	}
	bool CastRay(const RayCast&, const SubShapeIDCreator&, RayCastResult&) const override
	{
		return false;
	}
	void CastRay(const RayCast&, const RayCastSettings&, const SubShapeIDCreator&, CastRayCollector&,
		const ShapeFilter&) const override
	{
	}
	void CollidePoint(Vec3Arg, const SubShapeIDCreator&, CollidePointCollector&, const ShapeFilter&) const override
	{
	}
	void CollideSoftBodyVertices(Mat44Arg, Vec3Arg, SoftBodyVertex*, uint, float, Vec3Arg, int) const override
	{
	}
	void GetTrianglesStart(GetTrianglesContext&, const AABox&, Vec3Arg, QuatArg, Vec3Arg) const override
	{
	}
	int GetTrianglesNext(GetTrianglesContext&, int, Float3*, const PhysicsMaterial**) const override
	{
		return 0;
	}
	Stats GetStats() const override
	{
		return Stats(sizeof(*this), 0);
	}
	float GetVolume() const override
	{
		return 1;
	}
};

// One layer for all.
class Layers : public BroadPhaseLayerInterface, public ObjectVsBroadPhaseLayerFilter, public ObjectLayerPairFilter
{
public:
	uint GetNumBroadPhaseLayers() const override
	{
		return 1;
	}
	BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer) const override
	{
		return BroadPhaseLayer(0);
	}
};

class Collector : public BodyPairCollector
{
public:
	void AddHit(const BodyPair& pair) override
	{
		m_pairs.push_back({pair.mBodyA.GetIndex(), pair.mBodyB.GetIndex()});
	}

	std::vector<Pair> m_pairs;
};

void startJolt()
{
	static const bool once = [] {
		RegisterDefaultAllocator();
		Factory::sInstance = new Factory();
		RegisterTypes();
		return true;
	}();
	(void)once;
}

class Jolt
{
public:
	explicit Jolt(const Setting& setting) : m_movers(setting.movers, setting.movers + setting.mover_count)
	{
		const uint32_t count = setting.count;
		startJolt();
		m_bodies = new BodyManager();
		m_bodies->Init(count, 0, m_layers);
		m_broadphase = new BroadPhaseQuadTree();
		m_broadphase->Init(m_bodies, m_layers);
		for (uint32_t id = 0; id < count; id++)
		{
			m_shapes.push_back(new Told());
			tell(id, setting.boxes[id]);
			Body* body = m_bodies->AllocateBody(
				BodyCreationSettings(m_shapes[id], RVec3::sZero(), Quat::sIdentity(), EMotionType::Dynamic, 0));
			m_bodies->AddBody(body);
			m_ids.push_back(body->GetID());
		}
		for (const uint32_t id : m_movers)
		{
			m_active.push_back(m_ids[id]);
		}
		std::vector<BodyID> added = m_ids;
		m_broadphase->AddBodiesFinalize(added.data(), int(count), m_broadphase->AddBodiesPrepare(added.data(), int(count)));
		m_broadphase->Optimize();
		std::vector<BodyID> active = m_active;
		m_bodies->ActivateBodies(active.data(), int(active.size()));
	}

	~Jolt()
	{
		delete m_broadphase;
		m_bodies->DeactivateBodies(m_ids.data(), int(m_ids.size()));
		m_bodies->DestroyBodies(m_ids.data(), int(m_ids.size()));
		delete m_bodies;
	}

	// In an engine the integration of the bodies does this.
	void prepare(const PaddedBox* boxes)
	{
		for (const uint32_t id : m_movers)
		{
			tell(id, boxes[id]);
			m_bodies->GetBody(m_ids[id]).CalculateWorldSpaceBoundsInternal();
		}
	}

	void frame(const PaddedBox*)
	{
		const int count = int(m_active.size());
		m_collector.m_pairs.clear();
		m_broadphase->NotifyBodiesAABBChanged(m_active.data(), count, true);
		m_broadphase->FrameSync();
		m_broadphase->LockModifications();
		const BroadPhase::UpdateState update = m_broadphase->UpdatePrepare();
		m_broadphase->UpdateFinalize(update);
		m_broadphase->FindCollidingPairs(m_active.data(), count, 0.0f, m_layers, m_layers, m_collector);
		m_broadphase->UnlockModifications();
	}

	const std::vector<Pair>& pairs() const
	{
		return m_collector.m_pairs;
	}

private:
	void tell(uint32_t id, const PaddedBox& b)
	{
		m_shapes[id]->m_box = AABox(Vec3(b.min[0], b.min[1], b.min[2]), Vec3(b.max[0], b.max[1], b.max[2]));
	}

	Layers m_layers;
	BodyManager* m_bodies;
	BroadPhaseQuadTree* m_broadphase;
	std::vector<Ref<Told>> m_shapes;
	std::vector<BodyID> m_ids;
	std::vector<uint32_t> m_movers;
	// Those of the movers, in an order that Jolt may change.
	std::vector<BodyID> m_active;
	Collector m_collector;
};

} // namespace

extern "C" const Peer jolt_peer = table<Jolt>();
