// Bodies, shapes, filters and joints come, go and change between Box3D's steps, where trisap and Box3D's own search are compared in each
// step (`shadow`), or a recording that begins from a snapshot has to be repeated to the bit.

#include "../check.h"

#include "box3d/box3d.h"

#include <string.h>

enum { BODIES = 120, SHAPES = 3, JOINTS = 60, STEPS = 400 };

static b3WorldId world;
static struct body {
    b3BodyId id;
    b3ShapeId shapes[SHAPES];
    int shape_count;
    bool is_static_only;
} bodies[BODIES];
static struct joint {
    b3JointId id;
    bool collides;
} joints[JOINTS];
static b3CompoundData *compound;
static b3MeshData *mesh;
static unsigned long long state = 1;
static int frame;

static unsigned below(unsigned end) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(state >> 33) % end;
}

static float between(float low, float high) { return low + (high - low) * (float)below(1024) / 1024; }

static b3Filter any_filter(void) {
    b3Filter filter = b3DefaultFilter();
    if (below(3) == 0) {
        filter.categoryBits = 1ull << below(64);
        filter.maskBits = below(2) ? ~0ull : ~(0xffffull << below(64));
    }
    filter.groupIndex = below(4) == 0 ? (int)below(5) - 2 : 0;
    return filter;
}

static void add_shape(struct body *body) {
    if (body->shape_count == SHAPES) {
        return;
    }
    b3ShapeDef def = b3DefaultShapeDef();
    def.filter = any_filter();
    def.isSensor = below(8) == 0;
    def.enableSensorEvents = below(2);
    def.invokeContactCreation = below(2);
    def.enableCustomFiltering = below(4) == 0;
    b3Vec3 at = {between(-0.5f, 0.5f), between(-0.5f, 0.5f), between(-0.5f, 0.5f)};
    b3ShapeId *shape = &body->shapes[body->shape_count];
    switch (below(3)) {
    case 0: {
        b3BoxHull hull = b3MakeOffsetBoxHull(between(0.1f, 0.8f), between(0.1f, 0.8f), between(0.1f, 0.8f), at);
        *shape = b3CreateHullShape(body->id, &def, &hull.base);
        break;
    }
    case 1: {
        b3Capsule capsule = {at, {0, 0.4f, 0}, between(0.1f, 0.4f)};
        *shape = b3CreateCapsuleShape(body->id, &def, &capsule);
        break;
    }
    default: {
        b3Sphere sphere = {at, between(0.1f, 0.6f)};
        *shape = b3CreateSphereShape(body->id, &def, &sphere);
    }
    }
    body->shape_count++;
}

static b3Pos any_place(void) { return (b3Pos){between(-6, 6), between(0.5f, 6), between(-6, 6)}; }

static void add_body(struct body *body) {
    b3BodyDef def = b3DefaultBodyDef();
    const unsigned kind = below(10);
    def.type = kind < 2 ? b3_staticBody : kind < 3 ? b3_kinematicBody : b3_dynamicBody;
    def.isBullet = below(8) == 0;
    def.position = any_place();
    def.linearVelocity = (b3Vec3){between(-9, 9), between(-9, 9), between(-9, 9)};
    *body = (struct body){.id = b3CreateBody(world, &def)};
    if (def.type == b3_staticBody && below(3) == 0) {
        body->is_static_only = true;
        b3ShapeDef shape = b3DefaultShapeDef();
        if (below(2)) {
            b3CreateMeshShape(body->id, &shape, mesh, b3Vec3_one);
        } else {
            b3CreateBakedCompoundShape(body->id, &shape, compound);
        }
        return;
    }
    for (unsigned count = 1 + below(SHAPES); count > 0; count--) {
        add_shape(body);
    }
}

static void remove_body(struct body *body) {
    b3DestroyBody(body->id);
    body->id = b3_nullBodyId;
}

/// Changes its mind, as games do.
static bool let_through(b3ShapeId a, b3ShapeId b, void *user) {
    (void)user;
    return (a.index1 + b.index1 + frame / 16) % 2 == 0;
}

static void change(void) {
    struct body *body = &bodies[below(BODIES)];
    if (B3_IS_NULL(body->id)) {
        add_body(body);
        return;
    }
    b3ShapeId *shape = body->shape_count > 0 ? &body->shapes[below(body->shape_count)] : NULL;
    switch (below(12)) {
    case 0:
        remove_body(body);
        break;
    case 1:
        if (!body->is_static_only) {
            add_shape(body);
        }
        break;
    case 2:
        if (shape != NULL) {
            b3DestroyShape(*shape, true);
            *shape = body->shapes[--body->shape_count];
        }
        break;
    case 3:
    case 4:
        if (shape != NULL) {
            b3Shape_SetFilter(*shape, any_filter(), below(2));
        }
        break;
    case 5:
        if (!body->is_static_only) {
            b3Body_SetType(body->id, (b3BodyType)below(3));
        }
        break;
    case 6:
        b3Body_IsEnabled(body->id) ? b3Body_Disable(body->id) : b3Body_Enable(body->id);
        break;
    case 7:
        b3Body_SetTransform(body->id, any_place(), b3MakeQuatFromAxisAngle(b3Vec3_axisY, between(0, 3)));
        break;
    case 8:
        if (shape != NULL) {
            b3Sphere sphere = {{0, 0, 0}, between(0.1f, 1)};
            b3Shape_SetSphere(*shape, &sphere);
        }
        break;
    case 9:
        if (b3Body_IsEnabled(body->id)) {
            b3Body_SetAwake(body->id, below(2));
        }
        break;
    default: {
        struct joint *joint = &joints[below(JOINTS)];
        struct body *other = &bodies[below(BODIES)];
        if (!b3Joint_IsValid(joint->id)) {
            if (other != body && !B3_IS_NULL(other->id)) {
                b3SphericalJointDef def = b3DefaultSphericalJointDef();
                def.base.bodyIdA = body->id;
                def.base.bodyIdB = other->id;
                def.base.collideConnected = joint->collides = below(2);
                joint->id = b3CreateSphericalJoint(world, &def);
            }
        } else if (below(3) == 0) {
            b3DestroyJoint(joint->id, below(2));
        } else {
            joint->collides = !joint->collides;
            b3Joint_SetCollideConnected(joint->id, joint->collides);
        }
    }
    }
}

int main(int count, char **words) {
    const int worlds = count > 1 ? atoi(words[1]) : 4;
    b3CompoundSphereDef spheres[16];
    memset(spheres, 0, sizeof spheres);
    b3SurfaceMaterial material = b3DefaultSurfaceMaterial();
    for (int i = 0; i < 16; i++) {
        spheres[i].sphere = (b3Sphere){{2.0f * (i % 4) - 3, 0, 2.0f * (i / 4) - 3}, 0.7f};
        spheres[i].material = material;
    }
    compound = b3CreateCompound(&(b3CompoundDef){.spheres = spheres, .sphereCount = 16});
    mesh = b3CreateGridMesh(4, 4, 1.5f, 1, true);
    CHECK(compound != NULL && mesh != NULL);
    for (int i = 0; i < worlds; i++) {
        b3WorldDef def = b3DefaultWorldDef();
        def.workerCount = 1 + i % 2;
        world = b3CreateWorld(&def);
        memset(bodies, 0, sizeof bodies);
        memset(joints, 0, sizeof joints);
        // Callbacks are not part of a recording.
        const bool is_recorded = i % 2 == 1;
        if (!is_recorded) {
            b3World_SetCustomFilterCallback(world, let_through, NULL);
        }
        b3Recording *recording = b3CreateRecording(1 << 20);
        for (frame = 0; frame < STEPS; frame++) {
            if (is_recorded && frame == STEPS / 2) {
                b3World_StartRecording(world, recording);
            }
            for (unsigned changes = frame == 0 ? 3 * BODIES : below(6); changes > 0; changes--) {
                change();
            }
            b3World_Step(world, 1.0f / 60, 4);
        }
        if (is_recorded) {
            b3World_StopRecording(world);
            CHECK(b3ValidateReplay(b3Recording_GetData(recording), b3Recording_GetSize(recording), 1));
        }
        printf("life %d: %d contacts\n", i, b3World_GetCounters(world).contactCount);
        b3DestroyRecording(recording);
        b3DestroyWorld(world);
    }
    b3DestroyCompound(compound);
    b3DestroyMesh(mesh);
    return 0;
}
