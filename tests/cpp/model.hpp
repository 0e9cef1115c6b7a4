// A broad phase by brute force, with filters, a rule, resting objects and queries: what trisap is compared with.

#ifndef MODEL_HPP
#define MODEL_HPP

#include "recording.hpp"

#include <cmath>
#include <map>
#include <trisap.hpp>

struct Object {
    trisap::Id id;
    trisap::Aabb box;
    trisap::Filter filter;
    /// For the rule: objects of one temper do not meet.
    unsigned temper;
    bool resting;
};

using IdPair = std::pair<trisap::Id, trisap::Id>;

/// By slot, ascending. Twice the same slots can be there: of objects that are gone and of those in their place.
inline std::vector<SlotPair> by_slot(const std::vector<IdPair> &pairs) {
    std::vector<SlotPair> slots;
    for (const auto &[a, b] : pairs) {
        slots.emplace_back(trisap::slot(a), trisap::slot(b));
    }
    std::sort(slots.begin(), slots.end());
    return slots;
}

inline std::vector<IdPair> difference(const std::vector<IdPair> &first, const std::vector<IdPair> &second) {
    std::vector<IdPair> rest;
    std::set_difference(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(rest));
    return rest;
}

/// The squared distance from a point to a box.
inline double squared_distance(const float *point, const trisap::Aabb &box) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double x = point[k], low = box.min[k], high = box.max[k];
        const double gap = x < low ? low - x : x > high ? x - high : 0.0;
        sum += gap * gap;
    }
    return sum;
}

inline bool meets(const trisap::Region &region, const trisap::Aabb &box) {
    if (region.kind == TRISAP_REGION_SPHERE) {
        return squared_distance(region.min, box) <= double(region.radius) * double(region.radius);
    }
    return share_a_point(region.min, region.max, box.min, box.max);
}

/// Where a cast touches a box first, or a negative number.
inline double touches(const trisap::Cast &cast, const trisap::Aabb &box) {
    double from = 0, to = cast.distance;
    for (int k = 0; k < 3; k++) {
        const double near = double(box.min[k]) - double(cast.start.max[k]);
        const double far = double(box.max[k]) - double(cast.start.min[k]);
        const double direction = cast.direction[k];
        if (direction == 0) {
            if (near > 0 || far < 0) {
                return -1;
            }
            continue;
        }
        const double a = near * (1 / direction), b = far * (1 / direction);
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return from <= to ? from : -1;
}

struct Model {
    std::map<std::uint32_t, Object> objects;
    std::uint32_t classes[TRISAP_CLASSES];
    bool has_filters = false;
    bool has_rule = false;
    /// As the last complete step reported them, ascending.
    std::vector<IdPair> reported;

    Model() { std::fill(std::begin(classes), std::end(classes), ~0u); }

    bool rule(std::uint32_t a, std::uint32_t b) const { return objects.at(a).temper != objects.at(b).temper; }

    bool filters_meet(const Object &a, const Object &b) const {
        const bool groups = (a.filter.group & b.filter.mask) != 0 && (b.filter.group & a.filter.mask) != 0;
        const bool matrix = (classes[a.filter.object_class] >> b.filter.object_class & 1) != 0 &&
                            (classes[b.filter.object_class] >> a.filter.object_class & 1) != 0;
        return !has_filters || (groups && matrix);
    }

    bool wanted(const Object &a, const Object &b) const {
        return filters_meet(a, b) && (!has_rule || rule(trisap::slot(a.id), trisap::slot(b.id)));
    }

    std::vector<IdPair> pairs() const {
        std::vector<const Object *> all;
        for (const auto &[slot, object] : objects) {
            all.push_back(&object);
        }
        std::vector<IdPair> pairs;
        for (auto a = all.begin(); a != all.end(); ++a) {
            const trisap::Aabb &first = (*a)->box;
            for (auto b = std::next(a); b != all.end(); ++b) {
                const trisap::Aabb &second = (*b)->box;
                if (share_a_point(first.min, first.max, second.min, second.max) && wanted(**a, **b)) {
                    pairs.emplace_back((*a)->id, (*b)->id);
                }
            }
        }
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    }

    /// By ascending slot.
    std::vector<trisap::Id> overlaps(const trisap::Region &region) const {
        std::vector<trisap::Id> ids;
        for (const auto &[slot, object] : objects) {
            if (meets(region, object.box)) {
                ids.push_back(object.id);
            }
        }
        return ids;
    }

    /// The nearest first, equally near ones by ascending slot.
    std::vector<trisap::Hit> hits(const trisap::Cast &cast) const {
        std::vector<trisap::Hit> hits;
        for (const auto &[slot, object] : objects) {
            const double distance = touches(cast, object.box);
            if (distance >= 0) {
                hits.push_back({object.id, distance});
            }
        }
        return in_order(std::move(hits));
    }

    std::vector<trisap::Hit> nearest(const float *point, std::size_t most) const {
        std::vector<trisap::Hit> hits;
        for (const auto &[slot, object] : objects) {
            hits.push_back({object.id, squared_distance(point, object.box)});
        }
        hits = in_order(std::move(hits));
        hits.resize(std::min(hits.size(), most));
        for (trisap::Hit &hit : hits) {
            hit.distance = std::sqrt(hit.distance);
        }
        return hits;
    }

private:
    static std::vector<trisap::Hit> in_order(std::vector<trisap::Hit> hits) {
        // They come by ascending slot.
        std::stable_sort(hits.begin(), hits.end(),
                         [](const trisap::Hit &a, const trisap::Hit &b) { return a.distance < b.distance; });
        return hits;
    }
};

template <class A, class B> bool same_hits(const A &a, const B &b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const trisap::Hit &x, const trisap::Hit &y) {
        return x.id == y.id && x.distance == y.distance;
    });
}

template <class A, class B> bool same(const A &a, const B &b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); }

#endif
