// What trisap.hpp does beyond the C functions: results and conditions that outlive growth, loads that grow, refusals of its own, answers that say busy,
// job systems that worlds follow, and boxes and ids where they stand, also where there are none.

#include "check.h"

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <utility>
#include <vector>

#include <trisap.hpp>

namespace {

trisap::Aabb cube(float x) { return {{x, 0.0f, 0.0f}, {x + 1.0f, 1.0f, 1.0f}}; }

struct Reports {
    Reports() { trisap_set_report(&note, this); }
    ~Reports() { trisap_set_report(nullptr, nullptr); }
    static void note(void *user, trisap_status status, std::uint64_t, const char *) {
        static_cast<Reports *>(user)->count++;
        static_cast<Reports *>(user)->last = status;
    }
    unsigned count = 0;
    trisap_status last = TRISAP_STATUS_OK;
};

trisap::Config small() {
    trisap::Config config = trisap::config(8);
    config.events = config.filters = config.values = 1;
    return config;
}

/// What a game does: debris comes into the world while the contacts that made it are walked over.
void results_outlive_growth() {
    const Reports reports;
    trisap::World world;
    CHECK_OK(world.init(small()));
    world.set_growing(true);
    for (int i = 0; i < 8; i++) {
        CHECK(world.insert(cube(0.75f * static_cast<float>(i))) != trisap::null_id);
    }
    for (int frame = 0; frame < 3; frame++) {
        const trisap::Step step = world.step();
        CHECK(step && (frame > 0 || step.found.size() == 7));
        std::size_t walked = 0;
        for (const auto &[a, b] : step.found) {
            CHECK(a < b && b < world.size());
            // Several growths within one walk.
            for (int i = 0; i < 40; i++) {
                CHECK(world.insert(cube(10.0f + 3.0f * static_cast<float>(world.size()) - 2.2f * static_cast<float>(i % 2))) != trisap::null_id);
            }
            walked++;
        }
        CHECK(walked == step.found.size());
        // By hand, too; and what is asked for anew is the same.
        CHECK_OK(world.move_to(4 * world.size(), 4000));
        const trisap::Step again = world.result();
        CHECK(again.pairs.size() == step.pairs.size());
        for (std::size_t i = 0; i < step.pairs.size(); i++) {
            CHECK(step.pairs[i].a == again.pairs[i].a && step.pairs[i].b == again.pairs[i].b);
        }
        trisap::World moved(std::move(world));
        CHECK(step.pairs.empty() || step.pairs[0].a < step.pairs[0].b);
        world = std::move(moved);
    }
    // Growth is no refusal.
    CHECK(reports.count == 0);
}

void loads_grow() {
    Reports reports;
    trisap::World large, world;
    CHECK_OK(large.init(small()));
    large.set_growing(true);
    for (int i = 0; i < 300; i++) {
        CHECK(large.insert(cube(0.05f * static_cast<float>(i))) != trisap::null_id);
    }
    CHECK_OK(large.step().status);
    std::vector<std::byte> snapshot(large.snapshot_size());
    CHECK(large.save(snapshot));
    CHECK_OK(world.init(small()));
    CHECK_STATUS(world.load(snapshot), TRISAP_STATUS_OBJECTS_FULL);
    CHECK(reports.count == 1 && reports.last == TRISAP_STATUS_OBJECTS_FULL && world.size() == 0);
    world.set_growing(true);
    CHECK_OK(world.load(snapshot));
    CHECK(reports.count == 1 && world.size() == 300 && world.result().pairs.size() == large.result().pairs.size());
    CHECK_OK(world.validate());
}

int allocations_left = 0;

/// What the wrapper refuses is reported, too, and a world that cannot be made, moved or grown leaves the old one.
void refusals() {
    Reports reports;
    trisap::Allocator scarce;
    const auto usual = scarce.allocate;
    static auto *allocate = usual;
    scarce.allocate = [](void *user, std::size_t bytes, std::size_t align) noexcept {
        return allocations_left-- > 0 ? allocate(user, bytes, align) : nullptr;
    };
    trisap::World world(scarce);
    allocations_left = 1;
    CHECK_OK(world.init(small()));
    const trisap::Id id = world.insert(cube(0.0f));
    CHECK_STATUS(world.init(small()), TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK(reports.count == 1 && reports.last == TRISAP_STATUS_MEMORY_TOO_SMALL);
    trisap::Config wrong = small();
    wrong.mode = 9;
    allocations_left = 1;
    CHECK_STATUS(world.init(wrong), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(reports.count == 2 && world.contains(id) && world.size() == 1);
    world.set_growing(true);
    for (int i = 1; i < 8; i++) {
        CHECK(world.insert(cube(2.0f * static_cast<float>(i))) != trisap::null_id);
    }
    trisap::Status why = TRISAP_STATUS_OK;
    CHECK(world.insert(cube(9.0f), &why) == trisap::null_id && why == TRISAP_STATUS_MEMORY_TOO_SMALL);
    CHECK(reports.count == 3 && world.size() == 8);
    trisap::Id one[1];
    CHECK_STATUS(world.insert(trisap::boxes(std::vector<trisap::Aabb>(2, cube(0.0f))), one), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(reports.count == 4 && reports.last == TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK_STATUS(world.aabbs(std::vector<trisap::Id>(2, id), {}), TRISAP_STATUS_INVALID_ARGUMENT);
    CHECK(reports.count == 5);
    // A number that is no status is told as another one.
    trisap_refuse(static_cast<trisap_status>(77), 0);
    CHECK(reports.count == 6 && reports.last == TRISAP_STATUS_OTHER);
    CHECK_STATUS(world.copy_from(trisap::World()), TRISAP_STATUS_NULL_POINTER);
    CHECK(reports.count == 7 && reports.last == TRISAP_STATUS_NULL_POINTER);
}

struct Body {
    trisap::Id id;
    std::uint64_t name;
    float min[3];
    struct {
        float x, y, z, w;
    } max;
};

void where_they_stand() {
    const trisap::Boxes none = trisap::boxes_in(std::vector<Body>(), &Body::min, &Body::max);
    trisap::World world;
    CHECK_OK(world.init(small()));
    CHECK_OK(world.insert(none, {}));
    CHECK(world.step_over(none));
    CHECK_OK(world.update(trisap::ids_in(std::vector<Body>(), &Body::id), none));
    std::vector<Body> bodies(4);
    for (std::size_t i = 0; i < bodies.size(); i++) {
        const float x = 0.75f * static_cast<float>(i);
        bodies[i] = {0, 70 + i, {x, 0, 0}, {x + 1, 1, 1, 9}};
        trisap::Status status = TRISAP_STATUS_OTHER;
        bodies[i].id = world.insert({{x, 0, 0}, {x + 1, 1, 1}}, trisap::groups(1, i == 1 ? 0u : ~0u), bodies[i].name, &status);
        CHECK_OK(status);
        std::uint64_t value = 0;
        trisap::Filter filter{};
        CHECK_OK(world.value(bodies[i].id, value));
        CHECK_OK(world.filter(bodies[i].id, filter));
        CHECK(value == bodies[i].name && filter.group == 1);
    }
    CHECK(world.step_over(trisap::boxes_in(bodies, &Body::min, &Body::max)).pairs.size() == 1);
    for (Body &body : bodies) {
        body.min[0] += 8;
        body.max.x += 8;
    }
    CHECK_OK(world.update(trisap::ids_in(bodies, &Body::id), trisap::boxes_in(bodies, &Body::min, &Body::max)));
    trisap::Aabb aabbs[4];
    CHECK_OK(world.aabbs(trisap::ids_in(bodies, &Body::id), aabbs));
    CHECK(aabbs[0].min[0] == 8.0f && aabbs[3].max[0] == 11.25f);
    // All or none.
    std::swap(bodies[2].min[0], bodies[2].max.x);
    bodies[0].min[0] -= 1;
    const trisap::Boxes bad = trisap::boxes_in(bodies, &Body::min, &Body::max);
    CHECK_STATUS(world.update(trisap::ids_in(bodies, &Body::id), bad), TRISAP_STATUS_BAD_BOX);
    CHECK(world.error_detail() == 2);
    bodies[3].id += 1ull << 32;
    CHECK_STATUS(world.update(trisap::ids_in(bodies, &Body::id), bad), TRISAP_STATUS_BAD_BOX);
    CHECK_STATUS(world.aabbs(trisap::ids_in(bodies, &Body::id), aabbs), TRISAP_STATUS_STALE_ID);
    CHECK(world.error_detail() == bodies[3].id);
    trisap::Aabb kept{};
    CHECK_OK(world.aabb(bodies[0].id, kept));
    CHECK(kept.min[0] == 8.0f);
    CHECK_OK(world.set_resting(bodies[0].id));
    CHECK(world.is_resting(bodies[0].id));
    CHECK_OK(world.wake(bodies[0].id));
    CHECK(!world.is_resting(bodies[0].id));
    // What a world does not have is refused before there is an object.
    trisap::World plain;
    CHECK_OK(plain.init(trisap::config(4)));
    trisap::Status why = TRISAP_STATUS_OK;
    CHECK(plain.insert(cube(0.0f), trisap::filter(), &why) == trisap::null_id && why == TRISAP_STATUS_NO_FILTERS);
    CHECK(plain.insert_value(cube(0.0f), 7, &why) == trisap::null_id && why == TRISAP_STATUS_NO_VALUES);
    CHECK(world.insert(cube(0.0f), trisap::object_class(32), &why) == trisap::null_id && why == TRISAP_STATUS_BAD_CLASS);
    CHECK(plain.size() == 0 && world.size() == 4);
    CHECK(world.insert(cube(0.0f), trisap::groups(1, 1), 0) != trisap::null_id);
}

/// Members of a base class stand as far apart as the items do; and items of a derived class are no view of the base.
void items_that_inherit() {
    struct Thing {
        const trisap::Id id;
        float min[3], max[3];
    };
    struct Car : Thing {
        std::uint64_t wheels;
    };
    static_assert(!std::is_constructible_v<trisap::View<trisap::Hit>, std::vector<trisap::FirstHit> &>);
    static_assert(std::is_constructible_v<trisap::View<const trisap::Hit>, const std::vector<trisap::Hit> &>);
    trisap::World world;
    CHECK_OK(world.init(small()));
    std::vector<Car> cars;
    for (int i = 0; i < 3; i++) {
        const float x = 4.0f * static_cast<float>(i);
        cars.push_back({{world.insert(cube(x)), {x - 3.5f, 0, 0}, {x, 1, 1}}, 4});
    }
    const trisap::Boxes boxes = trisap::boxes_in(cars, &Car::min, &Car::max);
    CHECK_OK(world.update(trisap::ids_in(cars, &Car::id), boxes));
    trisap::Aabb last{};
    CHECK_OK(world.aabb(cars[2].id, last));
    CHECK(last.min[0] == 4.5f && last.max[0] == 8.0f && world.step_over(boxes).pairs.size() == 0);
}

/// A world that another call is inside of says so, and is not taken for an empty one.
void busy() {
    trisap::World world;
    CHECK_OK(world.init(small()));
    const trisap::Id id = world.insert(cube(0.0f));
    CHECK(world.insert(cube(0.5f)) != trisap::null_id);
    CHECK(world.size().status == TRISAP_STATUS_OK && world.size() == 2u && world.contains(id) && world.id_at(0) == id);
    CHECK(world.contains(id + (1ull << 32)).status == TRISAP_STATUS_OK);
    unsigned asked = 0;
    const float origin[3] = {-1, 0.5f, 0.5f}, direction[3] = {1, 0, 0};
    CHECK(world.step_with_rule([&](std::uint32_t, std::uint32_t) {
        asked++;
        const trisap::FirstHit hit = world.first_hit(trisap::ray(origin, direction));
        return world.size().status == TRISAP_STATUS_BUSY && world.contains(id).status == TRISAP_STATUS_BUSY &&
               world.id_at(0).status == TRISAP_STATUS_BUSY && hit.status == TRISAP_STATUS_BUSY && hit.id == trisap::null_id;
    }).pairs.size() == 1);
    CHECK(asked == 1 && world.first_hit(trisap::ray(origin, direction)).status == TRISAP_STATUS_OK);
    // Nor is its memory replaced, or copied while it changes.
    trisap::World other;
    CHECK_OK(other.init(small()));
    std::vector<std::byte> copy(trisap_world_bytes(world.c()));
    unsigned visited = 0;
    const auto visit = [&](trisap::Id) {
        CHECK_STATUS(world.init(small()), TRISAP_STATUS_BUSY);
        CHECK_STATUS(world.open(copy), TRISAP_STATUS_BUSY);
        CHECK_STATUS(world.copy_from(other), TRISAP_STATUS_BUSY);
        CHECK_OK(other.copy_from(world));
        visited++;
    };
    CHECK_OK(world.visit_overlaps(trisap::region(cube(0.0f)), visit));
    CHECK(visited == 2 && world.size() == 2u && other.size() == 2u);
    CHECK(other.step_with_rule([&](std::uint32_t, std::uint32_t) {
        CHECK_STATUS(world.copy_from(other), TRISAP_STATUS_BUSY);
        return true;
    }));
    CHECK_OK(world.copy_from(world));
    CHECK_OK(world.validate());
}

/// Queries with a condition are asked of the world where it is, also after it has grown.
void conditions_outlive_growth() {
    trisap::World world;
    CHECK_OK(world.init(small()));
    world.set_growing(true);
    const auto all = world.among([](trisap::Id) { return true; });
    for (int i = 0; i < 100; i++) {
        CHECK(world.insert(cube(0.0f)) != trisap::null_id);
    }
    CHECK_OK(world.step().status);
    std::vector<trisap::Id> found(100);
    CHECK(all.overlaps(trisap::region(cube(0.0f)), found).size() == 100);
}

/// A world made for one worker follows a job system of four.
void workers_follow() {
    trisap::World world;
    CHECK_OK(world.init(trisap::config(20000)));
    std::vector<trisap::Aabb> aabbs;
    for (int i = 0; i < 20000; i++) {
        const float x = static_cast<float>(i % 27), y = static_cast<float>(i / 27 % 27), z = static_cast<float>(i / 729);
        aabbs.push_back({{x, y, z}, {x + 1.1f, y + 0.4f, z + 0.4f}});
    }
    std::vector<trisap::Id> ids(aabbs.size());
    CHECK_OK(world.insert(trisap::boxes(aabbs), ids));
    std::atomic<unsigned> calls{0};
    auto jobs = trisap::jobs(4, [&](std::uint32_t count, trisap::Task task) {
        for (std::uint32_t i = 0; i < count; i++) {
            calls++;
            task();
        }
    });
    const trisap::Step step = world.step(jobs);
    CHECK(step && step.pairs.size() > 10000 && calls > 1 && world.stats().shared == 1 && world.config().workers == 4);
}

} // namespace

int main() {
    results_outlive_growth();
    loads_grow();
    refusals();
    where_they_stand();
    items_that_inherit();
    busy();
    conditions_outlive_growth();
    workers_follow();
    std::puts("passed");
    return 0;
}
