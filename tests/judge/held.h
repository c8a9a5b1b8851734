/* In a predictor, or a judge that speculates: requests in which answers of the reference can be
 * read are held until the unit has given the same answers itself. Where it gives another one, a
 * predictor leaves them out, and a judge speculates no more. */
#ifndef RK_TESTS_JUDGE_HELD_H
#define RK_TESTS_JUDGE_HELD_H

#include "judge/judge.h"

enum { RK_JUDGE_HELD_MAX = 2048 }; /* calls that are waited for */

/* Before there are predictors. `after` is what holds in this test (see judge.h). */
void rk_judge_begin_holding(const uint64_t after[RK_JUDGE_FUNCTIONS]);

/* For the judge: whether its predictor may hold this call's request. A predictor that has ended
 * holds none. */
bool rk_judge_may_hold(uint64_t call);
void rk_judge_forget_held(void);

/* The call takes the answer of the request at this place, which has one. The judge or a predictor
 * copies it first, and the other one takes the same: a unit that sees by what is published whether
 * its answer was right can change it no more. */
void rk_judge_take_answer(size_t place);

/* In a predictor: what is to be done with a request. */
typedef enum rk_judge_way {
    RK_JUDGE_PUBLISH,
    RK_JUDGE_HOLD,
    RK_JUDGE_LEAVE_OUT,
} rk_judge_way;
rk_judge_way rk_judge_way_of(const rk_judge_request *head);

/* Notes the call whose answer the reference gives next; `place` is that of its request, if it has
 * one. There is room for it unless rk_judge_holds_all. */
void rk_judge_hold(const rk_judge_request *head, rk_judge_way way, size_t place);
bool rk_judge_holds_all(const rk_judge_request *head);
bool rk_judge_can_hold(const rk_judge_request *head); /* when nothing else is held */

/* Publishes what can be published by now, or waits until there is nothing left to wait for. */
void rk_judge_settle(void);
void rk_judge_settle_all(void);

#endif
