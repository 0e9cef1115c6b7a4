// CGAL: box_self_intersection_d (streamed segment trees with a cutoff to sweeping).
#define CGAL_LINKED_WITH_TBB
#define CGAL_NDEBUG
#include "peer.h"

#include <CGAL/box_intersection_d.h>
#include <chrono>
#include <memory>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <vector>

namespace
{

// 28 bytes: the algorithm moves boxes about, by value it does so fastest.
struct Box
{
	float min[3], max[3];
	uint32_t id;
};

struct Traits
{
	using Box_parameter = const Box&;
	using NT = float;
	using ID = uint32_t;

	static NT min_coord(Box_parameter box, int axis)
	{
		return box.min[axis];
	}
	static NT max_coord(Box_parameter box, int axis)
	{
		return box.max[axis];
	}
	static ID id(Box_parameter box)
	{
		return box.id;
	}
	static int dimension()
	{
		return 3;
	}
};

class Cgal
{
public:
	// For boxes that are there once: nothing is tried. On uniform cubes this cutoff was the fastest.
	explicit Cgal(uint32_t count)
		: m_limit(tbb::global_control::max_allowed_parallelism, 1), m_threads(1), m_cutoff(100), m_boxes(count)
	{
	}

	explicit Cgal(const Setting& setting)
		: m_limit(tbb::global_control::max_allowed_parallelism, setting.threads), m_threads(setting.threads), m_boxes(setting.count)
	{
		double best = 1e300;
		for (const std::ptrdiff_t cutoff : {10, 25, 50, 100, 200, 400, 800, 1600})
		{
			for (int round = 0; round < 3; round++)
			{
				const auto start = std::chrono::steady_clock::now();
				run(setting.boxes, cutoff);
				const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
				if (time.count() < best)
				{
					best = time.count();
					m_cutoff = cutoff;
				}
			}
		}
	}

	void frame(const PaddedBox* boxes)
	{
		run(boxes, m_cutoff);
	}

	const std::vector<Pair>& pairs() const
	{
		return m_pairs;
	}

private:
	void run(const PaddedBox* boxes, std::ptrdiff_t cutoff)
	{
		for (uint32_t id = 0; id < m_boxes.size(); id++)
		{
			const PaddedBox& b = boxes[id];
			m_boxes[id] = {{b.min[0], b.min[1], b.min[2]}, {b.max[0], b.max[1], b.max[2]}, id};
		}
		m_pairs.clear();
		const auto closed = CGAL::Box_intersection_d::CLOSED;
		if (m_threads == 1)
		{
			const auto add = [this](const Box& a, const Box& b) { m_pairs.push_back({a.id, b.id}); };
			CGAL::box_self_intersection_d<CGAL::Sequential_tag>(m_boxes.begin(), m_boxes.end(), add, Traits(), cutoff, closed);
			return;
		}
		const auto add = [this](const Box& a, const Box& b) { m_parts.local().push_back({a.id, b.id}); };
		CGAL::box_self_intersection_d<CGAL::Parallel_tag>(m_boxes.begin(), m_boxes.end(), add, Traits(), cutoff, closed);
		for (std::vector<Pair>& part : m_parts)
		{
			m_pairs.insert(m_pairs.end(), part.begin(), part.end());
			part.clear();
		}
	}

	tbb::global_control m_limit;
	uint32_t m_threads;
	std::ptrdiff_t m_cutoff = 10;
	std::vector<Box> m_boxes;
	std::vector<Pair> m_pairs;
	tbb::enumerable_thread_specific<std::vector<Pair>> m_parts;
};

} // namespace

extern "C" const Peer cgal_peer = table<Cgal>();

// The pairs of boxes that are there once, kept until the next call.
extern "C" size_t cgal_once(const PaddedBox* boxes, uint32_t count, const Pair** pairs)
{
	static std::unique_ptr<Cgal> once;
	once = std::make_unique<Cgal>(count);
	once->frame(boxes);
	*pairs = once->pairs().data();
	return once->pairs().size();
}
