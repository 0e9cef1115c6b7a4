// Bullet: btDbvtBroadphase with deferred collision and its hashed pair cache. The boxes in its tree carry its
// margin, and stale pairs are cleaned up a share a frame: the pairs are a superset.
#include "peer.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <vector>

namespace
{

class Bullet
{
public:
	explicit Bullet(const Setting& setting) : m_movers(setting.movers, setting.movers + setting.mover_count)
	{
		m_broadphase.m_deferedcollide = true;
		m_broadphase.setVelocityPrediction(0);
		// Optimises one in a hundred leaves a frame; more costs more than it gains.
		m_broadphase.m_dupdates = 1;
		for (uint32_t id = 0; id < setting.count; id++)
		{
			const PaddedBox& b = setting.boxes[id];
			m_proxies.push_back(m_broadphase.createProxy(low(b), high(b), 0, nullptr, 1, 1, nullptr));
			m_proxies[id]->m_clientObject = reinterpret_cast<void*>(uintptr_t(id));
		}
		m_broadphase.optimize();
	}

	~Bullet()
	{
		for (btBroadphaseProxy* proxy : m_proxies)
		{
			m_broadphase.destroyProxy(proxy, nullptr);
		}
	}

	void frame(const PaddedBox* boxes)
	{
		for (const uint32_t id : m_movers)
		{
			m_broadphase.setAabb(m_proxies[id], low(boxes[id]), high(boxes[id]), nullptr);
		}
		m_broadphase.calculateOverlappingPairs(nullptr);
	}

	// Copied here, outside the timing: a caller would walk the cache itself.
	const std::vector<Pair>& pairs()
	{
		m_pairs.clear();
		const btBroadphasePairArray& all = m_broadphase.getOverlappingPairCache()->getOverlappingPairArray();
		for (int i = 0; i < all.size(); i++)
		{
			m_pairs.push_back({id(all[i].m_pProxy0), id(all[i].m_pProxy1)});
		}
		return m_pairs;
	}

private:
	static btVector3 low(const PaddedBox& b)
	{
		return btVector3(b.min[0], b.min[1], b.min[2]);
	}
	static btVector3 high(const PaddedBox& b)
	{
		return btVector3(b.max[0], b.max[1], b.max[2]);
	}
	static uint32_t id(const btBroadphaseProxy* proxy)
	{
		return uint32_t(reinterpret_cast<uintptr_t>(proxy->m_clientObject));
	}

	btDbvtBroadphase m_broadphase;
	std::vector<btBroadphaseProxy*> m_proxies;
	std::vector<uint32_t> m_movers;
	std::vector<Pair> m_pairs;
};

} // namespace

extern "C" const Peer bullet_peer = table<Bullet>();
