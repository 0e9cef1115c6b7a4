// Box3D: its dynamic tree and pair set, driven as its broad phase drives them in a step (that one needs a whole
// world of bodies and shapes): boxes that leave their margin are enlarged, those query the tree, new pairs go into
// the pair set, the changed part of the tree is rebuilt, and pairs whose fat boxes have parted are dropped.
#include "peer.h"

#include "box3d/collision.h"
#include <algorithm>
#include <cmath>
#include <vector>

extern "C"
{
#include "table.h"
}

namespace
{

class Box3d
{
public:
	explicit Box3d(const Setting& setting)
		: m_tree(b3DynamicTree_Create(int(setting.count))), m_set(b3CreateSet(int(4 * setting.count))),
		  m_movers(setting.movers, setting.movers + setting.mover_count), m_moved(setting.count)
	{
		for (uint32_t id = 0; id < setting.count; id++)
		{
			const b3AABB box = tight(setting.boxes[id]);
			// As Box3D computes it for a shape: a share of the radius, up to five centimetres.
			const float x = box.upperBound.x - box.lowerBound.x, y = box.upperBound.y - box.lowerBound.y,
						z = box.upperBound.z - box.lowerBound.z;
			m_margins.push_back(
				std::min(B3_MAX_AABB_MARGIN, B3_AABB_MARGIN_FRACTION * 0.5f * std::sqrt(x * x + y * y + z * z)));
			m_fat.push_back(fatten(box, m_margins[id]));
			m_proxies.push_back(b3DynamicTree_CreateProxy(&m_tree, m_fat[id], B3_DEFAULT_CATEGORY_BITS, id));
			m_queue.push_back(id);
			m_moved[id] = true;
		}
		b3DynamicTree_Rebuild(&m_tree, true);
	}

	~Box3d()
	{
		b3DestroySet(&m_set);
		b3DynamicTree_Destroy(&m_tree);
	}

	// Box3D looks at the contacts of bodies that are awake alone: the pairs of all others are taken out.
	void prepare(const PaddedBox*)
	{
		if (m_pairs.empty() || m_movers.size() == m_fat.size() || !m_resting.empty())
		{
			return;
		}
		std::vector<char> awake(m_fat.size());
		for (const uint32_t id : m_movers)
		{
			awake[id] = true;
		}
		const auto rest = std::partition(m_pairs.begin(), m_pairs.end(),
			[&](const Pair& pair) { return awake[pair.a] || awake[pair.b]; });
		m_resting.assign(rest, m_pairs.end());
		m_pairs.erase(rest, m_pairs.end());
	}

	void frame(const PaddedBox* boxes)
	{
		for (const uint32_t id : m_movers)
		{
			const b3AABB box = tight(boxes[id]);
			if (!b3AABB_Contains(m_fat[id], box))
			{
				m_fat[id] = fatten(box, m_margins[id]);
				b3DynamicTree_EnlargeProxy(&m_tree, m_proxies[id], m_fat[id]);
				if (!m_moved[id])
				{
					m_moved[id] = true;
					m_queue.push_back(id);
				}
			}
		}
		for (const uint32_t id : m_queue)
		{
			m_query = id;
			b3DynamicTree_Query(&m_tree, m_fat[id], B3_DEFAULT_MASK_BITS, false, collect, this);
		}
		b3DynamicTree_Rebuild(&m_tree, false);
		for (const uint32_t id : m_queue)
		{
			m_moved[id] = false;
		}
		m_queue.clear();
		for (size_t i = 0; i < m_pairs.size();)
		{
			const Pair pair = m_pairs[i];
			if (b3AABB_Overlaps(m_fat[pair.a], m_fat[pair.b]))
			{
				i++;
				continue;
			}
			b3RemoveKey(&m_set, b3ShapePairKey(int(pair.a), int(pair.b), 0));
			m_pairs[i] = m_pairs.back();
			m_pairs.pop_back();
		}
	}

	const std::vector<Pair>& pairs()
	{
		if (m_resting.empty())
		{
			return m_pairs;
		}
		m_all = m_resting;
		m_all.insert(m_all.end(), m_pairs.begin(), m_pairs.end());
		return m_all;
	}

private:
	static b3AABB tight(const PaddedBox& b)
	{
		return {{b.min[0], b.min[1], b.min[2]}, {b.max[0], b.max[1], b.max[2]}};
	}

	static b3AABB fatten(const b3AABB& b, float by)
	{
		return {{b.lowerBound.x - by, b.lowerBound.y - by, b.lowerBound.z - by},
				{b.upperBound.x + by, b.upperBound.y + by, b.upperBound.z + by}};
	}

	static bool collect(int, uint64_t other, void* context)
	{
		Box3d& self = *static_cast<Box3d*>(context);
		const uint32_t a = uint32_t(other), b = self.m_query;
		// Two that have moved find each other twice.
		if (a == b || (a < b && self.m_moved[a]))
		{
			return true;
		}
		if (!b3AddKey(&self.m_set, b3ShapePairKey(int(a), int(b), 0)))
		{
			self.m_pairs.push_back({a, b});
		}
		return true;
	}

	b3DynamicTree m_tree;
	b3HashSet m_set;
	std::vector<uint32_t> m_movers;
	std::vector<char> m_moved;
	std::vector<float> m_margins;
	std::vector<b3AABB> m_fat;
	std::vector<int> m_proxies;
	std::vector<uint32_t> m_queue;
	uint32_t m_query = 0;
	std::vector<Pair> m_pairs;
	std::vector<Pair> m_resting;
	std::vector<Pair> m_all;
};

} // namespace

extern "C" const Peer box3d_peer = table<Box3d>();
