/* An agreement is an exchange of everybody's errors. */
#include "base/team.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct verdict {
    uint32_t process;
    bool ok;
    char machine[256];
    rk_error error;
} verdict;

bool rk_team_agree(rk_team *team, bool ok, rk_error *error)
{
    if (!team)
        return ok;
    void *all = NULL;
    uint32_t count = 0;
    verdict own = {.process = team->process, .ok = ok, .error = {""}};
    memcpy(own.machine, team->machine, sizeof own.machine);
    if (!ok)
        own.error = *error;
    if (!team->exchange(team->context, &own, 1, sizeof own, &all, &count, error))
        return false;
    const verdict *verdicts = all;
    for (uint32_t i = 0; ok && i < count; i++)
        ok = verdicts[i].ok;
    for (uint32_t i = count; !ok && i-- > 0;)
        if (!verdicts[i].ok)
            own = verdicts[i];
    free(all);
    if (ok)
        return true;
    team->is_over = true;
    if (team->processes == 1)
        return false;
    return rk_fail(error, "process %u on %s: %s", own.process, own.machine, own.error.text);
}
