/* The requests of a lap that were published, most of them ahead: a call takes the one that is its
 * own. */
#ifndef RK_TESTS_JUDGE_PUBLISHED_H
#define RK_TESTS_JUDGE_PUBLISHED_H

#include "judge/judge.h"

/* Finds a request that was published, and that no call has taken. */
bool rk_judge_find(const rk_judge_request *head, size_t *place);

/* The call takes the answer of the request at this place. */
void rk_judge_take(size_t place);

/* All that were published so far have been taken. */
void rk_judge_skip_published(void);

/* Looks at all requests that the predictor has published. */
void rk_judge_look_at_all(void);

#endif
