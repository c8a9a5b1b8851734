/* Objects that are kept: trees, meshes and maps are sent to the unit's process once in a lap, and
 * named by calls. To see whether one is still the same costs little where its pages cannot be
 * written to. */
#ifndef RK_TESTS_JUDGE_KEPT_H
#define RK_TESTS_JUDGE_KEPT_H

#include "judge/judge.h"

enum { RK_JUDGE_KEPT_SLOTS = 8 }; /* parameters of a call that take such objects */

void rk_judge_begin_objects(void);

/* Bytes that the objects of this call take at most. */
size_t rk_judge_object_bytes(void);

/* Sends the objects of this call that the unit's process lacks. */
void rk_judge_publish_objects(void);

/* Whether it lacks none. */
bool rk_judge_objects_are_there(void);

/* Notes an object that was sent. */
void rk_judge_object_is_there(uint64_t id, size_t bytes);

#endif
