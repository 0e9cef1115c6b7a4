// What Box3D's broad phase asks of trisap: who meets whom since the last step, by the indices of shapes. `box3d.patch` calls it; Box3D
// keeps its trees for rays and other queries.

#ifndef TRISAP_BOX3D_H
#define TRISAP_BOX3D_H

#include "box3d/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct trisap_box3d trisap_box3d;

typedef struct trisap_box3d_pair {
    int a, b;
} trisap_box3d_pair;

trisap_box3d *trisap_box3d_create(void);
void trisap_box3d_destroy(trisap_box3d *world);

/// Notes a shape, new or with another filter: `trisap_box3d_added` tells it before the next step.
void trisap_box3d_add(trisap_box3d *world, int shape);
const int *trisap_box3d_added(trisap_box3d *world, int *count);
/// Takes in a shape that was added, unless it was already.
void trisap_box3d_insert(trisap_box3d *world, int shape, b3BodyType type, bool is_sensor, b3Filter filter, b3AABB box);
void trisap_box3d_remove(trisap_box3d *world, int shape);
/// The box of a shape for the next step.
void trisap_box3d_move(trisap_box3d *world, int shape, b3AABB box);

/// Calls `run(task)` so many times, on any threads.
typedef void trisap_box3d_fork_join(void *user, void (*run)(void *task), void *task, uint32_t count);
/// Pairs that overlap now and did not at the last step, and all that were kept, in the order of their indices.
const trisap_box3d_pair *trisap_box3d_step(trisap_box3d *world, int workers, trisap_box3d_fork_join *fork_join, void *user, int *count);
/// Has the next step tell an overlapping pair once more: one that has no contact, but may get one when one of the two moves.
void trisap_box3d_keep(trisap_box3d *world, int shape_a, int shape_b);

/// Ends the program where two searches have found other pairs.
void trisap_box3d_compare(uint64_t *ours, int count, uint64_t *theirs, int their_count);

#ifdef __cplusplus
}
#endif

#endif
