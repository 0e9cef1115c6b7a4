// What a C++ peer exports: one table, named after the peer. The same as `Table` in src/peers/shim.rs.
#pragma once
#include <cstddef>
#include <cstdint>

// Minimum x, y, z, 0, maximum x, y, z, 0.
struct PaddedBox
{
	float min[4];
	float max[4];
};

struct Pair
{
	uint32_t a, b;
};

// What a peer is started with. The same as `CSetting` in src/peers/shim.rs.
struct Setting
{
	// Those of the first frame.
	const PaddedBox* boxes;
	uint32_t count;
	// Who may have another box in later frames.
	const uint32_t* movers;
	uint32_t mover_count;
	uint32_t threads;
};

struct Peer
{
	void* (*start)(const Setting* setting);
	// What an engine does before its broad phase, not timed; may be null.
	void (*prepare)(void* state, const PaddedBox* boxes);
	// One frame: the part that is timed.
	void (*frame)(void* state, const PaddedBox* boxes);
	// The pairs of the last frame, kept until the next one.
	size_t (*pairs)(void* state, const Pair** pairs);
	void (*stop)(void* state);
};

inline bool overlap(const PaddedBox& a, const PaddedBox& b)
{
	return a.min[0] <= b.max[0] && b.min[0] <= a.max[0] && a.min[1] <= b.max[1] && b.min[1] <= a.max[1] &&
		   a.min[2] <= b.max[2] && b.min[2] <= a.max[2];
}

// The prepare(boxes) of a class, if it has one.
template <class T>
constexpr auto prepares(int) -> decltype(&T::prepare, (void (*)(void*, const PaddedBox*))nullptr)
{
	return [](void* state, const PaddedBox* boxes) { static_cast<T*>(state)->prepare(boxes); };
}

template <class T>
constexpr void (*prepares(long))(void*, const PaddedBox*)
{
	return nullptr;
}

// The table of a class with this constructor, frame(boxes) and pairs().
template <class T>
constexpr Peer table()
{
	return {
		[](const Setting* setting) -> void* { return new T(*setting); },
		prepares<T>(0),
		[](void* state, const PaddedBox* boxes) { static_cast<T*>(state)->frame(boxes); },
		[](void* state, const Pair** pairs) {
			const auto& all = static_cast<T*>(state)->pairs();
			*pairs = all.data();
			return all.size();
		},
		[](void* state) { delete static_cast<T*>(state); },
	};
}
