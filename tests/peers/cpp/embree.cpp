// Embree 3: a scene of one user geometry, collided with itself.
#include "peer.h"

#include <embree3/rtcore.h>
#include <mutex>
#include <string>
#include <vector>

namespace
{

class Embree
{
public:
	explicit Embree(const Setting& setting) : m_threads(setting.threads), m_boxes(setting.boxes)
	{
		m_device = rtcNewDevice(("threads=" + std::to_string(m_threads)).c_str());
		m_scene = rtcNewScene(m_device);
		rtcSetSceneFlags(m_scene, RTC_SCENE_FLAG_DYNAMIC);
		rtcSetSceneBuildQuality(m_scene, RTC_BUILD_QUALITY_LOW);
		m_geometry = rtcNewGeometry(m_device, RTC_GEOMETRY_TYPE_USER);
		// With both at low quality Embree builds along a Morton curve, which is by far its fastest here.
		rtcSetGeometryBuildQuality(m_geometry, RTC_BUILD_QUALITY_LOW);
		rtcSetGeometryUserPrimitiveCount(m_geometry, setting.count);
		rtcSetGeometryUserData(m_geometry, this);
		rtcSetGeometryBoundsFunction(m_geometry, bounds, nullptr);
		rtcCommitGeometry(m_geometry);
		rtcAttachGeometry(m_scene, m_geometry);
	}

	~Embree()
	{
		rtcReleaseGeometry(m_geometry);
		rtcReleaseScene(m_scene);
		rtcReleaseDevice(m_device);
	}

	void frame(const PaddedBox* boxes)
	{
		m_boxes = boxes;
		m_pairs.clear();
		rtcCommitGeometry(m_geometry);
		rtcCommitScene(m_scene);
		rtcCollide(m_scene, m_scene, m_threads > 1 ? collectLocked : collect, this);
	}

	const std::vector<Pair>& pairs() const
	{
		return m_pairs;
	}

private:
	static void bounds(const RTCBoundsFunctionArguments* args)
	{
		const PaddedBox& box = static_cast<Embree*>(args->geometryUserPtr)->m_boxes[args->primID];
		*args->bounds_o = {box.min[0], box.min[1], box.min[2], 0, box.max[0], box.max[1], box.max[2], 0};
	}

	// The primitives of two touching leaves, both ways round: the exact test is the caller's.
	static void collect(void* self, RTCCollision* collisions, unsigned count)
	{
		Embree& e = *static_cast<Embree*>(self);
		for (unsigned i = 0; i < count; i++)
		{
			const unsigned a = collisions[i].primID0, b = collisions[i].primID1;
			if (a < b && overlap(e.m_boxes[a], e.m_boxes[b]))
			{
				e.m_pairs.push_back({a, b});
			}
		}
	}

	static void collectLocked(void* self, RTCCollision* collisions, unsigned count)
	{
		std::lock_guard<std::mutex> guard(static_cast<Embree*>(self)->m_mutex);
		collect(self, collisions, count);
	}

	uint32_t m_threads;
	const PaddedBox* m_boxes;
	RTCDevice m_device;
	RTCScene m_scene;
	RTCGeometry m_geometry;
	std::mutex m_mutex;
	std::vector<Pair> m_pairs;
};

} // namespace

extern "C" const Peer embree_peer = table<Embree>();
