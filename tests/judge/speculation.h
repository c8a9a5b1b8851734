/* A judge that goes on with the reference's answers while it waits for the unit's: see judge.h. */
#ifndef RK_TESTS_JUDGE_SPECULATION_H
#define RK_TESTS_JUDGE_SPECULATION_H

#include "judge/judge.h"

/* Before any call. */
void rk_judge_prepare_speculation(void);

/* Whether a speculation may begin or go on with this call. Never after one that was wrong. */
bool rk_judge_may_speculate(const rk_judge_request *head);

/* Returns in this process, which speculates, and, if the speculation turns out to be wrong, once
 * more in its fork, which does not: false there, and if there can be no fork. */
bool rk_judge_begin_speculation(void);

/* Waits for the unit's answers. Returns only if they are all the reference's. */
void rk_judge_end_speculation(void);

/* An answer is another one: the fork goes on, and its end is that of this process. */
_Noreturn void rk_judge_retreat(void);

/* Whether a speculation was wrong. */
bool rk_judge_was_wrong(void);

#endif
