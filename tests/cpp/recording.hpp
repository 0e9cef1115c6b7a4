// Recordings (`.aabbs`) and brute force, independent of trisap.

#ifndef RECORDING_HPP
#define RECORDING_HPP

#include "check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

/// A box with padded corners, as recordings have it.
struct PaddedBox {
    float min[4], max[4];
};
static_assert(sizeof(PaddedBox) == 32);

struct Recording {
    std::vector<std::vector<PaddedBox>> frames;
};

inline Recording read_recording(const std::string &path) {
    constexpr std::size_t header = 2 * 128 + 4 * 4 + 2 * 16;
    std::ifstream file(path, std::ios::binary);
    CHECK(file.good());
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    CHECK(bytes.size() >= header);
    std::int32_t objects = 0, steps = 0;
    std::memcpy(&objects, bytes.data() + 256, 4);
    std::memcpy(&steps, bytes.data() + 260, 4);
    CHECK(objects > 0 && steps > 0);
    const auto count = static_cast<std::size_t>(objects), frames = static_cast<std::size_t>(steps) + 1;
    CHECK(bytes.size() == header + frames * count * sizeof(PaddedBox));
    Recording recording;
    for (std::size_t i = 0; i < frames; i++) {
        std::vector<PaddedBox> &frame = recording.frames.emplace_back(count);
        std::memcpy(frame.data(), bytes.data() + header + i * count * sizeof(PaddedBox), count * sizeof(PaddedBox));
    }
    return recording;
}

using SlotPair = std::pair<std::uint32_t, std::uint32_t>;

/// Whether the closed boxes share a point.
inline bool share_a_point(const float *a_min, const float *a_max, const float *b_min, const float *b_max) {
    bool touch = true;
    for (int k = 0; k < 3; k++) {
        touch &= a_min[k] <= b_max[k];
        touch &= b_min[k] <= a_max[k];
    }
    return touch;
}

/// All against all, ascending.
inline std::vector<SlotPair> brute_force(const std::vector<PaddedBox> &boxes) {
    std::vector<SlotPair> pairs;
    for (std::uint32_t a = 0; a < boxes.size(); a++) {
        for (std::uint32_t b = a + 1; b < boxes.size(); b++) {
            if (share_a_point(boxes[a].min, boxes[a].max, boxes[b].min, boxes[b].max)) {
                pairs.emplace_back(a, b);
            }
        }
    }
    return pairs;
}

/// The pairs of any range of them, ascending.
template <class Pairs> std::vector<SlotPair> sorted(const Pairs &pairs) {
    std::vector<SlotPair> list;
    for (const auto &[a, b] : pairs) {
        list.emplace_back(a, b);
    }
    std::sort(list.begin(), list.end());
    return list;
}

/// What is in the first list and not in the second; both are ascending.
inline std::vector<SlotPair> without(const std::vector<SlotPair> &first, const std::vector<SlotPair> &second) {
    std::vector<SlotPair> rest;
    std::set_difference(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(rest));
    return rest;
}

#endif
