// What the bytes of a sequence mean, as tests/src/sequence says: the same draws in the same order.

#ifndef SEQUENCE_HPP
#define SEQUENCE_HPP

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <trisap.hpp>
#include <vector>

using Bytes = std::vector<std::uint8_t>;

/// SplitMix64.
class Rng {
public:
    explicit Rng(std::uint64_t seed) : state_(seed) {}

    std::uint64_t bits() {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    std::uint32_t below(std::size_t end) { return static_cast<std::uint32_t>(bits() % end); }
    bool once_in(std::uint32_t times) { return below(times) == 0; }

private:
    std::uint64_t state_;
};

enum class Kind : std::uint8_t {
    insert, insert_many, set, update_many, remove, remove_many, set_margin, set_filter, set_classes, refilter,
    set_resting, wake, shift, step, step_over, overlaps, cast, nearest, batches, view, save, load, load_damaged,
    load_forged, reopen, copy, clear, grow, set_filter_many, set_value, set_value_many, set_enabled,
};

constexpr std::size_t kinds = static_cast<std::size_t>(Kind::set_enabled) + 1;

struct Operation {
    Kind kind;
    std::uint32_t argument;
    Rng rng;

    explicit Operation(const std::uint8_t *bytes)
        : kind(of(bytes[0])), argument(bytes[1]), rng(bytes[2] | static_cast<unsigned>(bytes[3]) << 8) {
        if (kind == Kind::reopen && argument % 2 == 0) {
            kind = Kind::copy;
        }
        if (kind == Kind::remove_many && argument % 8 == 7) {
            kind = Kind::clear;
        }
        if (kind == Kind::set_filter && argument % 4 == 3) {
            kind = Kind::set_filter_many;
        }
        if (kind == Kind::set && argument % 4 == 3) {
            kind = Kind::set_value;
        }
        if (kind == Kind::update_many && argument % 8 == 7) {
            kind = Kind::set_value_many;
        }
        if ((kind == Kind::set_resting || kind == Kind::wake) && argument % 2 == 1) {
            kind = Kind::set_enabled;
        }
    }

    static constexpr std::size_t size = 4;

private:
    static Kind of(std::uint8_t byte) {
        static constexpr Kind often[] = {
            Kind::step, Kind::step, Kind::step, Kind::step, Kind::step, Kind::step, Kind::step, Kind::step,
            Kind::step_over, Kind::step_over, Kind::step_over, Kind::step_over, Kind::insert, Kind::insert,
            Kind::insert_many, Kind::set, Kind::set, Kind::set, Kind::update_many, Kind::update_many, Kind::remove,
            Kind::remove, Kind::remove_many, Kind::set_margin, Kind::set_filter, Kind::set_classes, Kind::refilter,
            Kind::set_resting, Kind::wake, Kind::shift, Kind::overlaps, Kind::cast, Kind::nearest, Kind::batches,
            Kind::view, Kind::save, Kind::load, Kind::load_damaged, Kind::load_forged, Kind::reopen,
            Kind::grow,
        };
        return often[byte % (sizeof often / sizeof *often)];
    }
};

/// What the world is like, and the boxes, regions and filters that it draws.
class Header {
public:
    static constexpr std::size_t size = 8;

    explicit Header(const std::uint8_t *bytes) { std::memcpy(bytes_, bytes, size); }

    [[nodiscard]] std::uint32_t objects() const {
        static constexpr std::uint32_t all[] = {3, 9, 24, 40, 64, 70, 140, 700};
        return all[bytes_[0] % 8];
    }

    [[nodiscard]] bool rule() const { return flag(1) && flag(2); }

    [[nodiscard]] std::uint32_t start() const { return objects() * bytes_[7] / 255; }

    /// As the twin's in Rust: with several workers.
    [[nodiscard]] trisap::Config config() const {
        trisap::Config config = trisap::config(objects());
        set_capacity(config, bytes_[3]);
        config.mode = flag(4) ? TRISAP_MODE_FAT : TRISAP_MODE_EXACT;
        config.has_margin = flag(3);
        if (flag(3)) {
            config.margin_per_extent = 0.125f;
            config.margin_min = 0.03125f;
            config.margin_max = 1.0f;
        }
        config.events = flag(0);
        config.filters = flag(1);
        config.values = (bytes_[4] & 4u) != 0;
        config.lean = flag(5) && objects() <= 256;
        config.workers = 2 + bytes_[4] % 4u;
        config.fixed_margins = flag(6);
        config.predicted_boxes = bytes_[4] >> 3 & 1u;
        return config;
    }

    /// What a world of some configuration becomes when it grows, or shrinks.
    [[nodiscard]] trisap::Config grown(trisap::Config config, std::uint32_t argument) const {
        const std::uint32_t sizes[] = {std::max(objects() / 2, 2u), objects(), objects() + 7, 2 * objects()};
        config.objects = sizes[argument % 4];
        set_capacity(config, argument / 4);
        config.lean = flag(5) && config.objects <= 256;
        return config;
    }

    trisap::Aabb aabb(Rng &rng) const {
        const std::uint32_t kind = rng.below(40);
        trisap::Aabb aabb = {};
        for (std::uint32_t axis = 0; axis < 3; axis++) {
            const std::uint32_t low = axis == bytes_[6] % 8u ? 0 : rng.below(steps());
            const std::uint32_t edge = kind < 3 ? rng.below(steps()) : kind == 3 ? 0 : rng.below(5);
            aabb.min[axis] = on_lattice(low);
            aabb.max[axis] = on_lattice(low + edge);
        }
        const unsigned style = bytes_[6] / 8u % 4;
        if (style == 2) {
            float by[3];
            for (float &part : by) {
                part = static_cast<float>(rng.below(4096)) * (0.25f / 4096.0f);
            }
            for (int axis = 0; axis < 3; axis++) {
                aabb.min[axis] += by[axis];
                aabb.max[axis] += by[axis];
            }
        } else if (style == 3) {
            const float scale = static_cast<float>(1u << rng.below(12)) / 64.0f;
            for (int axis = 0; axis < 3; axis++) {
                aabb.min[axis] *= scale;
                aabb.max[axis] *= scale;
            }
        }
        if (kind == 4) {
            const std::uint32_t axis = rng.below(3);
            const float infinity = std::numeric_limits<float>::infinity(), most = std::numeric_limits<float>::max();
            const float ends[] = {-infinity, -most, -0.0f, 0.0f, std::numeric_limits<float>::denorm_min(), most, infinity};
            const std::uint32_t low = rng.below(7);
            aabb.min[axis] = ends[low];
            aabb.max[axis] = ends[low + rng.below(7 - low)];
        }
        return aabb;
    }

    /// A box in `double`, seen from an origin.
    trisap::Aabb from_f64(Rng &rng) const {
        const trisap::Aabb box = aabb(rng);
        double min[3], max[3], origin[3];
        for (double &part : origin) {
            part = static_cast<double>(static_cast<int>(rng.below(2001)) - 1000) * 0.1;
        }
        for (int axis = 0; axis < 3; axis++) {
            min[axis] = static_cast<double>(box.min[axis]) + origin[axis];
            max[axis] = static_cast<double>(box.max[axis]) + origin[axis];
        }
        return trisap_aabb_from_f64(min, max, origin);
    }

    /// A box in fixed point: on the lattice, or with more bits than a float has.
    trisap::Aabb from_fixed(Rng &rng) const {
        const std::uint32_t all[] = {2, 10, 26};
        const std::uint32_t bits = all[rng.below(3)];
        const std::int32_t unit = std::int32_t{1} << (bits - 2);
        std::int32_t min[3], max[3];
        for (int axis = 0; axis < 3; axis++) {
            const std::int32_t low = (static_cast<std::int32_t>(rng.below(steps())) - 8) * unit;
            min[axis] = low + static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(unit)));
            max[axis] = min[axis] + static_cast<std::int32_t>(rng.below(5)) * unit;
        }
        return trisap_aabb_from_fixed(min, max, bits);
    }

    trisap::Aabb moved(trisap::Aabb box, std::uint32_t argument, Rng &rng) const {
        const std::uint32_t motion = argument / 8 % 4;
        if (motion == 2) {
            return aabb(rng);
        }
        if (motion == 3) {
            for (float &max : box.max) {
                max += static_cast<float>(rng.below(3)) * 0.25f;
            }
            return box;
        }
        const int reach = motion == 0 ? 3 : 13;
        const float step = motion == 0 ? 0.015625f : 0.25f;
        float by[3];
        for (float &part : by) {
            part = static_cast<float>(static_cast<int>(rng.below(static_cast<std::uint32_t>(reach))) - reach / 2) * step;
        }
        for (int axis = 0; axis < 3; axis++) {
            box.min[axis] += by[axis];
            box.max[axis] += by[axis];
        }
        return box;
    }

    static trisap::Aabb bad_box(Rng &rng) {
        const std::uint32_t axis = rng.below(3);
        trisap::Aabb bad = {{0, 0, 0}, {1, 1, 1}};
        if (rng.once_in(2)) {
            bad.min[axis] = 2;
        } else {
            bad.max[axis] = std::numeric_limits<float>::quiet_NaN();
        }
        return bad;
    }

    static trisap::Filter filter(Rng &rng) {
        trisap::Filter filter = trisap::filter();
        filter.group = rng.once_in(2) ? ~0u : 1u << rng.below(3);
        filter.mask = rng.once_in(2) ? ~0u : 1u << rng.below(3);
        filter.object_class = rng.once_in(32) ? 32 : rng.below(3);
        return filter;
    }

    void point(Rng &rng, float (&point)[3]) const {
        for (float &x : point) {
            x = on_lattice(rng.below(steps()));
        }
    }

    trisap::Region region(Rng &rng) const {
        float place[3];
        switch (rng.below(4)) {
        case 0:
            point(rng, place);
            return trisap::point(place);
        case 1: {
            point(rng, place);
            const std::uint32_t radius = rng.below(9);
            return trisap::sphere(place, static_cast<float>(radius) * 0.25f);
        }
        default:
            return trisap::region(rng.once_in(16) ? bad_box(rng) : aabb(rng));
        }
    }

    trisap::Cast cast(Rng &rng) const {
        trisap::Cast cast = {};
        point(rng, cast.start.min);
        const float edge = rng.once_in(2) ? static_cast<float>(rng.below(5)) * 0.25f : 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            cast.start.max[axis] = cast.start.min[axis] + edge;
        }
        for (float &part : cast.direction) {
            part = static_cast<float>(static_cast<int>(rng.below(7)) - 3) * 0.5f;
        }
        const std::uint32_t kind = rng.below(32);
        cast.distance = kind == 0  ? -1.0f
                        : kind < 8 ? std::numeric_limits<float>::infinity()
                                   : static_cast<float>(rng.below(33)) * 0.25f;
        if (std::memcmp(cast.start.min, cast.start.max, sizeof cast.start.min) == 0) {
            return trisap_cast_ray(cast.start.min, cast.direction, cast.distance);
        }
        return cast.distance == 1.0f ? trisap_cast_swept(&cast.start, cast.direction) : cast;
    }

private:
    [[nodiscard]] bool flag(unsigned bit) const { return (bytes_[1] >> bit & 1u) != 0; }
    [[nodiscard]] std::uint32_t steps() const { return 3 + bytes_[5] % 64u; }

    static void set_capacity(trisap::Config &config, unsigned choice) {
        const std::uint32_t objects = config.objects;
        const std::uint32_t leaf_refs[] = {objects / 2, 0, objects / 8, 2 * objects};
        const std::uint32_t few = choice < 192 ? objects / 2 : 0;
        const std::uint32_t pairs[] = {8 * objects, objects * objects / 2, few, 2 * objects};
        config.leaf_refs = leaf_refs[choice % 4];
        config.pairs = pairs[choice / 4 % 4];
    }

    static float on_lattice(std::uint32_t steps) { return static_cast<float>(static_cast<int>(steps) - 8) * 0.25f; }

    std::uint8_t bytes_[size];
};

inline std::uint64_t word(const std::uint8_t *bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

inline std::uint64_t mix(std::uint64_t sum, std::uint64_t word) {
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
    return sum << 29 | sum >> 35;
}

/// Makes length and checksum of a snapshot right.
inline void seal(Bytes &snapshot) {
    constexpr std::size_t header = 24;
    const std::uint8_t *body = snapshot.data() + header;
    const std::uint64_t length = snapshot.size() - header;
    std::uint64_t sums[] = {1, 2, 3, 4}, sum = length;
    for (std::size_t at = 0; at < length / 32 * 4; at++) {
        sums[at % 4] = mix(sums[at % 4], word(body + 8 * at));
    }
    for (std::size_t at = length / 32 * 32; at < length; at++) {
        sum = mix(sum, body[at]);
    }
    for (const std::uint64_t part : sums) {
        sum = mix(sum, part);
    }
    std::memcpy(snapshot.data() + 8, &length, sizeof length);
    std::memcpy(snapshot.data() + 16, &sum, sizeof sum);
}

/// Changes some numbers of a snapshot, most of them near the front, and seals it.
inline void forge(Bytes &snapshot, std::size_t front, Rng &rng) {
    constexpr std::size_t header = 24;
    for (std::uint32_t left = 1 + rng.below(3); left > 0; left--) {
        const std::size_t reach = rng.once_in(2) ? std::min(snapshot.size(), front) : snapshot.size();
        const std::size_t at = header + rng.below((reach - header) / 2 - 4) * std::size_t{2};
        std::uint32_t old = 0;
        std::memcpy(&old, snapshot.data() + at, sizeof old);
        switch (rng.below(8)) {
        case 0: old = 0; break;
        case 1: old = ~0u; break;
        case 2: old += 1; break;
        case 3: old -= 1; break;
        case 4: old ^= 1u << rng.below(32); break;
        case 5: old = rng.below(1000); break;
        case 6: old = 0x7fffffff; break;
        default: old = static_cast<std::uint32_t>(rng.bits());
        }
        std::memcpy(snapshot.data() + at, &old, sizeof old);
    }
    if (rng.once_in(20)) {
        snapshot.resize(header + rng.below(snapshot.size() - header));
    }
    seal(snapshot);
}

#endif
