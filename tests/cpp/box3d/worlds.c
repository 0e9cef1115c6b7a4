// The benchmark worlds of Box3D (`shared/benchmarks.c` there, by Erin Catto, MIT licence), made anew from their measures; the people of
// `rain` are simpler. Compiled once with Box3D as it is and once with trisap in it: see `steps.cpp`.

#include "worlds.h"

#include "box3d/box3d.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

static b3WorldId world;
static int world_size;

static b3BodyId body_at(b3BodyType type, float x, float y, float z) {
    b3BodyDef def = b3DefaultBodyDef();
    def.type = type;
    def.position = (b3Pos){x, y, z};
    return b3CreateBody(world, &def);
}

static void add_box(b3BodyId body, float x, float y, float z, float density) {
    b3BoxHull hull = b3MakeBoxHull(x, y, z);
    b3ShapeDef def = b3DefaultShapeDef();
    def.density = density;
    b3CreateHullShape(body, &def, &hull.base);
}

static void ground(float half) { add_box(body_at(b3_staticBody, 0, -1, 0), half, 1, half, 1000); }

/// One after the other, as Box3D's numbers of that name.
static float random_half(unsigned *state) {
    *state = *state * 2147001325u + 715136305u;
    return (float)(*state & 0xffff) / 65535.0f - 0.5f;
}

static void convex_pile(void) {
    ground(250);
    b3Vec3 points[32];
    unsigned state = 42;
    for (int i = 0; i < 32; i++) {
        b3Vec3 p;
        do {
            p.x = random_half(&state);
            p.y = random_half(&state);
            p.z = random_half(&state);
        } while (b3Dot(p, p) > 0.25f);
        points[i] = b3MulSV(2, b3Normalize(p));
    }
    b3HullData *hull = b3CreateHull(points, 32, 32);
    b3ShapeDef def = b3DefaultShapeDef();
    const int layers = world_size ? world_size : 80;
    for (int layer = 0; layer < layers; layer++) {
        for (int z = 0; z < 8; z++) {
            for (int x = 0; x < 8; x++) {
                b3CreateHullShape(body_at(b3_dynamicBody, 4.0f * (x - 4), 2 + 4.0f * layer, 4.0f * (z - 4)), &def, hull);
            }
        }
    }
    b3DestroyHull(hull);
}

static b3BodyId pusher;
static float degrees;

static void junkyard(void) {
    b3BodyId yard = body_at(b3_staticBody, 0, -1, 0);
    b3ShapeDef def = b3DefaultShapeDef();
    add_box(yard, 120, 1, 120, 1000);
    for (int side = 0; side < 4; side++) {
        const float far = side % 2 ? 50 : -50;
        b3BoxHull wall = side < 2 ? b3MakeOffsetBoxHull(1, 8, 50, (b3Vec3){far, 8, 0}) : b3MakeOffsetBoxHull(50, 8, 1, (b3Vec3){0, 8, far});
        b3CreateHullShape(yard, &def, &wall.base);
    }
    b3HullData *rock = b3CreateRock(1.5f);
    const int layers = world_size ? world_size : 24;
    for (int y = 0; y < layers; y++) {
        for (int x = 0; x <= 20; x++) {
            for (int z = 0; z <= 20; z++) {
                b3CreateHullShape(body_at(b3_dynamicBody, 4.0f * (x - 10), 4.0f * y + 25, 4.0f * (z - 10)), &def, rock);
            }
        }
    }
    b3DestroyHull(rock);
    b3HullData *cylinder = b3CreateCylinder(24, 4, 0, 16);
    pusher = body_at(b3_kinematicBody, 35, 0, 0);
    degrees = 0;
    b3CreateHullShape(pusher, &def, cylinder);
    b3DestroyHull(cylinder);
}

static void push(int step) {
    (void)step;
    degrees -= 0.1f;
    const b3CosSin turn = b3ComputeCosSin(degrees * B3_PI / 180);
    const b3WorldTransform target = {.p = {35 * turn.cosine, 0, 35 * turn.sine}, .q = b3Quat_identity};
    b3Body_SetTargetTransform(pusher, target, 1.0f / 60, false);
}

/// A piece of the drum between two radii.
static void add_segment(b3BodyId drum, float inner, float outer, b3Vec3 from, b3Vec3 to) {
    b3Vec3 points[8];
    for (int i = 0; i < 8; i++) {
        points[i] = b3MulAdd((b3Vec3){0, 0, i < 4 ? -10.0f : 10.0f}, i & 1 ? outer : inner, i & 2 ? to : from);
    }
    b3HullData *hull = b3CreateHull(points, 8, 8);
    b3ShapeDef def = b3DefaultShapeDef();
    b3CreateHullShape(drum, &def, hull);
    b3DestroyHull(hull);
}

static void washer(void) {
    ground(60);
    b3BodyDef def = b3DefaultBodyDef();
    def.type = b3_kinematicBody;
    def.position = (b3Pos){0, 21, 0};
    def.angularVelocity.z = 25 * B3_PI / 180;
    def.linearVelocity = (b3Vec3){0.001f, -0.002f, 0};
    b3BodyId drum = b3CreateBody(world, &def);
    const b3Quat wide = b3MakeQuatFromAxisAngle(b3Vec3_axisZ, 0.1f * B3_PI / 18), turn = b3MakeQuatFromAxisAngle(b3Vec3_axisZ, B3_PI / 18);
    b3Vec3 from = {1, 0, 0};
    for (int i = 0; i < 36; i++) {
        const b3Vec3 to = i == 35 ? (b3Vec3){1, 0, 0} : b3RotateVector(turn, from);
        add_segment(drum, 16, 18, b3InvRotateVector(wide, from), b3RotateVector(wide, to));
        if (i % 9 == 0) {
            add_segment(drum, 14, 16, from, to);
        }
        from = to;
    }
    const int side = world_size ? world_size : 20;
    const float first = -0.4f * side;
    for (int x = 0; x < side; x++) {
        for (int y = 0; y < side; y++) {
            for (int z = 0; z < side; z++) {
                add_box(body_at(b3_dynamicBody, first + 0.8f * x, first + 21 + 0.8f * y, first + 0.8f * z), 0.2f, 0.2f, 0.2f, 1000);
            }
        }
    }
}

static void pyramid(int base, float x, float z) {
    for (int i = 0; i < base; i++) {
        for (int j = i; j < base; j++) {
            b3BodyDef def = b3DefaultBodyDef();
            def.type = b3_dynamicBody;
            def.enableSleep = false;
            def.position = (b3Pos){0.5f * (i + 1) + (j - i) + x, i + 0.5f, z};
            add_box(b3CreateBody(world, &def), 0.5f, 0.5f, 0.5f, 100);
        }
    }
}

static void large_pyramid(void) {
    ground(400);
    const int base = world_size ? world_size : 100;
    pyramid(base, -0.5f * base, 0);
}

static void many_pyramids(void) {
    const int side = world_size ? world_size : 14;
    const float half = 5.5f * side;
    ground(half);
    for (int i = 0; i < side; i++) {
        for (int j = 0; j < side; j++) {
            pyramid(10, -half + 11 * j + 0.5f, -half + 1 + i * 2 * (half - 1) / (side - 1));
        }
    }
}

static void joint_grid(void) {
    b3World_EnableSleeping(world, false);
    const int side = world_size ? world_size : 100;
    b3BodyId *bodies = malloc(sizeof(b3BodyId) * side * side);
    b3ShapeDef def = b3DefaultShapeDef();
    def.filter.categoryBits = 2;
    def.filter.maskBits = ~2u;
    const b3Sphere sphere = {{0, 0, 0}, 0.4f};
    b3SphericalJointDef joint = b3DefaultSphericalJointDef();
    for (int i = 0; i < side * side; i++) {
        const int column = i / side, row = i % side;
        bodies[i] = body_at(row == 0 ? b3_staticBody : b3_dynamicBody, (float)column, (float)-row, 0);
        b3CreateSphereShape(bodies[i], &def, &sphere);
        joint.base.bodyIdB = bodies[i];
        if (row > 0) {
            joint.base.bodyIdA = bodies[i - 1];
            joint.base.localFrameA.p = (b3Vec3){0, -0.5f, 0};
            joint.base.localFrameB.p = (b3Vec3){0, 0.5f, 0};
            b3CreateSphericalJoint(world, &joint);
        }
        if (column > 0) {
            joint.base.bodyIdA = bodies[i - side];
            joint.base.localFrameA.p = (b3Vec3){0.5f, 0, 0};
            joint.base.localFrameB.p = (b3Vec3){-0.5f, 0, 0};
            b3CreateSphericalJoint(world, &joint);
        }
    }
    free(bodies);
}

/// A person of capsules: where each begins and ends, how thick it is, and which one holds it.
static const struct bone {
    float from[2], to[2], radius;
    int parent;
} bones[] = {
    {{-0.07f, 0.93f}, {0.07f, 0.93f}, 0.13f, -1},  {{-0.06f, 1.11f}, {0.06f, 1.11f}, 0.12f, 0},    {{-0.08f, 1.2f}, {0.08f, 1.2f}, 0.1f, 1},
    {{-0.11f, 1.31f}, {0.11f, 1.31f}, 0.145f, 2},  {{0, 1.58f}, {0, 1.62f}, 0.07f, 3},             {{0, 1.68f}, {0, 1.73f}, 0.0975f, 4},
    {{0.09f, 0.93f}, {0.1f, 0.56f}, 0.09f, 0},     {{0.1f, 0.5f}, {0.11f, 0.1f}, 0.075f, 6},       {{-0.09f, 0.93f}, {-0.1f, 0.56f}, 0.09f, 0},
    {{-0.1f, 0.5f}, {-0.11f, 0.1f}, 0.075f, 8},    {{0.2f, 1.48f}, {0.3f, 1.26f}, 0.075f, 3},      {{0.3f, 1.24f}, {0.44f, 1.0f}, 0.05f, 10},
    {{-0.2f, 1.48f}, {-0.3f, 1.26f}, 0.075f, 3},   {{-0.3f, 1.24f}, {-0.44f, 1.0f}, 0.05f, 12},
};
#define BONES (int)(sizeof bones / sizeof bones[0])
/// Cells of the ground by side, and people that fall on one.
#define CELLS (world_size ? world_size : 10)
#define PEOPLE 3
static b3BodyId (*people)[BONES];
static b3MeshData *grid, *torus;

static void rain(void) {
    grid = b3CreateGridMesh(8, 8, 15.0f / 8, 1, true);
    torus = b3CreateTorusMesh(16, 16, 3.75f, 1);
    people = calloc(PEOPLE * CELLS * CELLS, sizeof *people);
    b3ShapeDef def = b3DefaultShapeDef();
    for (int i = 0; i < CELLS * CELLS; i++) {
        b3BodyId body = body_at(b3_staticBody, 15 * (i / CELLS - 0.5f * (CELLS - 1)), 0, 15 * (i % CELLS - 0.5f * (CELLS - 1)));
        b3CreateMeshShape(body, &def, grid, b3Vec3_one);
        b3CreateMeshShape(body, &def, torus, b3Vec3_one);
    }
}

static void person(b3BodyId *bodies, float x, float z, int group) {
    b3SphericalJointDef joint = b3DefaultSphericalJointDef();
    joint.enableConeLimit = joint.enableTwistLimit = joint.enableSpring = joint.enableMotor = true;
    joint.coneAngle = 0.4f;
    joint.lowerTwistAngle = -0.3f;
    joint.upperTwistAngle = 0.3f;
    joint.hertz = 1;
    joint.dampingRatio = 0.7f;
    joint.maxMotorTorque = 5;
    for (int i = 0; i < BONES; i++) {
        const struct bone *bone = &bones[i];
        b3ShapeDef def = b3DefaultShapeDef();
        def.baseMaterial.rollingResistance = 0.2f;
        // As in the original: some parts of a person do not meet.
        def.filter.groupIndex = i == 1 || i == 6 || i == 8 ? -group : 0;
        const b3Capsule capsule = {{0, 0, 0}, {bone->to[0] - bone->from[0], bone->to[1] - bone->from[1], 0}, bone->radius};
        bodies[i] = body_at(b3_dynamicBody, x + bone->from[0], 20 + bone->from[1], z);
        b3CreateCapsuleShape(bodies[i], &def, &capsule);
        if (i > 0) {
            const struct bone *parent = &bones[bone->parent];
            joint.base.bodyIdA = bodies[bone->parent];
            joint.base.bodyIdB = bodies[i];
            joint.base.localFrameA.p = (b3Vec3){bone->from[0] - parent->from[0], bone->from[1] - parent->from[1], 0};
            b3CreateSphericalJoint(world, &joint);
        }
    }
    b3FilterJointDef legs = b3DefaultFilterJointDef();
    legs.base.bodyIdA = bodies[6];
    legs.base.bodyIdB = bodies[8];
    b3CreateFilterJoint(world, &legs);
}

/// Every 48 steps a column of cells gets people; when all have some, those of a column go and others come.
static void pour(int step) {
    if (step % 48 != 0) {
        return;
    }
    const int column = step / 48 % CELLS;
    for (int row = 0; row < CELLS; row++) {
        const int cell = row * CELLS + column;
        for (int i = 0; i < PEOPLE; i++) {
            b3BodyId *bodies = people[PEOPLE * cell + i];
            for (int k = 0; k < BONES && step / 48 >= CELLS; k++) {
                b3DestroyBody(bodies[k]);
            }
            person(bodies, 15 * (column + 0.5f - 0.5f * CELLS) + 0.75f * i, 15 * (row + 0.5f - 0.5f * CELLS), cell);
        }
    }
}

static const struct scene {
    const char *name;
    void (*make)(void);
    void (*before_step)(int step);
    b3Capacity capacity;
} scenes[] = {
    {"convex_pile", convex_pile, NULL, {.dynamicShapeCount = 5120, .dynamicBodyCount = 5120, .contactCount = 50 * 1024}},
    {"junkyard", junkyard, push, {16, 9601, 16, 9601, 250 * 1024}},
    {"rain", rain, pour, {0}},
    {"washer", washer, NULL, {16, 10000, 16, 10000, 60000}},
    {"large_pyramid", large_pyramid, NULL, {0}},
    {"many_pyramids", many_pyramids, NULL, {0}},
    {"joint_grid", joint_grid, NULL, {0}},
};

static const struct scene *scene;
static int steps, in_cpu_time;
static double pairs_time;

static double milliseconds(void) {
    struct timespec time;
    clock_gettime(in_cpu_time ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

struct b3World;
/// Called by Box3D in place of its own function, by the linker's `--wrap`.
void __real_b3UpdateBroadPhasePairs(struct b3World *of);
void __wrap_b3UpdateBroadPhasePairs(struct b3World *of) {
    const double start = milliseconds();
    __real_b3UpdateBroadPhasePairs(of);
    pairs_time = milliseconds() - start;
}

int worlds_begin(const char *name, int size, int workers, int cpu_time) {
    for (scene = scenes; strcmp(scene->name, name) != 0; scene++) {
        if (scene + 1 == scenes + sizeof scenes / sizeof scenes[0]) {
            return 0;
        }
    }
    in_cpu_time = cpu_time;
    world_size = size;
    steps = 0;
    b3WorldDef def = b3DefaultWorldDef();
    def.workerCount = workers;
    def.capacity = scene->capacity;
    world = b3CreateWorld(&def);
    scene->make();
    return 1;
}

struct worlds_figures worlds_step(void) {
    if (scene->before_step != NULL) {
        scene->before_step(steps);
    }
    steps++;
    const double start = milliseconds();
    b3World_Step(world, 1.0f / 60, 4);
    const double step_time = milliseconds() - start;
    const b3Counters counters = b3World_GetCounters(world);
    return (struct worlds_figures){step_time, pairs_time, counters.bodyCount, counters.contactCount};
}

void worlds_end(void) {
    b3DestroyWorld(world);
    if (scene->before_step == pour) {
        b3DestroyMesh(grid);
        b3DestroyMesh(torus);
        free(people);
    }
}
