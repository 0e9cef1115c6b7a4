// trisap on the task callbacks of Box3D, of both kinds: one starts threads, one runs the task in the call.

#include "scene.hpp"

#include <thread>
#include <trisap_jobs/box3d.hpp>

static int started, finished;

static void *start(b3TaskCallback *task, void *task_context, void *user, const char *name) {
    CHECK(user == &started && std::strcmp(name, "trisap step") == 0);
    started++;
    return new std::thread(task, task_context);
}

static void finish(void *task, void *user) {
    CHECK(user == &started);
    finished++;
    static_cast<std::thread *>(task)->join();
    delete static_cast<std::thread *>(task);
}

static void *run_now(b3TaskCallback *task, void *task_context, void *, const char *) {
    task(task_context);
    return nullptr;
}

int main() {
    check_same_pairs(trisap::jobs_of(4, start, finish, &started));
    CHECK(started > 0 && started == finished);
    check_same_pairs(trisap::jobs_of(4, run_now, finish, nullptr));
    CHECK(started == finished);
    return 0;
}
