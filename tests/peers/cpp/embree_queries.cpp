// Embree 3 as a user asks it: boxes as user geometry, the nearest box on a ray, the boxes that overlap a box.
#include "peer.h"

#include <algorithm>
#include <cmath>
#include <embree3/rtcore.h>
#include <limits>

namespace
{

struct Boxes
{
	const PaddedBox* boxes;
	RTCDevice device;
	RTCScene scene;
};

void bounds(const RTCBoundsFunctionArguments* args)
{
	const PaddedBox& box = static_cast<Boxes*>(args->geometryUserPtr)->boxes[args->primID];
	*args->bounds_o = {box.min[0], box.min[1], box.min[2], 0, box.max[0], box.max[1], box.max[2], 0};
}

void intersect(const RTCIntersectFunctionNArguments* args)
{
	if (!args->valid[0])
	{
		return;
	}
	const PaddedBox& box = static_cast<Boxes*>(args->geometryUserPtr)->boxes[args->primID];
	auto* hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
	const float origin[3] = {hit->ray.org_x, hit->ray.org_y, hit->ray.org_z};
	const float direction[3] = {hit->ray.dir_x, hit->ray.dir_y, hit->ray.dir_z};
	float from = 0, to = hit->ray.tfar;
	for (int k = 0; k < 3; k++)
	{
		const float a = (box.min[k] - origin[k]) / direction[k], b = (box.max[k] - origin[k]) / direction[k];
		from = std::max(from, std::min(a, b));
		to = std::min(to, std::max(a, b));
	}
	if (from <= to)
	{
		hit->ray.tfar = from;
		hit->hit.geomID = args->geomID;
		hit->hit.primID = args->primID;
	}
}

struct Asked
{
	const Boxes* boxes;
	PaddedBox region;
	uint32_t count;
};

bool touch(RTCPointQueryFunctionArguments* args)
{
	auto* asked = static_cast<Asked*>(args->userPtr);
	asked->count += overlap(asked->boxes->boxes[args->primID], asked->region);
	return false;
}

} // namespace

extern "C" void* embree_queries_start(const PaddedBox* boxes, uint32_t count)
{
	auto* state = new Boxes{boxes, rtcNewDevice("threads=1"), nullptr};
	state->scene = rtcNewScene(state->device);
	rtcSetSceneBuildQuality(state->scene, RTC_BUILD_QUALITY_HIGH);
	const RTCGeometry geometry = rtcNewGeometry(state->device, RTC_GEOMETRY_TYPE_USER);
	rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
	rtcSetGeometryUserPrimitiveCount(geometry, count);
	rtcSetGeometryUserData(geometry, state);
	rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
	rtcSetGeometryIntersectFunction(geometry, intersect);
	rtcCommitGeometry(geometry);
	rtcAttachGeometry(state->scene, geometry);
	rtcReleaseGeometry(geometry);
	rtcCommitScene(state->scene);
	return state;
}

// The distance to the nearest box, or infinity.
extern "C" float embree_queries_ray(void* state, const float* origin, const float* direction)
{
	RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	RTCRayHit hit = {};
	hit.ray.org_x = origin[0], hit.ray.org_y = origin[1], hit.ray.org_z = origin[2];
	hit.ray.dir_x = direction[0], hit.ray.dir_y = direction[1], hit.ray.dir_z = direction[2];
	hit.ray.tfar = std::numeric_limits<float>::infinity();
	hit.ray.mask = ~0u;
	hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
	rtcIntersect1(static_cast<Boxes*>(state)->scene, &context, &hit);
	return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<float>::infinity() : hit.ray.tfar;
}

// How many boxes overlap a box: those that Embree finds in the ball around it, tested.
extern "C" uint32_t embree_queries_box(void* state, const PaddedBox* region)
{
	Asked asked = {static_cast<Boxes*>(state), *region, 0};
	const auto half = [&](int k) { return 0.5f * (region->max[k] - region->min[k]); };
	RTCPointQuery query = {};
	query.x = region->min[0] + half(0), query.y = region->min[1] + half(1), query.z = region->min[2] + half(2);
	query.radius = 1.0001f * std::sqrt(half(0) * half(0) + half(1) * half(1) + half(2) * half(2));
	RTCPointQueryContext context;
	rtcInitPointQueryContext(&context);
	rtcPointQuery(asked.boxes->scene, &query, &context, touch, &asked);
	return asked.count;
}

extern "C" void embree_queries_stop(void* state)
{
	auto* boxes = static_cast<Boxes*>(state);
	rtcReleaseScene(boxes->scene);
	rtcReleaseDevice(boxes->device);
	delete boxes;
}
