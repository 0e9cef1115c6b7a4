// Job systems of every kind, good and bad: the result is the same, byte for byte, and calls from inside are refused.

#include "../../ffi/examples/job_system.hpp"
#include "pool.hpp"
#include "recording.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <random>
#include <shared_mutex>
#include <thread>
#include <trisap.hpp>
#include <utility>
#ifdef WITH_TBB
#include <trisap_jobs/tbb.hpp>
#endif
#ifdef WITH_ENKITS
#include <TaskScheduler.cpp>
#include <trisap_jobs/enkits.hpp>
#endif

enum { OBJECTS = 6000, STEPS = 6 };

static std::vector<trisap::Aabb> scene(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<trisap::Aabb> boxes(OBJECTS);
    for (trisap::Aabb &aabb : boxes) {
        for (int k = 0; k < 3; k++) {
            aabb.min[k] = static_cast<float>(random() % 4000) / 100.0f;
            aabb.max[k] = aabb.min[k] + static_cast<float>(random() % 300) / 100.0f;
        }
    }
    return boxes;
}

/// The whole memory of a world after some steps. The header is left out: it says who is inside.
static std::vector<unsigned char> play(const trisap_jobs *jobs) {
    trisap_config config = trisap_default_config(OBJECTS);
    config.pairs = 40 * OBJECTS;
    config.events = 1;
    config.workers = 8;
    const std::size_t bytes = trisap_world_size(&config);
    void *memory = std::aligned_alloc(trisap_world_align(), bytes);
    trisap_world *world = nullptr;
    CHECK_OK(trisap_world_init(memory, bytes, &config, &world));
    std::vector<trisap_id> ids(OBJECTS);
    std::vector<trisap::Aabb> boxes = scene(1);
    trisap_boxes view = trisap_default_boxes(boxes.data(), boxes.size());
    CHECK_OK(trisap_world_insert_many(world, &view, ids.data()));
    trisap_result result = trisap_default_result();
    std::vector<unsigned char> bytes_seen;
    for (unsigned step = 0; step < STEPS; step++) {
        const std::vector<trisap::Aabb> moved = scene(1 + step / 2);
        std::copy(moved.begin(), moved.end(), boxes.begin()); // the view stays valid
        CHECK_OK(trisap_world_step_over(world, &view, jobs, &result));
        CHECK(result.pair_count > OBJECTS / 2);
        const auto keep = [&bytes_seen](const trisap_pair *pairs, std::size_t count) {
            const auto *first = reinterpret_cast<const unsigned char *>(pairs);
            bytes_seen.insert(bytes_seen.end(), first, first + count * sizeof(trisap_pair));
        };
        keep(result.pairs, result.pair_count);
        keep(result.found, result.found_count);
        keep(result.lost, result.lost_count);
    }
    CHECK_OK(trisap_world_validate(world));
    std::free(memory);
    return bytes_seen;
}

template <class ForkJoin> static std::vector<unsigned char> play(std::uint32_t workers, ForkJoin fork_join) {
    auto jobs = trisap::jobs(workers, fork_join);
    const trisap_jobs c = jobs.c();
    return play(&c);
}

/// A rule and batches of queries, on many threads: the same as on one, and as brute force.
static void rule_and_queries() {
    const std::vector<trisap::Aabb> boxes = scene(7);
    trisap::Config config = trisap::config(OBJECTS);
    config.pairs = 40 * OBJECTS;
    config.filters = 1;
    config.workers = 4;
    trisap::World world;
    CHECK_OK(world.init(config));
    std::vector<trisap::Id> ids(OBJECTS);
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    Pool pool(4);
    int calls = 0;
    auto jobs = trisap::jobs(pool.workers(), [&](std::uint32_t count, trisap::Task task) {
        calls++;
        pool.run(count, task);
    });
    // Pairs of slots that differ in no low bit do not meet.
    std::atomic<std::size_t> asked = 0;
    const auto rule = [&asked](std::uint32_t a, std::uint32_t b) {
        CHECK(a < b);
        asked++;
        return ((a ^ b) & 3) != 0;
    };
    const trisap::Step step = world.step_with_rule(rule, jobs);
    CHECK_OK(step.status);
    std::vector<SlotPair> expected;
    std::size_t overlapping = 0;
    for (std::uint32_t a = 0; a < OBJECTS; a++) {
        for (std::uint32_t b = a + 1; b < OBJECTS; b++) {
            if (share_a_point(boxes[a].min, boxes[a].max, boxes[b].min, boxes[b].max)) {
                overlapping++;
                if (((a ^ b) & 3) != 0) {
                    expected.emplace_back(a, b);
                }
            }
        }
    }
    CHECK(sorted(step.pairs) == expected);
    CHECK(calls > 0 && asked == overlapping);

    std::mt19937 random(3);
    const auto within = [&random](float end) { return static_cast<float>(random() % 10000) * end / 10000.0f; };
    // More than are handed out at once; queries inside of larger items.
    struct Question {
        std::uint64_t name;
        trisap::Cast cast;
        trisap::Region region;
    };
    std::vector<Question> questions(1500);
    for (Question &question : questions) {
        const float at[3] = {within(40.0f), within(40.0f), within(40.0f)};
        const float to[3] = {within(2.0f) - 1.0f, within(2.0f) - 1.0f, within(2.0f) - 1.0f};
        question.cast = trisap::ray(at, to, within(30.0f));
        question.region = trisap::sphere(at, within(2.0f));
    }
    // Most answers come from the first ones.
    questions[0].region = trisap::sphere(boxes[0].min, 1000.0f);
    constexpr std::size_t room = 30;
    // Every second object, asked by all workers.
    const auto choose = [](void *user, trisap::Id id) -> std::uint32_t {
        static_cast<std::atomic<std::uint64_t> *>(user)->fetch_add(1, std::memory_order_relaxed);
        return trisap::slot(id) % 2;
    };
    std::atomic<std::uint64_t> chosen{0};
    const auto ask = [&](trisap_condition condition, const trisap_jobs *c, std::vector<trisap::Hit> &hits,
                         std::vector<trisap::Id> &found, std::vector<std::size_t> &ends) {
        hits.resize(questions.size());
        found.resize(questions.size() * room);
        ends.resize(questions.size());
        CHECK_OK(trisap_world_first_hits(world.c(), &questions[0].cast, sizeof(Question), questions.size(), condition,
                                         &chosen, c, hits.data()));
        CHECK_OK(trisap_world_overlaps_many(world.c(), &questions[0].region, sizeof(Question), questions.size(),
                                            condition, &chosen, c, found.data(), found.size(), ends.data()));
    };
    std::vector<trisap::Hit> hits, alone_hits;
    std::vector<trisap::Id> found, alone_found;
    std::vector<std::size_t> ends, alone_ends;
    ask(nullptr, nullptr, alone_hits, alone_found, alone_ends);
    calls = 0;
    const trisap_jobs c = jobs.c();
    ask(nullptr, &c, hits, found, ends);
    CHECK(calls >= 2 && ends == alone_ends && found == alone_found);
    std::vector<trisap::Id> fitting(ends.back());
    CHECK_OK(trisap_world_overlaps_many(world.c(), &questions[0].region, sizeof(Question), questions.size(), nullptr, nullptr, &c,
                                        fitting.data(), fitting.size(), ends.data()));
    CHECK(ends == alone_ends && std::equal(fitting.begin(), fitting.end(), found.begin()));
    std::size_t met = 0;
    for (std::size_t i = 0; i < questions.size(); i++) {
        const trisap::Hit first = world.first_hit(questions[i].cast);
        CHECK(hits[i].id == first.id && hits[i].distance == first.distance && alone_hits[i].id == first.id);
        std::vector<trisap::Id> around(OBJECTS);
        const trisap::Answers<trisap::Id> answers = world.overlaps(questions[i].region, around);
        const std::size_t start = i == 0 ? 0 : ends[i - 1];
        CHECK(answers && ends[i] - start == answers.size());
        CHECK(std::equal(answers.begin(), answers.end(), found.begin() + static_cast<std::ptrdiff_t>(start)));
        met += first.id != trisap::null_id;
    }
    CHECK(met > 100);

    ask(choose, &c, hits, found, ends);
    CHECK(chosen > 100);
    const auto is_odd = [](trisap::Id id) { return trisap::slot(id) % 2 == 1; };
    std::vector<trisap::Hit> all(OBJECTS);
    for (std::size_t i = 0; i < questions.size(); i++) {
        const trisap::Answers<trisap::Hit> way = world.hits(questions[i].cast, all);
        const auto first = std::find_if(way.begin(), way.end(), [&](const trisap::Hit &hit) { return is_odd(hit.id); });
        CHECK(hits[i].id == (first == way.end() ? trisap::null_id : first->id));
        const std::size_t start = i == 0 ? 0 : ends[i - 1], alone = i == 0 ? 0 : alone_ends[i - 1];
        std::vector<trisap::Id> odd;
        std::copy_if(alone_found.data() + alone, alone_found.data() + alone_ends[i], std::back_inserter(odd), is_odd);
        CHECK(ends[i] - start == odd.size() && std::equal(odd.begin(), odd.end(), found.data() + start));
    }
}

/// The job system of the example: who has come is waited for, who has not is not, and a long wait is followed by a time alone.
static void job_system_of_the_example(const std::vector<unsigned char> &expected) {
    for (unsigned workers : {2u, 3u, 8u}) {
        JobSystem system(workers);
        std::uint64_t calls = 0;
        CHECK(play(workers, [&](std::uint32_t count, trisap::Task task) {
                  calls++;
                  system.run(count, task.function(), task.argument());
              }) == expected);
        const JobSystem::Counts counts = system.counts();
        CHECK(calls > 0 && counts.shared + counts.alone == calls && counts.losses <= counts.shared);
    }

    struct Job {
        std::thread::id caller = std::this_thread::get_id();
        std::atomic<int> calls = 0;
        std::atomic<bool> late = false;
        bool meets = true;
    };
    JobSystem system(2);
    const auto run = [&system](Job &job) {
        const auto call = [](void *argument) {
            Job &its = *static_cast<Job *>(argument);
            its.calls++;
            while (its.meets && its.calls < 2) {
                std::this_thread::yield();
            }
            if (std::this_thread::get_id() != its.caller) {
                std::this_thread::sleep_for(std::chrono::milliseconds(20));
                its.late = true;
            }
        };
        system.run(2, call, &job);
    };
    Job first, second;
    run(first);
    CHECK(first.late && first.calls == 2); // returned only after the call that was late
    CHECK(system.counts().shared == 1 && system.counts().losses <= 1);
    second.meets = false;
    run(second);
    CHECK(second.calls == 1 || second.late); // alone, unless the time alone has been over by then
    CHECK(system.counts().shared + system.counts().alone == 2);
}

/// Threads look at a world at once, and none of them is refused; who would change it is refused meanwhile.
static void readers() {
    trisap::World world;
    CHECK_OK(world.init(trisap::config(OBJECTS)));
    std::vector<trisap::Id> ids(OBJECTS);
    const std::vector<trisap::Aabb> boxes = scene(1);
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    CHECK_OK(world.step().status);
    const trisap::World &seen = world;
    std::vector<trisap::Id> expected(OBJECTS);
    const trisap::Answers<trisap::Id> alone = seen.overlaps(trisap::region(boxes[7]), expected);
    CHECK(alone && alone.size() > 0);

    // All are inside of a visit at the same time.
    const unsigned count = 4;
    std::atomic<unsigned> inside = 0, done = 0;
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < count; i++) {
        threads.emplace_back([&] {
            bool first = true;
            const auto look = [&](trisap::Id) {
                if (std::exchange(first, false)) {
                    inside++;
                    while (inside < count) {
                        std::this_thread::yield();
                    }
                    std::vector<trisap::Id> room(OBJECTS);
                    const trisap::Answers<trisap::Id> same = seen.overlaps(trisap::region(boxes[7]), room);
                    CHECK(same && std::equal(same.begin(), same.end(), alone.begin(), alone.end()));
                    CHECK_STATUS(world.step().status, TRISAP_STATUS_BUSY);
                    CHECK_STATUS(world.update(ids[0], boxes[1]), TRISAP_STATUS_BUSY);
                    done++;
                    // Nobody leaves before all have asked.
                    while (done < count) {
                        std::this_thread::yield();
                    }
                }
            };
            CHECK_OK(seen.visit_overlaps(trisap::region(boxes[7]), look));
        });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }
    CHECK(done == count);
    CHECK_OK(world.step().status);
    CHECK_OK(world.validate());
}

/// One thread steps a world, others ask its last complete copy meanwhile: they are never refused, and what they hear is of one step.
static void readers_of_copies() {
    struct Copy {
        mutable std::shared_mutex mutex;
        trisap::World world;
        std::vector<trisap::Aabb> boxes;
    };
    std::array<Copy, 2> copies;
    std::atomic<std::size_t> last = 0, answers = 0;
    std::atomic<bool> done = false;
    trisap::Config config = trisap::config(OBJECTS);
    config.pairs = 40 * OBJECTS;
    config.workers = 2;
    trisap::World world;
    CHECK_OK(world.init(config));
    std::vector<trisap::Id> ids(OBJECTS);
    std::vector<trisap::Aabb> boxes = scene(1);
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    // Nobody has the older one, but for a reader that is late.
    const auto publish = [&] {
        Copy &copy = copies[1 - last];
        const std::unique_lock<std::shared_mutex> alone(copy.mutex);
        CHECK_OK(copy.world.copy_from(world));
        copy.boxes = boxes;
        last = 1 - last;
    };
    publish();
    const auto read = [&](unsigned seed) {
        std::mt19937 random(seed);
        std::vector<trisap::Id> room(OBJECTS), expected;
        while (!done) {
            const Copy &copy = copies[last];
            const std::shared_lock<std::shared_mutex> shared(copy.mutex);
            // For so long that the next step may be over meanwhile.
            for (int asked = 0; asked < 50; asked++, answers++) {
                const trisap::Aabb &about = copy.boxes[random() % OBJECTS];
                expected.clear();
                for (std::size_t i = 0; i < copy.boxes.size(); i++) {
                    if (share_a_point(about.min, about.max, copy.boxes[i].min, copy.boxes[i].max)) {
                        expected.push_back(ids[i]);
                    }
                }
                const trisap::Answers<trisap::Id> found = copy.world.overlaps(trisap::region(about), room);
                CHECK_OK(found.status);
                CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
            }
        }
    };
    std::thread first(read, 1), second(read, 2);
    Pool pool(2);
    std::size_t during = 0;
    for (unsigned step = 0; step < 2 * STEPS; step++) {
        boxes = scene(2 + step);
        bool waits = true;
        auto jobs = trisap::jobs(pool.workers(), [&](std::uint32_t count, trisap::Task task) {
            // The step is not over before somebody has asked.
            if (const std::size_t before = answers; std::exchange(waits, false)) {
                CHECK_STATUS(world.size().status, TRISAP_STATUS_BUSY);
                while (answers == before) {
                    std::this_thread::yield();
                }
                during++;
            }
            pool.run(count, task);
        });
        CHECK_OK(world.step_over(trisap::boxes(boxes), jobs).status);
        publish();
    }
    done = true;
    first.join();
    second.join();
    CHECK(during == 2 * STEPS);
}

#ifdef WITH_TBB
/// One arena, for a world of the calling thread and for several worlds in tasks of their own.
static void tasks_of_tbb(const std::vector<unsigned char> &expected) {
    for (int workers : {2, 4, 8}) {
        oneapi::tbb::task_arena arena(workers);
        const auto play_once = [&arena] {
            auto jobs = trisap::jobs_of(arena);
            const trisap_jobs c = jobs.c();
            return play(&c);
        };
        CHECK(play_once() == expected);
        std::vector<std::vector<unsigned char>> seen(5);
        arena.execute([&] {
            oneapi::tbb::task_group worlds;
            for (std::vector<unsigned char> &bytes : seen) {
                worlds.run([&bytes, &play_once] { bytes = play_once(); });
            }
            worlds.wait();
        });
        CHECK(std::all_of(seen.begin(), seen.end(), [&](const auto &bytes) { return bytes == expected; }));
    }
}
#endif

#ifdef WITH_ENKITS
/// One scheduler, for a world of the calling thread and for several worlds in tasks of their own.
static void tasks_of_enkits(const std::vector<unsigned char> &expected) {
    for (std::uint32_t workers : {1u, 2u, 4u, 8u}) {
        enki::TaskScheduler scheduler;
        scheduler.Initialize(workers);
        const auto play_once = [&scheduler] {
            auto jobs = trisap::jobs_of(scheduler);
            const trisap_jobs c = jobs.c();
            return play(&c);
        };
        CHECK(play_once() == expected);
        std::vector<std::vector<unsigned char>> seen(5);
        enki::TaskSet worlds(5, [&](enki::TaskSetPartition range, std::uint32_t) {
            std::generate(seen.begin() + range.start, seen.begin() + range.end, play_once);
        });
        scheduler.AddTaskSetToPipe(&worlds);
        scheduler.WaitforTask(&worlds);
        CHECK(std::all_of(seen.begin(), seen.end(), [&](const auto &bytes) { return bytes == expected; }));
    }
}
#endif

int main() {
    const std::vector<unsigned char> expected = play(nullptr);
#ifdef WITH_TBB
    tasks_of_tbb(expected);
#endif
#ifdef WITH_ENKITS
    tasks_of_enkits(expected);
#endif
    CHECK(play(1, [](std::uint32_t, trisap::Task) { CHECK(!"nobody to call"); }) == expected);

    std::atomic<int> calls = 0;
    for (std::uint32_t workers : {2u, 3u, 8u, 50u}) {
        Pool pool(std::min(workers, 8u));
        CHECK(play(workers, [&](std::uint32_t count, trisap::Task task) {
                  CHECK(count >= 2 && count <= workers && count <= 8);
                  calls++;
                  pool.run(count, task);
              }) == expected);
    }
    CHECK(calls > 0);

    job_system_of_the_example(expected);

    // Plain threads, made and joined; the function and its argument, as most job systems take them.
    CHECK(play(4, [](std::uint32_t count, trisap::Task task) {
              std::vector<std::thread> threads;
              for (std::uint32_t i = 0; i < count; i++) {
                  threads.emplace_back(task.function(), task.argument());
              }
              for (std::thread &thread : threads) {
                  thread.join();
              }
          }) == expected);

    // None of the work done, too much of it, one after the other.
    CHECK(play(8, [](std::uint32_t, trisap::Task) {}) == expected);
    CHECK(play(8, [](std::uint32_t count, trisap::Task task) {
              for (std::uint32_t i = 0; i < 3 * count; i++) {
                  task();
              }
          }) == expected);
    Pool pool(8);
    CHECK(play(8, [&pool](std::uint32_t count, trisap::Task task) { pool.run(5 * count, task); }) == expected);

    // A null task is nobody's.
    CHECK(play(2, [](std::uint32_t, trisap::Task task) { task.function()(nullptr); }) == expected);

    // Calls from inside a step are refused, and the step goes on.
    trisap::World world;
    trisap::Config config = trisap::config(OBJECTS);
    config.pairs = 40 * OBJECTS;
    config.workers = 2;
    CHECK_OK(world.init(config));
    std::vector<trisap::Id> ids(OBJECTS);
    const std::vector<trisap::Aabb> boxes = scene(1);
    CHECK_OK(world.insert(trisap::boxes(boxes), ids));
    int refused = 0;
    auto meddling = trisap::jobs(2, [&](std::uint32_t, trisap::Task) {
        CHECK_STATUS(world.update(ids[0], boxes[1]), TRISAP_STATUS_BUSY);
        CHECK_STATUS(world.step().status, TRISAP_STATUS_BUSY);
        CHECK(world.size() == 0 && world.insert(boxes[0]) == trisap::null_id);
        refused++;
    });
    const trisap::Step step = world.step(meddling);
    CHECK_OK(step.status);
    CHECK(refused > 0);
    std::vector<PaddedBox> padded;
    for (const trisap::Aabb &aabb : boxes) {
        padded.push_back({{aabb.min[0], aabb.min[1], aabb.min[2], 0}, {aabb.max[0], aabb.max[1], aabb.max[2], 0}});
    }
    CHECK(sorted(step.pairs) == brute_force(padded));
    CHECK(world.size() == OBJECTS);
    CHECK_OK(world.validate());
    rule_and_queries();
    readers();
    readers_of_copies();
    std::printf("jobs: the same %zu bytes from every job system\n", expected.size());
    return 0;
}
